// What the page knows: the messages of docs/protocol/page.md, decoded. SI units and the base frame (docs/conventions.md)
// everywhere: +x right, +y away from the person, +z up, metres.

export const kProtocol = 1; // the version that this page speaks

export type Vec3 = [number, number, number];
export type Quat = [number, number, number, number]; // w, x, y, z

// One number that is measured every tick, in the order of Live.samples.
export interface Channel {
  name: string; // "current_x_A"
  label: string; // "current x"
  unit: string; // "A"; "" for bits and counts
  group: string; // strips that belong together: "position", "force", "current", ...
}

// Bits of Live.flags, in words.
export interface Flag {
  bit: number; // 0 ... 31
  name: string;
}

export interface SceneChoice {
  name: string; // "dragon": what {type: "scene"} takes
  title: string; // "Dragon: soft"
  about: string; // what to do there, one sentence
}

// A slider of a material; `key` is that of the glTF tag ("stiffness", "vibration.amplitude").
export interface MaterialField {
  key: string;
  label: string;
  unit: string;
  minimum: number;
  maximum: number;
  about: string;
}

// The first message.
export interface Hello {
  type: 'hello';
  protocol: number;
  version: string; // of Omni
  control: boolean; // this page may change something (else only the emergency stop)
  hand: boolean; // it leads the simulated hand (omni try)
  channels: Channel[];
  flags: Flag[]; // of Live.flags
  faults: Flag[]; // of the channel "tick_faults"
  device_faults: { bit: number; name: string; text: string; remedy: string }[]; // of the channel "device_faults"
  scenes: SceneChoice[]; // empty without `hand`
  material_fields: MaterialField[];
  max_file_bytes: number; // of a dropped .glb
  environment: string[]; // lines of a shell that give an OpenXR application the pen; empty without `hand`
  base: {
    hull_radius_m: number;
    core_radius_m: number;
    coils: { axis: Vec3; inner_radius_m: number; outer_radius_m: number; length_m: number }[]; // x, y, z
    sensors: Vec3[];
    current_max_A: number;
    force_max_N: number;
    magnet: { radius_m: number; half_height_m: number; tip_offset_m: number };
  };
}

// omnid's own status (docs/protocol/ipc.md), twice a second. Only what the page reads is typed.
export interface Status {
  SIMULATION?: string;
  service?: { version: string; uptime_s: number; instance: number };
  device?: {
    name: string | null;
    absent?: string;
    serial?: string;
    simulation?: boolean;
    state?: string;
    faults?: string[];
    waits_for_person?: boolean;
  };
  calibration?: { file: string; date: string; serial: string; note: string | null; shipped?: boolean; expected_error_mm: number } | null;
  calibration_refused?: string | null;
  calibration_misfit?: string | null;
  room?: { kind: string; sensors: number[]; what: string; fix: string }[];
  clients?: {
    id: number;
    pid: number;
    application: string;
    monitor: boolean;
    session: 'none' | 'begun' | 'focused';
    owner: boolean;
    scene: string;
    aligned: boolean;
  }[];
  scene?: {
    name: string;
    generation: number;
    triangles: number;
    soft_bodies: { objects: number; ready: number; failed: number; done: number } | null;
    sculpted: number;
  };
  tick?: {
    count: number;
    late: number;
    timeouts: number;
    us_median: number;
    us_p99: number;
    us_max: number;
    latency_us_median: number;
    latency_us_p99: number;
    realtime: boolean;
    realtime_reason: string;
  };
  race?: { laps: number; hits: number; speed_m_s: number; last_lap_s: number; best_lap_s: number } | null;
  stopped?: string | null; // by whom the emergency stop is on
  stop?: { at?: string; problem?: string | null } | null; // since when, and why it does not outlive omnid
  problems?: string[];
}

export interface StatusMessage {
  type: 'status';
  connected: boolean; // to omnid
  why: string; // if not: what is wrong, what to do
  status: Status | null;
  strokes: number; // of all sculpted objects of the scene that is touched; -1: nothing is sculpted
}

// A step of `omni setup`, in order. Which are done, as omnid and the user's files show it.
export interface SetupStep {
  name: string; // "calibrate"
  title: string;
  about: string;
  takes: string; // "two minutes"
  command: string; // for a shell
  can_be_undone: boolean;
  state: 'done' | 'open' | 'unknown'; // unknown: nothing shows it
  text: string; // what is there, or what is missing
}

export interface SetupMessage {
  type: 'setup';
  steps: SetupStep[];
}

// What there is to touch, whenever it changes. Shapes (binary) of the same `number` follow.
export interface SceneMessage {
  type: 'scene';
  number: number; // counts up; messages of another number are of another scene
  name: string; // "dragon.glb"; "": none
  state: 'none' | 'loading' | 'ready' | 'failed';
  text: string; // failed: why, and what to do; ready: notes
  own: boolean; // loaded by this page: its materials can be changed
  parts: { name: string; object: number; material: string }[]; // object -1: only to be seen
  materials: { index: number; name: string; values: Record<string, number> }[]; // values by MaterialField.key
}

export interface NoticeMessage {
  type: 'notice';
  level: 'info' | 'warning' | 'error';
  text: string;
}

// The answer to {type: "save"}: the scene with its material values and strokes, as a .glb (binary part follows as
// kind 4), or why not.
export interface AnswerMessage {
  type: 'answer';
  number: number; // of the request
  done: boolean;
  text: string;
}

export type TextMessage = Hello | StatusMessage | SetupMessage | SceneMessage | NoticeMessage | AnswerMessage;

export interface Contact {
  object: number;
  material: number;
  point: Vec3; // on the surface: where the proxy is
  normal: Vec3;
  force: Vec3; // on the tip, N, before the device's limits
  slip: Vec3; // m/s
  normal_N: number;
  tangential_N: number;
  penetration_m: number;
}

export interface Vehicle {
  position: Vec3;
  heading: number; // rad about +z, 0 = +x
  speed_m_s: number;
  sliding: boolean;
  laps: number;
  hits: number;
  lap_s: number;
  last_lap_s: number;
  best_lap_s: number;
}

// Where the hand wants the pen: the far end of its spring.
export interface Aim {
  present: boolean;
  tip: Vec3;
  axis: Vec3; // out of the tip, unit
}

// Kind 1: sixty times a second, everything since the last one.
export interface Live {
  t_s: number; // of the newest sample, CLOCK_MONOTONIC
  flags: number; // of the newest sample, see Hello.flags
  contacts: Contact[];
  vehicle: Vehicle | null;
  inputs: { value: number; presses: number; releases: number }[]; // tip, select, secondary, menu, squeeze, thumbstick x, y, click, docked
  aim: Aim;
  count: number; // samples
  times_s: Float64Array; // of each sample
  samples: Float32Array; // count x channels: samples[i * channels + c]
  lost: number; // samples that were not sent because this page was too slow
}

// Kind 2: a part of the scene as it is loaded.
export interface Shape {
  scene: number;
  part: number; // index in SceneMessage.parts
  colour: Vec3; // linear RGB
  roughness: number;
  positions: Float32Array; // 3 per vertex, base frame
  normals: Float32Array; // 3 per vertex
  colours: Uint8Array | null; // linear RGB x 255, 4 per vertex; null: `colour` everywhere
  triangles: Uint32Array; // 3 per triangle, counter-clockwise from outside
}

// Kind 3: an object that changes, as it is now: replaces the vertices of the parts with this `object`, or only moves them.
export interface Surface {
  scene: number;
  object: number;
  rotation: Quat;
  translation: Vec3; // x = R vertex + translation
  largest_displacement_m: number;
  positions: Float32Array | null; // null: only the pose has changed
  triangles: Uint32Array | null; // null: as before
}

// Kind 4: a file to be saved by the person.
export interface FileBytes {
  number: number; // of the request
  name: string;
  bytes: Uint8Array;
}

export type BinaryMessage =
  | { kind: 'live'; live: Live }
  | { kind: 'shape'; shape: Shape }
  | { kind: 'surface'; surface: Surface }
  | { kind: 'file'; file: FileBytes };

// What the page may send. All but "stop" with on = true need `control`; aim, lift, scene need `hand`.
export type Request =
  | { type: 'aim'; tip: Vec3; axis: Vec3 }
  | { type: 'lift' } // the pen is taken away
  | { type: 'scene'; name: string }
  | { type: 'material'; index: number; values: Record<string, number> }
  | { type: 'undo' }
  | { type: 'redo' }
  | { type: 'release' } // lets go of the clay that the pen holds
  | { type: 'save'; number: number }
  | { type: 'stop'; on: boolean }; // emergency stop
// A dropped file is binary: see Link.drop.
