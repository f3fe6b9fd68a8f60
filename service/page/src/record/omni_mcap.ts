// What a recording is as an MCAP file: all samples as JSON on /omni/telemetry; contacts, vehicle, inputs, and for
// Foxglove the pen's pose and the force on it, on channels of their own, once per message of the service; surfaces as
// the recording has them: whole states, and what has changed since. Times are nanoseconds since 1970, by the clock of
// this computer; each message also has its CLOCK_MONOTONIC time.
import { McapWriter } from '@mcap/core';
import type { ChannelName } from '../contract';
import { Signals } from '../signals';
import type { Contact, Hello, Live, Quat, Vec3, Vehicle } from '../types';
import type { Chunk, Slice } from './chunk';
import type { SurfaceEntry } from './surface_record';
import { poseOfWords } from './surface_tracks';
import { base64, Pace, shorten, shortestJson, unique } from './text';
import * as schemas from './schemas';

const kTip: readonly ChannelName[] = ['tip_x_m', 'tip_y_m', 'tip_z_m'];
const kOrientation: readonly ChannelName[] = ['q_w', 'q_x', 'q_y', 'q_z']; // of the tool's frame: -z out of the tip
const kForce: readonly ChannelName[] = ['force_x_N', 'force_y_N', 'force_z_N'];
const kFrame = 'omni_base';
const kNs = 1_000_000_000n;
const kInputs = [
  'tip',
  'select',
  'secondary',
  'menu',
  'squeeze',
  'thumbstick_x',
  'thumbstick_y',
  'thumbstick_click',
  'docked',
];

function vectorAt(chunk: Chunk, sample: number, columns: readonly number[]): Vec3 {
  return columns.map((column) => chunk.value(sample, column)) as Vec3;
}

// Upright where it is not known.
function orientationAt(chunk: Chunk, sample: number, columns: readonly number[] | null): Quat {
  const q = columns?.map((column) => chunk.value(sample, column)) ?? [];
  const length = Math.hypot(...q);
  if (!(length > 0.5 && length < 2)) return [1, 0, 0, 0];
  return q.map((component) => component / length) as Quat;
}

function xyz([x, y, z]: Vec3): { x: number; y: number; z: number } {
  return { x: shorten(x), y: shorten(y), z: shorten(z) };
}

function contactOf(contact: Contact): object {
  return {
    ...contact,
    point: xyz(contact.point),
    normal: xyz(contact.normal),
    force: xyz(contact.force),
    slip: xyz(contact.slip),
    normal_N: shorten(contact.normal_N),
    tangential_N: shorten(contact.tangential_N),
    penetration_m: shorten(contact.penetration_m),
  };
}

function vehicleOf(vehicle: Vehicle): object {
  return {
    ...vehicle,
    position: xyz(vehicle.position),
    heading: shorten(vehicle.heading),
    speed_m_s: shorten(vehicle.speed_m_s),
    lap_s: shorten(vehicle.lap_s),
    last_lap_s: shorten(vehicle.last_lap_s),
    best_lap_s: shorten(vehicle.best_lap_s),
  };
}

function inputsOf(inputs: Live['inputs']): object {
  const entries = kInputs.map((name, i): [string, object] => {
    const input = inputs[i] ?? { value: 0, presses: 0, releases: 0 };
    return [name, { ...input, value: shorten(input.value) }];
  });
  return Object.fromEntries(entries);
}

// foxglove.PoseInFrame
function poseOf(time_ns: bigint, tip: Vec3, orientation: Quat): object {
  const [w, x, y, z] = orientation.map(Math.fround) as Quat;
  return {
    timestamp: { sec: Number(time_ns / kNs), nsec: Number(time_ns % kNs) },
    frame_id: kFrame,
    pose: { position: xyz(tip), orientation: wxyz([w, x, y, z]) },
  };
}

function wxyz([w, x, y, z]: Quat): { w: number; x: number; y: number; z: number } {
  return { ...xyz([x, y, z]), w: shorten(w) };
}

function surfaceOf({ part, length, whole, words }: SurfaceEntry): object {
  return { part, length, whole, data: base64(new Uint8Array(words.buffer, words.byteOffset, words.byteLength)) };
}

function surfacePoseOf(words: Uint32Array): object {
  const { rotation, translation, largest_displacement_m } = poseOfWords(words);
  return {
    rotation: wxyz(rotation),
    translation: xyz(translation),
    largest_displacement_m: shorten(largest_displacement_m),
  };
}

class OmniMcap {
  private readonly keys: string[]; // of the channels: '"current_x_A":'
  private readonly tip: number[] | null; // columns; null: not measured
  private readonly orientation: number[] | null;
  private readonly force: number[] | null;
  private readonly poseValid: number; // as a mask of Live.flags; 0: there is no such flag

  private constructor(
    private readonly file: McapFile,
    signals: Signals,
    names: string[],
    private readonly epoch_ns: bigint, // of CLOCK_MONOTONIC
  ) {
    this.keys = names.map((name) => `${JSON.stringify(name)}:`);
    this.tip = signals.columns(kTip);
    this.orientation = signals.columns(kOrientation);
    this.force = signals.columns(kForce);
    this.poseValid = signals.mask('pose_valid');
  }

  static async open(hello: Hello, epoch_ns: bigint): Promise<OmniMcap> {
    const { channels, version } = hello;
    const signals = new Signals(hello);
    const names = unique(channels.map((channel) => channel.name), ['t_monotonic_s']);
    const topics: [string, schemas.Schema][] = [
      ['/omni/telemetry', schemas.telemetry(channels, names)],
      ['/omni/contacts', schemas.contacts],
      ['/omni/vehicle', schemas.vehicle],
      ['/omni/inputs', schemas.inputs(kInputs)],
      ['/omni/surface_poses', schemas.surfacePose],
      ['/omni/surfaces', schemas.surface],
    ];
    if (signals.columns(kTip) !== null) topics.push(['/omni/pen', schemas.pose]);
    if (signals.columns(kForce) !== null) topics.push(['/omni/force', schemas.force]);
    return new OmniMcap(await McapFile.open(`omni page ${version}`, topics), signals, names, epoch_ns);
  }

  writeSample(chunk: Chunk, i: number): Promise<void> {
    const t_s = chunk.time(i);
    let json = `{"t_monotonic_s":${t_s}`;
    for (let c = 0; c < this.keys.length; ++c) json += `,${this.keys[c]!}${shortestJson(chunk.value(i, c))}`;
    return this.file.message('/omni/telemetry', this.time(t_s), `${json}}`);
  }

  // What belongs to a whole message, at the time of its newest sample.
  async writeState(chunk: Chunk, message: number): Promise<void> {
    const newest = chunk.start(message + 1) - 1;
    const t_monotonic_s = chunk.time(newest);
    const time_ns = this.time(t_monotonic_s);
    const write = (topic: string, content: object): Promise<void> => // null is written for what is not finite
      this.file.message(topic, time_ns, JSON.stringify({ t_monotonic_s, ...content }));
    const { contacts, vehicle, inputs, flags } = chunk.state(message);
    await write('/omni/contacts', { contacts: contacts.map(contactOf) });
    if (vehicle !== null) await write('/omni/vehicle', vehicleOf(vehicle));
    await write('/omni/inputs', inputsOf(inputs));
    if (this.force !== null) {
      await write('/omni/force', { frame_id: kFrame, ...xyz(vectorAt(chunk, newest, this.force)) });
    }
    if (this.tip === null || (this.poseValid !== 0 && (flags & this.poseValid) === 0)) return; // nothing to draw
    const tip = vectorAt(chunk, newest, this.tip);
    if (!tip.every(Number.isFinite)) return;
    await write('/omni/pen', poseOf(time_ns, tip, orientationAt(chunk, newest, this.orientation)));
  }

  // A pose is always whole: it is short.
  writeSurface(entry: SurfaceEntry, t_monotonic_s: number): Promise<void> {
    const { scene, name, object, part, words } = entry;
    const about = { t_monotonic_s, scene, scene_name: name, object };
    const [topic, content] = part === 'pose'
      ? ['/omni/surface_poses', surfacePoseOf(words)]
      : ['/omni/surfaces', surfaceOf(entry)];
    return this.file.message(topic, this.time(t_monotonic_s), JSON.stringify({ ...about, ...content }));
  }

  end(): Promise<Blob> {
    return this.file.end();
  }

  private time(t_s: number): bigint {
    return this.epoch_ns + BigInt(Math.round(t_s * 1e9));
  }
}

// `surfaces`: by time.
export async function writeMcap(
  hello: Hello,
  slices: readonly Slice[],
  surfaces: readonly SurfaceEntry[],
  epoch_ns: bigint,
): Promise<Blob> {
  const pace = new Pace();
  const omni = await OmniMcap.open(hello, epoch_ns);
  let next = 0; // of the surfaces
  for (const { chunk, first, last } of slices) {
    for (let i = first; i < last; ) {
      const message = chunk.messageOf(i);
      const end = chunk.start(message + 1);
      for (; i < Math.min(end, last); ++i) await omni.writeSample(chunk, i);
      if (end <= last) await omni.writeState(chunk, message);
      while (end <= last && next < surfaces.length && surfaces[next]!.t_s <= chunk.time(end - 1)) {
        await omni.writeSurface(surfaces[next++]!, chunk.time(end - 1));
        await pace.rest();
      }
      await pace.rest();
    }
  }
  return omni.end();
}

// An MCAP file (https://mcap.dev/spec) of JSON messages: chunks without compression, indexed, with checksums.
class McapFile {
  private readonly pieces: Blob[] = [];
  private position = 0n;
  private readonly writer = new McapWriter({
    writable: {
      write: async (bytes) => {
        this.pieces.push(new Blob([bytes as Uint8Array<ArrayBuffer>])); // a copy
        this.position += BigInt(bytes.length);
      },
      position: () => this.position,
    },
  });
  private readonly channels = new Map<string, { id: number; count: number }>(); // by topic
  private readonly utf8 = new TextEncoder();

  static async open(library: string, topics: readonly [topic: string, schema: schemas.Schema][]): Promise<McapFile> {
    const file = new McapFile();
    const { writer, utf8 } = file;
    await writer.start({ profile: '', library });
    for (const [topic, schema] of topics) {
      const data = utf8.encode(JSON.stringify(schema));
      const schemaId = await writer.registerSchema({ name: schema.title, encoding: 'jsonschema', data });
      const id = await writer.registerChannel({ topic, schemaId, messageEncoding: 'json', metadata: new Map() });
      file.channels.set(topic, { id, count: 0 });
    }
    return file;
  }

  // One after another: each waits for the one before.
  message(topic: string, time_ns: bigint, json: string): Promise<void> {
    const channel = this.channels.get(topic)!;
    const message = { logTime: time_ns, publishTime: time_ns, data: this.utf8.encode(json) };
    return this.writer.addMessage({ ...message, channelId: channel.id, sequence: channel.count++ });
  }

  async end(): Promise<Blob> {
    await this.writer.end();
    return new Blob(this.pieces, { type: 'application/octet-stream' });
  }
}
