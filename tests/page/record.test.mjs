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
const { shortest } = await load('record/text.ts');
const { Track } = await load('record/track.ts');
const { SceneParts } = await load('view/scene_parts.ts');

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

// How many times as long one thing takes as another, each by its fastest; in turn, since a busy machine slows both.
function timesAsLong(one, other, warm, times) {
  for (let n = 0; n < warm; ++n) other();
  const each = Array.from({ length: times }, () => [one(), other()]);
  return Math.min(...each.map(([a]) => a)) / Math.min(...each.map(([, b]) => b));
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
    const names = ['contacts', 'force', 'inputs', 'pen', 'surface_poses', 'surfaces', 'telemetry', 'vehicle'];
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

// ---- Surfaces

const kStep_s = 0.1; // as documented: at most ten states a second
const kSame_m = 5.0001e-6;

function makeSurface(scene, object, changes = {}) {
  return {
    scene,
    object,
    rotation: [1, 0, 0, 0],
    translation: [0, 0, 0],
    largest_displacement_m: 0,
    positions: null,
    triangles: null,
    ...changes,
  };
}

const coordinates = (r, vertices) => Float32Array.from({ length: 3 * vertices }, () => 0.1 * (r() - 0.5));
const corners = (r, triangles, vertices) => Uint32Array.from({ length: 3 * triangles }, () => integer(r, vertices));

// What can come next of an object: only a pose, some vertices moved a little or much, another mesh, and what is none.
function nextSurface(r, scene, object, known) {
  const rotation = [0.5 + r(), float(r), float(r), float(r)].map((x) => Math.fround(Math.max(-9, Math.min(9, x))));
  const pose = { rotation, translation: vec3(r), largest_displacement_m: Math.fround(0.01 * r()) };
  const moved = () => {
    const positions = known.positions.slice();
    const step = [1e-6, 1e-5, 1e-2][integer(r, 3)];
    const first = integer(r, positions.length);
    const end = r() < 0.5 ? positions.length : first + integer(r, 30);
    for (let i = first; i < Math.min(end, positions.length); ++i) positions[i] += step * (r() - 0.5);
    return positions;
  };
  const kind = known.positions === null ? integer(r, 2) : integer(r, 12);
  const vertices = 3 + integer(r, 200);
  switch (kind) {
    case 0: // moved as a whole
      return makeSurface(scene, object, pose);
    case 1: // another mesh
      return makeSurface(scene, object, {
        ...pose,
        positions: coordinates(r, vertices),
        triangles: corners(r, 1 + integer(r, 300), vertices),
      });
    case 2: { // some other triangles
      const triangles = known.triangles.slice();
      for (let i = 0; i < 5; ++i) triangles[integer(r, triangles.length)] = integer(r, known.positions.length / 3);
      return makeSurface(scene, object, { ...pose, positions: moved(), triangles });
    }
    case 3: // vertices more
      return makeSurface(scene, object, { ...pose, positions: Float32Array.of(...known.positions, 1, 2, 3) });
    default:
      return makeSurface(scene, object, { ...pose, positions: moved() });
  }
}

const kMalformed = [
  { positions: new Float32Array(7) },
  { positions: new Float32Array(9), triangles: new Uint32Array(4) },
  { rotation: [0, 0, 0, 0] },
  { rotation: [NaN, 0, 0, 1] },
  { translation: [0, Infinity, 0] },
];

function assertNear(actual, expected) { // floats within the tolerance, whatever is no number exactly
  assert.equal(actual?.length, expected?.length);
  for (let i = 0; i < (expected?.length ?? 0); ++i) {
    if (!(Math.abs(actual[i] - expected[i]) <= kSame_m)) assert.equal(actual[i], expected[i]);
  }
}

function assertSameSurfaces(actual, expected) {
  assert.deepEqual(actual.map(({ object }) => object).sort(), expected.map(({ object }) => object).sort());
  for (const surface of expected) {
    const { positions, triangles, ...rest } = actual.find(({ object }) => object === surface.object);
    for (const key of ['scene', 'rotation', 'translation', 'largest_displacement_m']) {
      assert.deepEqual(rest[key], surface[key]);
    }
    assertNear(positions, surface.positions);
    assert.equal(triangles?.length, surface.triangles?.length);
    if (triangles !== null) assertSame(triangles, surface.triangles);
  }
}

// Plays scenes of a few objects; `past`: what a page that keeps a copy of everything at each message would have.
function playSurfaces(seed, { seconds = 12, limits = {}, after = () => undefined } = {}) {
  const r = random(seed);
  const recorder = new Recorder(makeHello(), limits);
  const past = []; // { t_s, scene, name, surfaces }
  let now = { scene: 0, name: '', known: new Map() };
  for (let m = 0; m < 60 * seconds; ++m) {
    if (m % 240 === 0) {
      now = { scene: now.scene + 1, name: `scene ${now.scene + 1}.glb`, known: new Map() };
      recorder.surfaces.setScene({ number: now.scene, name: now.name });
    }
    const quiet = m % 120 > 100;
    for (let n = quiet ? 0 : integer(r, 4); n > 0; --n) {
      const object = integer(r, 5);
      const known = now.known.get(object) ?? { positions: null, triangles: null };
      const message = nextSurface(r, now.scene, object, known);
      now.known.set(object, {
        ...message,
        positions: message.positions ?? known.positions,
        triangles: message.triangles ?? known.triangles,
      });
      recorder.surfaces.add(message);
      if (r() < 0.1) recorder.surfaces.add(makeSurface(now.scene, object, kMalformed[integer(r, kMalformed.length)]));
      if (r() < 0.1) recorder.surfaces.add({ ...message, scene: now.scene - 1 }); // late, of a scene that is gone
    }
    const t_s = (m + 1) / 60;
    recorder.add(live([t_s - 0.01, t_s]));
    past.push({ t_s, scene: now.scene, name: now.name, surfaces: [...now.known.values()], quiet });
    after(recorder);
  }
  return { recorder, past };
}

test('any time of a recording has each surface as it was then, at most a tenth of a second before', () => {
  for (const seed of [31, 32, 33]) {
    const { recorder, past } = playSurfaces(seed);
    const r = random(seed);
    // What was kept: of each object the state at the first message after it changed, at most ten a second.
    const kept = [];
    const due = new Map();
    past.forEach(({ t_s, scene, surfaces }, m) => {
      const before = past[m - 1]?.scene === scene ? past[m - 1].surfaces : [];
      if (before.length === 0) due.clear();
      for (const surface of surfaces) {
        const state = due.get(surface.object) ?? { due_s: -Infinity, news: false };
        state.news ||= !before.includes(surface);
        if (state.news && t_s >= state.due_s) {
          kept.push({ t_s, surface });
          Object.assign(state, { due_s: t_s + kStep_s, news: false });
        }
        due.set(surface.object, state);
      }
    });
    const times = Array.from({ length: 300 }, () => past[0].t_s + r() * (past.at(-1).t_s - past[0].t_s));
    for (const t_s of [...past.map((each) => each.t_s), ...times]) { // forwards, then at random
      const then = past.findLast((each) => each.t_s <= t_s);
      const newest = new Map();
      for (const each of kept) {
        if (each.t_s <= t_s && each.surface.scene === then.scene) newest.set(each.surface.object, each.surface);
      }
      const { surfaces, scene, name, late_s, complete } = recorder.surfaces.at(t_s);
      assert.deepEqual([scene, name, late_s, complete], [then.scene, then.name, 0, true]);
      assertSameSurfaces(surfaces, [...newest.values()]);
      for (const surface of surfaces) { // independent of how states are chosen: it was live a moment ago
        const since_s = t_s - kStep_s - 2 / 60;
        const recent = past.filter((each) => each.t_s <= t_s && each.t_s > since_s && each.scene === scene);
        const states = recent.map((each) => each.surfaces.find(({ object }) => object === surface.object));
        assert.ok(states.some((state) => state && state.translation.every((x, i) => x === surface.translation[i])));
      }
    }
    // Where nothing changed for a while, it is exactly what was live; and after all.
    for (const { t_s, surfaces, quiet } of past.filter((each, m) => each.quiet && past[m - 8]?.quiet)) {
      assert.ok(quiet);
      assertSameSurfaces(recorder.surfaces.at(t_s).surfaces, surfaces);
    }
    assertSameSurfaces(recorder.surfaces.at(Infinity).surfaces, past.at(-1).surfaces);
    assert.equal(recorder.surfaces.at(NaN), null);
  }
});

test('a track gives back every word, whatever the words are', () => {
  for (const seed of [34, 35]) {
    const r = random(seed);
    const track = new Track(0);
    const states = [];
    let words = Uint32Array.from({ length: 500 }, () => integer(r, 2 ** 32));
    for (let n = 0; n < 3000; ++n) {
      const what = r();
      if (what < 0.05) words = Uint32Array.from({ length: integer(r, 4000) }, () => integer(r, 2 ** 32));
      else if (what < 0.15) words = words.slice(0, integer(r, words.length));
      else if (what < 0.25) words = Uint32Array.of(...words, ...Array.from({ length: integer(r, 50) }, () => 7));
      else if (what < 0.9) {
        words = words.slice();
        const word = () => (r() < 0.5 ? 0x7fc00001 : integer(r, 2 ** 32)); // a NaN that is not the usual one
        for (let i = integer(r, 40); i > 0; --i) words[integer(r, words.length)] = word();
      }
      const given = words.slice();
      track.add(n, given);
      given.fill(9); // what is kept is a copy
      states.push(words);
    }
    for (let n = 0; n < 3000; n = r() < 0.7 ? n + 1 : integer(r, 3000)) {
      const found = track.at(n + r() * 0.9);
      assert.equal(found, track.at(n), 'the same array for the same state');
      assertSame(found, states[n]);
      if (n === 2999) break;
    }
    assert.equal(track.at(-0.1), null);
    // The entries of a range are the same states.
    for (let n = 0; n < 5; ++n) {
      const [from, to] = [integer(r, 3000), integer(r, 3000)].sort((a, b) => a - b);
      assertSame(joinEntries(track.entries(from, to)), states[to]);
    }
    // What is dropped is gone, what is left is as it was.
    const { bytes, second_s } = track;
    track.dropOldest();
    assert.ok(track.bytes < bytes && track.begin_s === second_s && track.at(second_s - 1) === null);
    for (const n of [second_s, 2999]) assertSame(track.at(n), states[n]);
  }
});

// As a reader of files does it.
function joinEntries(entries) {
  let words = new Uint32Array();
  for (const { whole, length, words: data } of entries) {
    if (whole) {
      words = data.slice();
      continue;
    }
    const next = new Uint32Array(Math.max(length, words.length));
    next.set(words);
    for (let at = 0; at < data.length; at += 2 + data[at + 1]) {
      next.set(data.subarray(at + 2, at + 2 + data[at + 1]), data[at]);
    }
    words = next.slice(0, length);
  }
  return words;
}

test('surfaces of foreign sizes: a million messages stay within the memory, and none costs more than the first', () => {
  setFlagsFromString('--expose-gc');
  const collect = runInNewContext('gc');
  const used = () => {
    collect();
    collect();
    return process.memoryUsage().arrayBuffers;
  };
  const r = random(36);
  const limit = 8e6;
  const pool = Array.from({ length: 200 }, (_, i) => {
    const vertices = [1, 10, 100, 600, 200000][i % 40 === 0 ? 4 : integer(r, 4)];
    const few = i % 40 === 0 ? 3 : integer(r, vertices);
    return [coordinates(r, vertices), corners(r, few, i % 17 === 0 ? 2 * vertices : vertices)];
  });
  const play = () => { // a recorder, and 10,000 more messages for it: how long they took
    const recorder = new Recorder(makeHello(kChannels.slice(0, 1)), { surface_bytes: limit });
    const { surfaces } = recorder;
    let t_s = 0;
    let scene = 0;
    const part = () => {
      const start_ms = performance.now();
      for (let n = 0; n < 10000; ++n) {
        const what = r();
        if (what < 0.001) surfaces.setScene({ number: ++scene, name: 'x'.repeat(integer(r, 50)) });
        const [positions, triangles] = pool[integer(r, pool.length)];
        const object = what < 0.9 ? integer(r, 6) : integer(r, 2 ** 32);
        surfaces.add(makeSurface(scene, object, {
          translation: [what, 0, 0],
          positions: what < 0.3 ? null : positions,
          triangles: what > 0.6 ? triangles : null,
        }));
        if (n % 4 === 0) {
          t_s += 1 / 60;
          recorder.add(makeLive(kQuietState, [t_s], 1, () => n));
        }
        most = Math.max(most, surfaces.bytes);
        assert.ok(surfaces.bytes <= limit);
      }
      return performance.now() - start_ms;
    };
    return { recorder, part, until: () => t_s };
  };
  const before = used();
  let most = 0;
  const { recorder, part, until } = play();
  const { surfaces } = recorder;
  for (let n = 0; n < 100; ++n) part();
  assert.ok(most / limit > 0.9, 'the memory is used');
  assert.ok(surfaces.from_s > 0 && surfaces.from_s < until());
  const samples = recorder.bytes;
  const pooled = pool.reduce((sum, [a, b]) => sum + a.byteLength + b.byteLength, 0);
  assert.ok(used() - before < limit + samples + pooled + 2e6, 'bytes counts everything');
  const ratio = timesAsLong(part, play().part, 5, 10);
  assert.ok(ratio < 1.5, `a message at the end took ${ratio.toFixed(2)} times as long`);
  // It is shown as before: what is too old as it was when it was still kept.
  const then = surfaces.at(0);
  assert.ok(Math.abs(then.late_s - surfaces.from_s) < 1e-9);
  assert.ok(surfaces.bytes <= limit + limit / 4);
});

test('a message costs as much after hours as at the beginning, and so does looking back', () => {
  const r = random(37);
  const triangles = corners(r, 2000, 1000);
  const play = () => {
    const recorder = new Recorder(makeHello(kChannels.slice(0, 1)), { surface_bytes: 64e6 });
    recorder.surfaces.setScene({ number: 1, name: 'clay.glb' });
    let positions = coordinates(r, 1000);
    let m = 0;
    const part = () => {
      const start_ms = performance.now();
      for (let n = 0; n < 200; ++n, ++m) {
        positions = positions.slice();
        for (let i = 0; i < 90; ++i) positions[(7 * m + i) % 3000] += 1e-3;
        recorder.surfaces.add(makeSurface(1, 0, { positions, triangles: m === 0 ? triangles : null }));
        recorder.add(makeLive(kQuietState, [m / 10], 1, () => m));
      }
      return performance.now() - start_ms;
    };
    const look = () => {
      const { begin_s, end_s } = recorder;
      const start_ms = performance.now();
      for (let n = 0; n < 200; ++n) recorder.surfaces.at(begin_s + r() * (end_s - begin_s));
      return performance.now() - start_ms;
    };
    return { recorder, part, look };
  };
  const old = play();
  for (let n = 0; n < 30; ++n) old.part(); // ten minutes are kept: more is dropped
  const young = play();
  young.part();
  // What is kept is thirty times as long; memory that no cache holds costs something too, and more on a busy computer.
  for (const what of ['look', 'part']) {
    const ratio = timesAsLong(old[what], young[what], 1, 20);
    assert.ok(ratio < 4, `${what}: ${ratio.toFixed(2)} times as long`);
  }
  const { surfaces, begin_s } = old.recorder;
  assert.equal(surfaces.from_s, -Infinity); // they reach as far back as the samples
  assert.equal(surfaces.at(begin_s).surfaces.length, 1);
});

test('surfaces that do not fit leave their mark: what was before is shown as it was later', () => {
  const limits = { surface_bytes: 1e6 };
  const { recorder, past } = playSurfaces(38, { seconds: 40, limits, after: ({ surfaces }) => {
    assert.ok(surfaces.bytes <= limits.surface_bytes);
  } });
  const { surfaces } = recorder;
  assert.ok(surfaces.bytes / limits.surface_bytes > 0.8);
  assert.ok(surfaces.from_s > 1 && surfaces.from_s < 39);
  const all = playSurfaces(38, { seconds: 40 }).recorder.surfaces; // the same with room enough
  const r = random(39);
  for (let n = 0; n < 200; ++n) {
    const t_s = 1 / 60 + r() * 40;
    const then = surfaces.at(t_s);
    assert.equal(then.late_s, Math.max(0, surfaces.from_s - t_s));
    const expected = all.at(Math.max(t_s, surfaces.from_s));
    assert.deepEqual([then.scene, then.name], [expected.scene, expected.name]);
    assertSameSurfaces(then.surfaces, expected.surfaces);
  }
  assertSameSurfaces(surfaces.at(Infinity).surfaces, past.at(-1).surfaces);
});

test('a surface that is too large is not kept, and that is known', () => {
  const r = random(40);
  const recorder = new Recorder(makeHello(), { surface_bytes: 1e6 });
  const { surfaces } = recorder;
  surfaces.setScene({ number: 1, name: 'large.glb' });
  const small = makeSurface(1, 0, { positions: coordinates(r, 50), triangles: corners(r, 20, 50) });
  const large = makeSurface(1, 1, { positions: coordinates(r, 20000), triangles: corners(r, 20, 50) });
  surfaces.add(small);
  recorder.add(live([1]));
  assert.equal(surfaces.at(1).complete, true);
  surfaces.add(large);
  for (let object = 2; object < 200; ++object) surfaces.add(makeSurface(1, object)); // more than a scene has
  recorder.add(live([2]));
  const then = surfaces.at(2);
  assert.equal(then.complete, false);
  assert.equal(then.surfaces.length, 64);
  assertSameSurfaces(then.surfaces.filter(({ object }) => object === 0), [small]);
  surfaces.setScene({ number: 2, name: 'next.glb' });
  recorder.add(live([3]));
  assert.deepEqual(surfaces.at(3), { scene: 2, name: 'next.glb', surfaces: [], complete: true, late_s: 0 });
});

test('malformed surfaces change nothing', () => {
  const r = random(41);
  const recorder = recorded([]);
  const { surfaces } = recorder;
  surfaces.add(makeSurface(1, 0)); // before there is a scene
  surfaces.setScene({ number: 1, name: 'clay.glb' });
  const good = makeSurface(1, 0, { positions: coordinates(r, 30), triangles: corners(r, 40, 30) });
  surfaces.add(makeSurface(1, 7, { positions: coordinates(r, 30) })); // no triangles yet: only its pose
  surfaces.add(good);
  recorder.add(live([1]));
  for (const malformed of kMalformed) surfaces.add(makeSurface(1, 0, malformed));
  surfaces.add({ ...good, scene: 2 });
  surfaces.add({ ...good, positions: coordinates(r, 5), triangles: null }); // corners that are no vertices any more
  surfaces.add({ ...good, triangles: Uint32Array.of(0, 1, 30) });
  surfaces.add({ ...good, positions: null, triangles: Uint32Array.of(0, 1, 2) });
  recorder.add(live([2]));
  const unshaped = makeSurface(1, 7);
  for (const t_s of [1, 2]) assertSameSurfaces(surfaces.at(t_s).surfaces, [good, unshaped]);
});

test('surfaces go with the samples: cleared, dropped, of another clock; what is now stays', () => {
  const { recorder, past } = playSurfaces(42, { seconds: 30, limits: { length_s: 5, chunk: 16 } });
  const { surfaces } = recorder;
  const newest = past.at(-1).surfaces;
  const kept = playSurfaces(42, { seconds: 30 }).recorder.surfaces;
  assert.ok(surfaces.bytes / kept.bytes < 0.5);
  assert.equal(surfaces.from_s, -Infinity);
  assertSameSurfaces(surfaces.at(recorder.begin_s).surfaces, kept.at(recorder.begin_s).surfaces);
  assertSameSurfaces(surfaces.at(recorder.begin_s + 2).surfaces, kept.at(recorder.begin_s + 2).surfaces);
  recorder.clear();
  assert.equal(surfaces.at(Infinity), null);
  recorder.add(live([31]));
  assertSameSurfaces(surfaces.at(31).surfaces, newest);
  assertSameSurfaces(surfaces.at(0).surfaces, newest);
  recorder.add(live([32]));
  recorder.add(live([7, 8])); // the clock was set back
  assertSameSurfaces(surfaces.at(8).surfaces, newest);
  surfaces.add({ ...newest[0], translation: [1, 2, 3] });
  recorder.add(live([9]));
  assert.deepEqual(surfaces.at(9).surfaces.find(({ object }) => object === newest[0].object).translation, [1, 2, 3]);
  assertSameSurfaces(surfaces.at(8.5).surfaces, newest);
  surfaces.rest();
  assertSameSurfaces(surfaces.at(8.5).surfaces, newest);
});

test('what is drawn: the surface of then in a replay, of no other scene, and what is newest when live again', () => {
  const r = random(44);
  const parts = new SceneParts(() => false);
  const triangles = Uint32Array.of(0, 1, 2, 0, 2, 3);
  const about = { name: 'block', object: 0, material: '' };
  const load = (number) => {
    parts.setScene({ type: 'scene', number, name: 'clay', state: 'ready', text: '', parts: [about], materials: [] });
    const [positions, normals] = [coordinates(r, 4), coordinates(r, 4)];
    const looks = { colour: [1, 1, 1], roughness: 1, colours: null };
    parts.add({ scene: number, part: 0, ...looks, positions, normals, triangles });
    return positions;
  };
  const state = (scene, translation = [0, 0, 0]) =>
    makeSurface(scene, 0, { translation, positions: coordinates(r, 4), triangles: triangles.slice() });
  const drawn = () => { // corners of all triangles that are drawn, where they are drawn
    parts.update();
    parts.group.updateMatrixWorld(true);
    const found = [];
    parts.group.traverseVisible((mesh) => {
      if (!mesh.isMesh) return;
      const { index, drawRange, attributes } = mesh.geometry;
      const count = Math.min(index.count, drawRange.count);
      for (let i = 0; i < count; ++i) {
        const v = index.getX(i);
        const [x, y, z] = ['getX', 'getY', 'getZ'].map((get) => attributes.position[get](v));
        const e = mesh.matrixWorld.elements;
        found.push([x + e[12], y + e[13], z + e[14]].map(Math.fround));
      }
    });
    return found;
  };
  const of = ({ positions, translation = [0, 0, 0] }) =>
    [...triangles].map((v) => [0, 1, 2].map((axis) => Math.fround(positions[3 * v + axis] + translation[axis])));
  const asLoaded = { positions: load(1) };
  const replay = (scene, ...surfaces) => parts.setReplay({ scene, surfaces });
  assert.deepEqual(drawn(), of(asLoaded));
  const [first, second, third, newest] = [state(1), state(1, [0.5, 0, 0]), state(1), state(1, [0, 0.25, 0])];
  parts.setSurface(first);
  assert.deepEqual(drawn(), of(first));
  assert.equal(replay(1, second), true);
  assert.deepEqual(drawn(), of(second));
  assert.equal(replay(1, second), false); // nothing to draw
  assert.equal(replay(1), true); // it had not changed yet
  assert.deepEqual(drawn(), of(asLoaded));
  assert.equal(parts.setSurface(newest), false); // not seen
  assert.deepEqual(drawn(), of(asLoaded));
  replay(1, third);
  assert.deepEqual(drawn(), of(third));
  replay(2, { ...second, scene: 2 });
  assert.deepEqual(drawn(), []); // of another scene
  assert.equal(parts.name(0), '');
  replay(1, second);
  assert.deepEqual(drawn(), of(second));
  assert.equal(parts.setReplay(null), true);
  assert.deepEqual(drawn(), of(newest));
  assert.equal(parts.setReplay(null), false);
  for (const malformed of kMalformed) assert.equal(parts.setSurface(makeSurface(1, 0, malformed)), false);
  assert.deepEqual(drawn(), of(newest));

  replay(1, first);
  const newcomer = { positions: load(2) }; // another scene comes while one is replayed
  assert.deepEqual(drawn(), []);
  parts.setSurface(state(2));
  assert.deepEqual(drawn(), []);
  replay(2);
  assert.deepEqual(drawn(), of(newcomer));
  const last = state(2);
  parts.setSurface(last);
  parts.setReplay(null);
  assert.deepEqual(drawn(), of(last));
});

test('MCAP: surfaces are read back as they are replayed', async () => {
  const { recorder } = playSurfaces(43, { seconds: 9 });
  for (const [from_s, to_s] of [[-Infinity, Infinity], [2.2, 6.5], [5, 5.1]]) {
    const bytes = await bytesOf(await recorder.mcap(from_s, to_s));
    const { messages } = readStream(bytes);
    assert.ok(messages.every(({ time }, i) => i === 0 || messages[i - 1].time <= time), 'by time');
    const { reader } = await readIndexed(bytes);
    const objects = new Map(); // by scene and object
    const known = (json) => {
      const key = `${json.scene}/${json.object}`;
      if (!objects.has(key)) objects.set(key, { scene: json.scene, object: json.object, positions: [], triangles: [] });
      return objects.get(key);
    };
    let scene = 0;
    let compared = 0;
    messages.forEach(({ topic, text }, i) => {
      if (!topic.startsWith('/omni/surface')) return;
      const json = JSON.parse(text);
      assert.equal(json.scene_name, `scene ${json.scene}.glb`);
      scene = json.scene;
      if (topic === '/omni/surface_poses') {
        Object.assign(known(json), { rotation: json.rotation, translation: json.translation });
      } else {
        const data = Buffer.from(json.data, 'base64');
        const words = new Uint32Array(new Uint8Array(data).buffer);
        known(json)[json.part].push({ whole: json.whole, length: json.length, words });
      }
      if (messages[i + 1]?.topic.startsWith('/omni/surface')) return; // more of the same time
      const then = recorder.surfaces.at(json.t_monotonic_s);
      assert.equal(then.scene, scene);
      ++compared;
      for (const surface of then.surfaces) {
        const read = objects.get(`${scene}/${surface.object}`);
        const { x, y, z, w } = read.rotation;
        assert.deepEqual([w, x, y, z].map(Math.fround), surface.rotation);
        const t = read.translation;
        assert.deepEqual([t.x, t.y, t.z].map(Math.fround), surface.translation);
        const positions = joinEntries(read.positions);
        assertSame(new Float32Array(positions.buffer), surface.positions ?? []);
        assertSame(joinEntries(read.triangles), surface.triangles ?? []);
      }
    });
    assert.ok(compared >= 1);
    for (const name of ['omni.Surface', 'omni.SurfacePose']) {
      assert.ok([...reader.schemasById.values()].some((schema) => schema.name === name));
    }
  }
});
