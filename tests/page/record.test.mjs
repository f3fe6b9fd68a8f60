// Recording, replay data and files of the page (service/page/src/record), judged by slow references, by @mcap/core and
// by parsing what was written. Run: node --test record.test.mjs
import assert from 'node:assert/strict';
import test from 'node:test';
import { setFlagsFromString } from 'node:v8';
import { runInNewContext } from 'node:vm';
import { fromTests, load } from './support/setup.mjs';

const { McapIndexedReader, McapStreamReader } = fromTests('@mcap/core');
const { crc32: referenceCrc32 } = fromTests('@foxglove/crc');

const { Recorder } = await load('record/recorder.ts');
const { crc32 } = await load('record/crc32.ts');
const { shortest } = await load('record/text.ts');

// ---- Made up recordings, the same for the same seed

function random(seed) { // mulberry32: 0 <= x < 1
  let state = seed;
  return () => {
    state = (state + 0x6d2b79f5) | 0;
    let t = Math.imul(state ^ (state >>> 15), 1 | state);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 2 ** 32;
  };
}
const integer = (r, n) => Math.floor(r() * n);
const float = (r) => Math.fround((r() - 0.5) * 10 ** (integer(r, 7) - 3));
const vec3 = (r) => [float(r), float(r), float(r)];

const kBits = new DataView(new ArrayBuffer(4));
function anyFloat32(r) { // any bits: tiny, huge, not finite
  kBits.setUint32(0, integer(r, 2 ** 32));
  const value = kBits.getFloat32(0);
  return Number.isNaN(value) ? NaN : value; // every NaN the same: its other bits are not kept
}

const kChannels = [
  ['tip_x_m', 'm', 'position'],
  ['tip_y_m', 'm', 'position'],
  ['tip_z_m', 'm', 'position'],
  ['q_w', '', 'orientation'],
  ['q_x', '', 'orientation'],
  ['q_y', '', 'orientation'],
  ['q_z', '', 'orientation'],
  ['force_x_N', 'N', 'force'],
  ['force_y_N', 'N', 'force'],
  ['force_z_N', 'N', 'force'],
  ['current_x_A', 'A', 'current'],
];
const kPoseValid = { bit: 3, name: 'pose_valid' };

function makeHello(channels = kChannels) {
  return {
    type: 'hello',
    protocol: 1,
    version: '9.8.7',
    channels: channels.map(([name, unit, group]) => ({ name, unit, group, label: `label of ${name}` })),
    flags: [{ bit: 0, name: 'tracked' }, kPoseValid],
  };
}

function makeState(r) {
  const contact = () => ({
    object: integer(r, 2 ** 32),
    material: integer(r, 5),
    point: vec3(r),
    normal: vec3(r),
    force: vec3(r),
    slip: vec3(r),
    normal_N: float(r),
    tangential_N: float(r),
    penetration_m: float(r),
  });
  const vehicle = () => ({
    position: vec3(r),
    heading: float(r),
    speed_m_s: float(r),
    lap_s: float(r),
    last_lap_s: float(r),
    best_lap_s: r() < 0.2 ? Infinity : float(r),
    sliding: r() < 0.5,
    laps: integer(r, 9),
    hits: integer(r, 99),
  });
  return {
    flags: integer(r, 2 ** 32),
    lost: integer(r, 3),
    contacts: Array.from({ length: integer(r, 5) }, contact),
    vehicle: r() < 0.5 ? vehicle() : null,
    inputs: Array.from({ length: 9 }, () => ({ value: float(r), presses: integer(r, 2 ** 32), releases: 7 })),
    aim: { present: r() < 0.5, tip: vec3(r), axis: vec3(r) },
  };
}

function makeLive(state, times, channels, value) {
  const samples = new Float32Array(times.length * channels);
  for (let i = 0; i < samples.length; ++i) samples[i] = value(Math.floor(i / channels), i % channels);
  return { ...state, t_s: times.at(-1), count: times.length, times_s: Float64Array.from(times), samples };
}

// Messages of 1 to 40 samples about a millisecond apart, with gaps now and then.
function makeMessages(seed, { messages = 200, channels = kChannels.length, value = float, start_s = 1234.5 } = {}) {
  const r = random(seed);
  let t_s = start_s;
  return Array.from({ length: messages }, () => {
    if (r() < 0.02) t_s += 5 * r();
    const times = Array.from({ length: 1 + integer(r, 40) }, () => (t_s += 0.0005 + 0.001 * r()));
    return makeLive(makeState(r), times, channels, () => value(r));
  });
}

// Many messages, cheaply made: 1 kHz, 50 messages a second.
const kQuietState = {
  flags: 1,
  lost: 0,
  contacts: [],
  vehicle: null,
  inputs: Array.from({ length: 9 }, () => ({ value: 0, presses: 0, releases: 0 })),
  aim: { present: false, tip: [0, 0, 0], axis: [0, 0, -1] },
};
function addSeconds(recorder, channels, from_s, to_s, after = () => undefined) {
  const times_s = new Float64Array(20); // of one message after the other: the recorder copies
  const samples = new Float32Array(20 * channels);
  for (let m = Math.round(from_s * 50); m < Math.round(to_s * 50); ++m) {
    for (let i = 0; i < 20; ++i) times_s[i] = (20 * m + i + 1) / 1000;
    samples.fill(m);
    recorder.add({ ...kQuietState, t_s: times_s[19], count: 20, times_s, samples });
    after();
  }
}

function recorded(messages, hello = makeHello(), limits = {}) {
  const recorder = new Recorder(hello, limits);
  for (const message of messages) recorder.add(message);
  return recorder;
}

// All samples of messages: [{ t_s, values, message, isLast }]
function flat(messages) {
  return messages.flatMap((message) =>
    Array.from(message.times_s, (t_s, i) => {
      const channels = message.samples.length / message.count;
      const values = Array.from(message.samples.subarray(i * channels, (i + 1) * channels));
      return { t_s, values, message, index: i, isLast: i === message.count - 1 };
    }),
  );
}

// Lists of any length are the same. Not one deepEqual of the whole: what it prints of long ones takes minutes.
function assertSame(actual, expected) {
  assert.equal(actual.length, expected.length);
  for (let i = 0; i < expected.length; ++i) {
    if (!Object.is(actual[i], expected[i])) assert.deepEqual(actual[i], expected[i]);
  }
}

function assertSameRange(actual, expected) {
  assert.equal(actual.count, expected.count);
  assertSame(actual.times_s, expected.times_s);
  assertSame(actual.samples, expected.samples);
}

// ---- Readers

async function bytesOf(blob) {
  return new Uint8Array(await blob.arrayBuffer());
}

// RFC 4180, strictly: every row ends with CR LF and has as many fields as the first.
function parseCsv(text) {
  const rows = [];
  let row = [];
  const field = /(?:"((?:[^"]|"")*)"|([^",\r\n]*))(,|\r\n)/y;
  while (field.lastIndex < text.length) {
    const at = field.lastIndex;
    const match = field.exec(text);
    assert.ok(match, `not CSV at ${at}: ${text.slice(at, at + 40)}`);
    row.push(match[1] === undefined ? match[2] : match[1].replaceAll('""', '"'));
    if (match[3] === ',') continue;
    rows.push(row);
    row = [];
  }
  assert.equal(row.length, 0, 'ends in the middle of a row');
  for (const each of rows) assert.equal(each.length, rows[0].length);
  return { header: rows[0], rows: rows.slice(1) };
}

function decoded(message, channel) {
  const text = new TextDecoder('utf-8', { fatal: true }).decode(message.data);
  const { logTime: time, publishTime: publish, sequence } = message;
  return { topic: channel.topic, time, publish, sequence, text };
}

function readStream(bytes) {
  const reader = new McapStreamReader({ validateCrcs: true, includeChunks: true });
  const channels = new Map();
  const schemas = new Map();
  const records = [];
  const messages = [];
  const step = 100_003; // a stream comes in pieces
  for (let at = 0; at < bytes.length; at += step) {
    reader.append(bytes.subarray(at, at + step));
    for (let record; (record = reader.nextRecord()) !== undefined; ) {
      records.push(record);
      if (record.type === 'Schema') schemas.set(record.id, record);
      if (record.type === 'Channel') {
        assert.ok(schemas.has(record.schemaId), 'schemas come before their channels');
        channels.set(record.id, record);
      }
      if (record.type === 'Message') messages.push(decoded(record, channels.get(record.channelId)));
    }
  }
  assert.ok(reader.done(), 'a complete file');
  assert.equal(reader.bytesRemaining(), 0);
  return { records, messages, channels, schemas };
}

async function readIndexed(bytes, args = {}) {
  const readable = {
    size: async () => BigInt(bytes.length),
    read: async (offset, length) => bytes.slice(Number(offset), Number(offset + length)),
  };
  const reader = await McapIndexedReader.Initialize({ readable });
  const messages = [];
  for await (const message of reader.readMessages({ ...args, validateCrcs: true })) {
    messages.push(decoded(message, reader.channelsById.get(message.channelId)));
  }
  return { reader, messages };
}

const kExact = ['object', 'material', 'laps', 'hits', 'sliding', 'presses', 'releases']; // the others are float32

// What a file is to contain, in order: [topic, t_s, check of the parsed JSON].
function expectedMcap(messages, hello, from_s, to_s) {
  const names = hello.channels.map((channel) => channel.name);
  const column = (name) => names.indexOf(name);
  const same = (actual, expected) => {
    if (Number.isFinite(expected)) assert.equal(Math.fround(actual), expected);
    else assert.equal(actual, null);
  };
  const sameVector = (actual, expected) => ['x', 'y', 'z'].forEach((axis, i) => same(actual[axis], expected[i]));
  const sameFields = (actual, expected) => {
    assert.deepEqual(Object.keys(actual).sort(), Object.keys(expected).sort());
    for (const [key, value] of Object.entries(expected)) {
      if (Array.isArray(value)) sameVector(actual[key], value);
      else if (kExact.includes(key)) assert.equal(actual[key], value);
      else same(actual[key], value);
    }
  };
  return flat(messages).flatMap(({ t_s, values, message, isLast }) => {
    if (!(t_s >= from_s && t_s <= to_s)) return [];
    const telemetry = (json) => {
      assert.deepEqual(Object.keys(json), ['t_monotonic_s', ...names]);
      names.forEach((name, c) => same(json[name], values[c]));
    };
    const result = [['/omni/telemetry', t_s, telemetry]];
    if (!isLast) return result;
    result.push(['/omni/contacts', t_s, (json) => {
      assert.equal(json.contacts.length, message.contacts.length);
      message.contacts.forEach((contact, i) => sameFields(json.contacts[i], contact));
    }]);
    if (message.vehicle !== null) {
      result.push(['/omni/vehicle', t_s, ({ t_monotonic_s, ...json }) => sameFields(json, message.vehicle)]);
    }
    result.push(['/omni/inputs', t_s, ({ t_monotonic_s, ...json }) => {
      assert.equal(Object.keys(json).length, 9);
      Object.values(json).forEach((input, i) => sameFields(input, message.inputs[i]));
    }]);
    if (column('force_x_N') >= 0) {
      result.push(['/omni/force', t_s, (json) => {
        assert.equal(json.frame_id, 'omni_base');
        sameVector(json, ['force_x_N', 'force_y_N', 'force_z_N'].map((name) => values[column(name)]));
      }]);
    }
    const tip = ['tip_x_m', 'tip_y_m', 'tip_z_m'].map((name) => values[column(name)]);
    if (tip.every(Number.isFinite) && message.flags & (1 << kPoseValid.bit)) {
      result.push(['/omni/pen', t_s, (json) => {
        assert.equal(json.frame_id, 'omni_base');
        sameVector(json.pose.position, tip);
      }]);
    }
    return result;
  });
}

function checkMessages(actual, expected) {
  assert.equal(actual.length, expected.length);
  const offset = expected.length === 0 ? 0n : actual[0].time - BigInt(Math.round(expected[0][1] * 1e9));
  const sequences = {};
  expected.forEach(([topic, t_s, check], i) => {
    const message = actual[i];
    assert.equal(message.topic, topic);
    assert.equal(message.time, offset + BigInt(Math.round(t_s * 1e9)));
    assert.equal(message.publish, message.time);
    assert.equal(message.sequence, (sequences[topic] = (sequences[topic] ?? -1) + 1));
    const json = JSON.parse(message.text);
    assert.equal(json.t_monotonic_s, t_s);
    check(json);
  });
}

// The file as both readers see it, and everything that they do not check themselves.
async function checkMcap(bytes, expected, hello) {
  const stream = readStream(bytes);
  checkMessages(stream.messages, expected);
  const { reader, messages } = await readIndexed(bytes);
  assertSame(messages, stream.messages);

  assert.deepEqual({ ...reader.header, type: undefined }, {
    type: undefined,
    profile: '',
    library: `omni page ${hello.version}`,
  });
  const count = (type) => stream.records.filter((record) => record.type === type).length;
  const { statistics } = reader;
  assert.equal(statistics.messageCount, BigInt(expected.length));
  assert.equal(statistics.schemaCount, reader.schemasById.size);
  assert.equal(statistics.channelCount, reader.channelsById.size);
  assert.equal(statistics.chunkCount, count('Chunk'));
  assert.equal(statistics.attachmentCount + statistics.metadataCount, 0);
  assert.equal(statistics.messageStartTime, messages[0]?.time ?? 0n);
  assert.equal(statistics.messageEndTime, messages.at(-1)?.time ?? 0n);
  for (const [id, channel] of reader.channelsById) {
    const ofTopic = messages.filter((message) => message.topic === channel.topic);
    assert.equal(statistics.channelMessageCounts.get(id) ?? 0n, BigInt(ofTopic.length));
    assert.equal(channel.messageEncoding, 'json');
    assert.equal(reader.schemasById.get(channel.schemaId).encoding, 'jsonschema');
    if (channel.topic === '/omni/telemetry') continue; // most of what was read above
    const { messages: alone } = await readIndexed(bytes, { topics: [channel.topic] });
    assertSame(alone, ofTopic); // by the message indexes of this channel
  }
  assert.deepEqual(stream.channels, reader.channelsById); // the summary repeats the data section
  assert.deepEqual(stream.schemas, reader.schemasById);

  assert.ok(reader.dataSectionCrc !== undefined && reader.footer.summaryCrc !== 0);
  assert.equal(reader.dataSectionCrc, referenceCrc32(bytes.subarray(0, Number(reader.dataEndOffset))));
  const chunks = stream.records.filter((record) => record.type === 'Chunk');
  assert.equal(reader.chunkIndexes.length, chunks.length);
  chunks.forEach((chunk, i) => {
    assert.notEqual(chunk.uncompressedCrc, 0);
    assert.equal(chunk.compression, '');
    assert.ok(chunk.records.length < 1.1 * 2 ** 20);
    const next = i + 1 < chunks.length ? stream.records.indexOf(chunks[i + 1]) : stream.records.length;
    const own = stream.records.slice(stream.records.indexOf(chunk), next).filter(({ type }) => type === 'Message');
    for (const { messageStartTime, messageEndTime } of [chunk, reader.chunkIndexes[i]]) {
      assert.deepEqual([messageStartTime, messageEndTime], [own[0].logTime, own.at(-1).logTime]);
    }
  });
  // Every summary offset is of records of its kind, and together they are the whole summary.
  const view = new DataView(bytes.buffer, bytes.byteOffset);
  let at = reader.footer.summaryStart;
  for (const { groupOpcode, groupStart, groupLength } of reader.summaryOffsetsByOpcode.values()) {
    assert.equal(groupStart, at);
    for (at = groupStart; at < groupStart + groupLength; at += 9n + view.getBigUint64(Number(at) + 1, true)) {
      assert.equal(bytes[Number(at)], groupOpcode);
    }
    assert.equal(at, groupStart + groupLength);
  }
  assert.equal(at, reader.footer.summaryOffsetStart);
  return { reader, stream };
}

// ---- Numbers

test('the shortest text of a float32 is read back exactly, and none is shorter', () => {
  const shortestReference = (x) => {
    for (let digits = 1; ; ++digits) {
      const text = x.toPrecision(digits);
      if (Math.fround(Number(text)) === x) return String(Number(text));
    }
  };
  const r = random(1);
  const values = [0.1, 1 / 3, 1e-7, 16777216, 1e10, 3.4028234663852886e38, 1.401298464324817e-45, 2 ** -126, 999999.94];
  for (let i = 0; i < 20000; ++i) values.push(i % 2 ? anyFloat32(r) : float(r));
  for (let e = -149; e < 128; ++e) values.push(2 ** e, 1 - 2 ** e);
  for (let e = -44; e < 38; ++e) values.push(Number(`1e${e}`), Number(`-9.999999e${e}`));
  for (const value of values.map(Math.fround)) {
    const text = shortest(value);
    assert.ok(Object.is(Math.fround(Number(text)), value), `${value} became ${text}`);
    if (Number.isFinite(value) && value !== 0) assert.ok(text.length <= shortestReference(value).length, text);
  }
  assert.equal(shortest(Math.fround(0.1)), '0.1');
  assert.deepEqual([NaN, Infinity, -Infinity, -0].map(shortest), ['NaN', 'Infinity', '-Infinity', '-0']);
});

test('CRC-32 is that of others, whole and in parts', () => {
  assert.equal(crc32(new TextEncoder().encode('123456789')), 0xcbf43926);
  const r = random(2);
  for (let n = 0; n < 300; ++n) {
    const bytes = Uint8Array.from({ length: n }, () => integer(r, 256));
    const cut = integer(r, n + 1);
    assert.equal(crc32(bytes), referenceCrc32(bytes));
    assert.equal(crc32(bytes.subarray(cut), crc32(bytes.subarray(0, cut))), referenceCrc32(bytes));
  }
});

// ---- CSV

test('CSV is read back as the same float32s', async () => {
  const channels = [
    ['current_x_A', 'A', 'current'],
    ['wärme "core", °C\r\n', '°C', 'heat'],
    ['力_N', 'N', 'force'],
    ['current_x_A', 'A', 'current'],
    ['time_s', 's', 'time'],
    ['two\r\nlines', '', 'time'],
  ];
  const value = (r) => (r() < 0.5 ? anyFloat32(r) : float(r));
  const messages = makeMessages(3, { messages: 400, channels: channels.length, value }); // longer than one piece
  const recorder = recorded(messages, makeHello(channels), { chunk: 64 });
  const samples = flat(messages);
  const blob = await recorder.csv(recorder.begin_s, recorder.end_s);
  assert.match(blob.type, /^text\/csv/);
  const { header, rows } = parseCsv(await blob.text());
  const names = channels.slice(0, 3).map(([name]) => name);
  assert.deepEqual(header, ['time_s', ...names, 'current_x_A_2', 'time_s_2', 'two\r\nlines', 't_monotonic_s']);
  assert.equal(rows.length, samples.length);
  rows.forEach((row, i) => {
    const { t_s, values } = samples[i];
    assert.equal(row[0], (t_s - samples[0].t_s).toFixed(6));
    assert.equal(row.at(-1), t_s.toFixed(6));
    values.forEach((expected, c) => assert.ok(Object.is(Math.fround(Number(row[c + 1])), expected)));
  });
});

test('CSV of a range: its samples only, times from its start', async () => {
  const messages = makeMessages(4, { messages: 80 });
  const recorder = recorded(messages, makeHello(), { chunk: 100 });
  const samples = flat(messages);
  const r = random(5);
  for (let n = 0; n < 20; ++n) {
    const from_s = samples[integer(r, samples.length)].t_s;
    const to_s = samples[integer(r, samples.length)].t_s - 1e-4 * r();
    const inside = samples.filter(({ t_s }) => t_s >= from_s && t_s <= to_s);
    const { rows } = parseCsv(await (await recorder.csv(from_s, to_s)).text());
    const expected = inside.map(({ t_s }) => [(t_s - from_s).toFixed(6), t_s.toFixed(6)]);
    assertSame(rows.map((row) => [row[0], row.at(-1)]), expected);
  }
  const all = parseCsv(await (await recorder.csv(-Infinity, Infinity)).text());
  assert.equal(all.rows.length, samples.length);
  assert.equal(all.rows[0][0], '0.000000');
  for (const [from_s, to_s] of [[0, 1], [1e9, 2e9], [NaN, Infinity], [0, NaN], [samples[5].t_s, samples[4].t_s]]) {
    assert.equal(parseCsv(await (await recorder.csv(from_s, to_s)).text()).rows.length, 0);
  }
  assert.equal(parseCsv(await (await new Recorder(makeHello()).csv(0, 1)).text()).rows.length, 0);
});

// ---- MCAP

test('MCAP: both readers of @mcap/core find every message, its time and its values', async () => {
  for (const seed of [6, 7]) {
    const messages = makeMessages(seed, { messages: seed === 6 ? 400 : 30 });
    const recorder = recorded(messages, makeHello(), { chunk: 256 });
    const bytes = await bytesOf(await recorder.mcap(-Infinity, Infinity));
    const { stream } = await checkMcap(bytes, expectedMcap(messages, makeHello(), -Infinity, Infinity), makeHello());
    const chunks = stream.records.filter((record) => record.type === 'Chunk');
    if (seed === 6) assert.ok(chunks.length > 2);
    for (const chunk of chunks.slice(0, -1)) assert.ok(chunk.records.length >= 2 ** 20);
    const topics = [...stream.channels.values()].map((channel) => channel.topic).sort();
    const names = ['contacts', 'force', 'inputs', 'pen', 'telemetry', 'vehicle'];
    assert.deepEqual(topics, names.map((name) => `/omni/${name}`));
  }
});

test('MCAP of ranges: cut within messages, one sample, empty', async () => {
  const messages = makeMessages(8, { messages: 60 });
  const recorder = recorded(messages, makeHello(), { chunk: 100 });
  const samples = flat(messages);
  const r = random(9);
  const ranges = [[0, 1], [1e9, 2e9], [NaN, 0], [samples[9].t_s, samples[9].t_s], [samples[9].t_s, samples[8].t_s]];
  for (let n = 0; n < 8; ++n) ranges.push([samples[integer(r, 300)].t_s + 1e-4, samples[300 + integer(r, 300)].t_s]);
  for (const [from_s, to_s] of ranges) {
    const expected = expectedMcap(messages, makeHello(), from_s, to_s);
    await checkMcap(await bytesOf(await recorder.mcap(from_s, to_s)), expected, makeHello());
  }
  await checkMcap(await bytesOf(await new Recorder(makeHello()).mcap(0, 1)), [], makeHello());
});

test('MCAP: not finite, 0 contacts, no vehicle, any names, no vectors', async () => {
  const names = ['Ströme 🧲 \u2028', '"\\\n', '__proto__', '力'];
  const channels = names.map((name) => [name, 'N', 'force']);
  const hello = makeHello(channels);
  const value = (r) => [NaN, Infinity, -Infinity, float(r), anyFloat32(r)][integer(r, 5)];
  const messages = makeMessages(10, { channels: channels.length, value }).map((message, i) => ({
    ...message,
    contacts: i % 2 ? [] : message.contacts,
    vehicle: null,
  }));
  assert.ok(messages.some((message) => message.contacts.length === 4));
  const bytes = await bytesOf(await recorded(messages, hello).mcap(-Infinity, Infinity));
  const expected = expectedMcap(messages, hello, -Infinity, Infinity).filter(([topic]) => topic !== '/omni/pen');
  const { reader } = await checkMcap(bytes, expected, hello);
  const topics = [...reader.channelsById.values()].map((channel) => channel.topic);
  assert.ok(!topics.includes('/omni/pen') && !topics.includes('/omni/force'));

  const twice = makeHello([['a', '', ''], ['a', '', ''], ['t_monotonic_s', '', '']]);
  const recorder = recorded(makeMessages(11, { channels: 3, messages: 1 }), twice);
  const { messages: read } = readStream(await bytesOf(await recorder.mcap(-Infinity, Infinity)));
  assert.deepEqual(Object.keys(JSON.parse(read[0].text)), ['t_monotonic_s', 'a', 'a_2', 't_monotonic_s_2']);
});

test('MCAP: the pen as Foxglove draws it', async () => {
  const half = Math.fround(Math.SQRT1_2);
  const cases = [ // what is measured, and the orientation that is to be written; null: no pen
    { q: [1, 0, 0, 0], drawn: [1, 0, 0, 0] },
    { q: [half, 0, -half, 0], drawn: [half, 0, -half, 0] },
    { q: [0.6, 0, 0, 0.8], drawn: [0.6, 0, 0, 0.8] },
    { q: [0.9, 0, 1.2, 0], drawn: [0.6, 0, 0.8, 0] }, // not quite unit
    { q: [0, 0, 0, 0], drawn: [1, 0, 0, 0] }, // not known: upright
    { q: [1, NaN, 0, 0], drawn: [1, 0, 0, 0] },
    { q: [1, 0, 0, 0], z_m: NaN, drawn: null },
    { q: [1, 0, 0, 0], flags: 1, drawn: null }, // no valid pose
  ];
  const messages = cases.map(({ q, z_m = 0.05, flags = 1 << kPoseValid.bit }, i) => {
    const values = [i / 100, 0.02, z_m, ...q, 0, 0, 1, 0];
    return makeLive({ ...kQuietState, flags }, [10 + i / 100], values.length, (_, c) => values[c]);
  });
  const bytes = await bytesOf(await recorded(messages).mcap(0, 100));
  const { reader, messages: read } = await readIndexed(bytes, { topics: ['/omni/pen'] });
  const drawn = cases.flatMap((each, i) => (each.drawn === null ? [] : [{ ...each, x_m: i / 100 }]));
  assert.equal(read.length, drawn.length);
  read.forEach(({ text, time }, n) => {
    const { timestamp, pose } = JSON.parse(text);
    assert.equal(BigInt(timestamp.sec) * 1_000_000_000n + BigInt(timestamp.nsec), time);
    assert.deepEqual(pose.position, { x: drawn[n].x_m, y: 0.02, z: 0.05 });
    const { w, x, y, z } = pose.orientation;
    [w, x, y, z].forEach((component, i) => assert.ok(Math.abs(component - drawn[n].drawn[i]) < 1e-6));
  });
  const unnamed = recorded(messages, { ...makeHello(), flags: [] }); // a service that does not tell
  const { messages: all } = await readIndexed(await bytesOf(await unnamed.mcap(0, 100)), { topics: ['/omni/pen'] });
  assert.equal(all.length, cases.length - 1);
  // Foxglove reads schemas of plain types only; and finds the pose by the schema's name.
  const plain = (schema) => {
    assert.ok(['boolean', 'string', 'number', 'integer', 'object', 'array'].includes(schema.type));
    if (schema.type === 'object') Object.values(schema.properties).forEach(plain);
    if (schema.type === 'array') plain(schema.items);
  };
  const names = [];
  for (const schema of reader.schemasById.values()) {
    const json = JSON.parse(new TextDecoder().decode(schema.data));
    assert.equal(json.type, 'object');
    plain(json);
    names.push(schema.name);
  }
  assert.ok(names.includes('foxglove.PoseInFrame'));
});

test('MCAP: times since 1970 by the clock of this computer', async () => {
  const before = Date.now();
  const recorder = recorded(makeMessages(12, { messages: 20 }));
  const after = Date.now();
  const { messages } = readStream(await bytesOf(await recorder.mcap(-Infinity, Infinity)));
  const newest_ms = Number(messages.at(-1).time / 1000n) / 1000;
  assert.ok(newest_ms >= before - 1 && newest_ms <= after + 1, `${newest_ms} is not ${before} ... ${after}`);
});

test('files have what was kept when they were asked for', async () => {
  const messages = makeMessages(13, { messages: 100 });
  const recorder = recorded(messages, makeHello(), { chunk: 512 });
  const files = [recorder.csv(-Infinity, Infinity), recorder.mcap(-Infinity, Infinity)];
  recorder.add(makeMessages(14, { messages: 1, start_s: recorder.end_s })[0]);
  recorder.clear();
  const [csv, mcap] = await Promise.all(files);
  assert.equal(parseCsv(await csv.text()).rows.length, flat(messages).length);
  const { messages: read } = readStream(await bytesOf(mcap));
  checkMessages(read, expectedMcap(messages, makeHello(), -Infinity, Infinity));
});

// ---- Replay

// As at() is specified, by looking at all samples.
function slowAt(samples, t_s) {
  const sample = samples.findLast((each) => each.t_s <= t_s);
  if (sample === undefined) return null;
  const { message, index } = sample;
  const { length } = sample.values;
  return {
    ...message,
    t_s: sample.t_s,
    count: index + 1,
    times_s: message.times_s.slice(0, index + 1),
    samples: message.samples.slice(0, (index + 1) * length),
  };
}

test('at() and range() are what slow references say', () => {
  for (const seed of [15, 16, 17]) {
    const messages = makeMessages(seed, { messages: 120, value: anyFloat32 });
    const samples = flat(messages);
    const recorder = recorded(structuredClone(messages), makeHello(), { chunk: [1, 50, 4096][seed - 15] });
    const r = random(seed);
    const times = samples.map(({ t_s }) => t_s);
    const some = [-Infinity, times[0] - 1e-9, times[0], times.at(-1), times.at(-1) + 9, Infinity];
    for (let n = 0; n < 150; ++n) {
      const i = integer(r, times.length - 1);
      some.push(times[i], times[i] + r() * (times[i + 1] - times[i]), times[i] - 1e-9);
    }
    for (const t_s of some) assert.deepEqual(recorder.at(t_s), slowAt(samples, t_s));
    assert.equal(recorder.at(NaN), null);
    for (let n = 0; n < 60; ++n) {
      const [from_s, to_s] = [some[integer(r, some.length)], some[integer(r, some.length)]];
      const inside = samples.filter(({ t_s }) => t_s >= from_s && t_s <= to_s);
      assertSameRange(recorder.range(from_s, to_s), {
        times_s: Float64Array.from(inside, ({ t_s }) => t_s),
        samples: Float32Array.from(inside.flatMap(({ values }) => values)),
        count: inside.length,
      });
    }
    assert.deepEqual([recorder.begin_s, recorder.end_s], [times[0], times.at(-1)]);
    assert.equal(recorder.samples, samples.length);
  }
});

test('nothing kept: nothing is there', () => {
  const recorder = new Recorder(makeHello());
  assert.equal(recorder.at(0), null);
  assert.equal(recorder.range(-Infinity, Infinity).count, 0);
  assert.deepEqual([recorder.length_s, recorder.samples, recorder.bytes, recorder.kept], [0, 0, 0, null]);
  assert.ok(Number.isNaN(recorder.begin_s) && Number.isNaN(recorder.end_s));
});

test('what is kept is a copy', () => {
  const messages = makeMessages(18, { messages: 50 });
  const recorder = new Recorder(makeHello(), { chunk: 100 });
  for (const message of structuredClone(messages)) {
    recorder.add(message);
    message.samples.fill(7);
    message.times_s.fill(7);
    message.contacts.forEach((contact) => contact.point.fill(7));
    message.aim.tip.fill(7);
  }
  const samples = flat(messages);
  for (const { t_s } of samples) assert.deepEqual(recorder.at(t_s), slowAt(samples, t_s));
});

test('messages of other channels are ignored and counted', () => {
  const [message, other] = makeMessages(19, { messages: 2 });
  const recorder = recorded([message]);
  const before = recorder.range(-Infinity, Infinity);
  recorder.add({ ...other, samples: other.samples.subarray(1) });
  recorder.add({ ...other, times_s: other.times_s.subarray(1) });
  recorder.add(makeMessages(20, { channels: kChannels.length + 1, messages: 1, start_s: 2000 })[0]);
  assert.equal(recorder.ignored, 3);
  assertSameRange(recorder.range(-Infinity, Infinity), before);
  recorder.add(other);
  assert.equal(recorder.ignored, 3);
  assert.equal(recorder.samples, message.count + other.count);
});

// ---- Times

function live(times, flags = 0) {
  return makeLive({ ...kQuietState, flags }, times, kChannels.length, (i) => times[i]);
}

test('times that repeat, are mixed up or are none are left out', () => {
  const mixed = live([4, 3.5, NaN, 5, 4.5, Infinity, 1e300, -9, 6], 3);
  const recorder = recorded([live([1, 2, 3], 1), live([2, 3, 4], 2), mixed, live([], 4)]);
  recorder.add(live([5.5, 6], 5));
  assert.deepEqual([...recorder.range(-Infinity, Infinity).times_s], [1, 2, 3, 4, 5, 6]);
  assert.deepEqual([3, 4, 5, 6].map((t_s) => recorder.at(t_s).flags), [1, 2, 3, 3]);
  assert.deepEqual([...recorder.at(6).times_s], [5, 6]);
  assert.equal(recorder.at(6).samples[kChannels.length], 6);
});

test('a jump back in time drops what was kept before, and only that', async () => {
  const old = makeMessages(21, { messages: 40, start_s: 5000 });
  const fresh = makeMessages(22, { messages: 40, start_s: 3 });
  const recorder = recorded([...old, ...fresh], makeHello(), { chunk: 100 });
  const samples = flat(fresh);
  assertSame(recorder.range(-Infinity, Infinity).times_s, samples.map(({ t_s }) => t_s));
  assert.equal(recorder.at(2.9), null);
  for (const { t_s } of samples) assert.deepEqual(recorder.at(t_s), slowAt(samples, t_s));
  const bytes = await bytesOf(await recorder.mcap(-Infinity, Infinity));
  await checkMcap(bytes, expectedMcap(fresh, makeHello(), -Infinity, Infinity), makeHello());

  const within = recorded([live([100, 101]), live([102, 103, 7, 8])]); // in the middle of a message
  assert.deepEqual([...within.range(-Infinity, Infinity).times_s], [7, 8]);
});

test('a jump back while recording stops the recording and says why', () => {
  const recorder = recorded([live([100, 101])]);
  recorder.start();
  recorder.add(live([102, 103]));
  assert.deepEqual(recorder.kept, { from_s: 102, to_s: 103 });
  recorder.add(live([7, 8]));
  assert.equal(recorder.recording, false);
  assert.match(recorder.stopped_why, /clock/);
  assert.equal(recorder.kept, null);
  recorder.start();
  assert.equal(recorder.stopped_why, '');
});

// ---- Recording, and its bounds

test('start, stop and clear mark what they should', () => {
  const recorder = recorded([live([1, 2])]);
  recorder.stop(); // nothing to stop
  assert.deepEqual([recorder.recording, recorder.kept], [false, null]);
  recorder.start();
  assert.deepEqual([recorder.recording, recorder.kept], [true, null]);
  recorder.add(live([3, 4]));
  recorder.start(); // already
  assert.deepEqual(recorder.kept, { from_s: 3, to_s: 4 });
  recorder.add(live([5]));
  recorder.stop();
  recorder.add(live([6]));
  assert.deepEqual([recorder.recording, recorder.kept], [false, { from_s: 3, to_s: 5 }]);
  recorder.stop();
  assert.deepEqual(recorder.kept, { from_s: 3, to_s: 5 });
  recorder.start();
  recorder.stop(); // at once
  assert.equal(recorder.kept, null);
  recorder.start();
  recorder.add(live([7]));
  recorder.clear();
  assert.deepEqual([recorder.recording, recorder.kept, recorder.samples], [true, null, 0]);
  recorder.add(live([8, 9]));
  assert.deepEqual(recorder.kept, { from_s: 8, to_s: 9 });
  assert.equal(recorder.stopped_why, '');
});

test('twenty minutes fit into the memory of ten', () => {
  setFlagsFromString('--expose-gc');
  const collect = runInNewContext('gc');
  const used = () => {
    collect();
    collect(); // what the first has found is freed by the second at the latest
    return process.memoryUsage().arrayBuffers;
  };
  const channels = 3;
  const before = used();
  const recorder = new Recorder(makeHello(kChannels.slice(0, channels)));
  addSeconds(recorder, channels, 0, 598);
  const afterTen = { bytes: recorder.bytes, used: used() - before };
  assert.ok(Math.abs(recorder.length_s - 598) < 0.01);
  addSeconds(recorder, channels, 598, 1200, () => assert.ok(recorder.length_s <= 600));
  const afterTwenty = { bytes: recorder.bytes, used: used() - before };
  assert.ok(afterTwenty.bytes / afterTen.bytes < 1.05);
  assert.ok(afterTwenty.used / afterTen.used < 1.1);
  assert.ok(afterTwenty.used / afterTwenty.bytes < 1.1, 'bytes counts everything');
  assert.ok(afterTwenty.bytes / (recorder.samples * (8 + 4 * channels)) < 1.5, 'little more than the samples');
  assert.ok(recorder.length_s > 590 && recorder.end_s === 1200);
  assert.ok(recorder.end_s - recorder.begin_s < 600.01);
  const { times_s, count } = recorder.range(-Infinity, Infinity);
  assert.equal(count, recorder.samples);
  for (let i = 1; i < count; ++i) assert.ok(times_s[i] - times_s[i - 1] < 0.0011); // nothing is missing between
});

test('the bound in bytes holds always', () => {
  const limits = { bytes: 1e6, chunk: 256 };
  const recorder = new Recorder(makeHello(), limits);
  let most = 0;
  addSeconds(recorder, kChannels.length, 0, 60, () => {
    assert.ok(recorder.bytes <= limits.bytes);
    most = Math.max(most, recorder.bytes);
  });
  assert.ok(most / limits.bytes > 0.95 && recorder.bytes / limits.bytes > 0.9);
  assert.equal(recorder.end_s, 60);
  const many = (from_s, samples) => live(Array.from({ length: samples }, (_, i) => from_s + (i + 1) / 1000));
  recorder.add(many(60, 30000)); // one message with more than fits
  assert.ok(recorder.bytes <= limits.bytes);
  addSeconds(recorder, kChannels.length, 90, 91);
  assert.equal(recorder.range(90.1, 91).count, 901);

  recorder.start();
  addSeconds(recorder, kChannels.length, 91, 105);
  assert.equal(recorder.recording, true);
  recorder.add(many(105, 12000)); // with more than fits besides the recording: its beginning goes
  assert.ok(recorder.bytes <= limits.bytes);
  assert.equal(recorder.recording, false);
  assert.match(recorder.stopped_why, /no room/);
  const { from_s, to_s } = recorder.kept;
  assert.deepEqual([from_s, to_s], [recorder.begin_s, 117]);
  assert.ok(from_s > 91.1 && from_s < 105);
  recorder.add(many(117, 30000));
  assert.ok(recorder.bytes <= limits.bytes);
  assert.equal(recorder.range(from_s, to_s).count, Math.round((to_s - from_s) * 1000) + 1); // unmarked ones go first
});

test('a recording is dropped last, and stops itself when it is full', () => {
  for (const limits of [{ length_s: 20, chunk: 256 }, { bytes: 8e5, chunk: 256 }]) {
    const recorder = new Recorder(makeHello(), limits);
    const add = (from_s, to_s) =>
      addSeconds(recorder, kChannels.length, from_s, to_s, () => {
        assert.ok(recorder.bytes <= (limits.bytes ?? Infinity));
        assert.ok(recorder.length_s <= (limits.length_s ?? Infinity));
      });
    add(0, 30); // full of what nobody asked to keep
    const fits_s = recorder.length_s;
    recorder.start();
    add(30, 30 + 0.7 * fits_s);
    assert.equal(recorder.recording, true);
    add(30 + 0.7 * fits_s, 60);
    assert.equal(recorder.recording, false);
    assert.match(recorder.stopped_why, /no room/);
    const { from_s, to_s } = recorder.kept;
    assert.equal(from_s, 30.001);
    assert.ok((to_s - from_s) / fits_s > 0.8 && (to_s - from_s) / fits_s < 0.95);
    const recording = recorder.range(from_s, to_s);
    assert.equal(recording.count, Math.round((to_s - from_s) * 1000) + 1); // all of it
    add(60, 100);
    assertSameRange(recorder.range(from_s, to_s), recording); // long after
    assert.deepEqual(recorder.kept, { from_s, to_s });
    assert.equal(recorder.end_s, 100); // and there is still room for what is new
    assert.ok(recorder.range(60, Infinity).count / (1000 * fits_s) > 0.03);
    recorder.start(); // the old one is free now
    add(100, 100 + 0.7 * fits_s);
    assert.equal(recorder.recording, true);
    assert.equal(recorder.kept.from_s, 100.001);
    assert.ok(recorder.range(from_s, to_s).count / recording.count < 0.7);
  }
});

test('a gap is not recorded time', () => {
  const recorder = recorded([live([1, 2, 3]), live([5000, 5001]), live([5001.5])]);
  assert.equal(recorder.length_s, 3.5);
  assert.equal(recorder.at(4000).t_s, 3);
  assert.equal(recorder.samples, 6);
});

test('many gaps cost no memory', () => {
  const recorder = new Recorder(makeHello());
  recorder.add(live([1]));
  const one = recorder.bytes;
  for (let i = 1; i < 100; ++i) recorder.add(live([1 + 10 * i]));
  assert.equal(recorder.samples, 100);
  assert.ok(recorder.bytes / one < 1.2); // only the newest has room for more
});
