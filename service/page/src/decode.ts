// Binary messages of docs/protocol/page.md -> types.ts. Throws RangeError for anything that is not one.
import type { BinaryMessage, Contact, Live, Quat, Shape, Surface, Vec3 } from './types';

const kMagic = 0x47504d4f; // "OMPG"
const kContacts = 4;
const kInputs = 9;

// Reads one number after another; little endian, like every machine that Omni runs on.
class Reader {
  private at = 0;
  private readonly view: DataView;
  constructor(private readonly buffer: ArrayBuffer) {
    this.view = new DataView(buffer);
  }
  u16(): number {
    this.at += 2;
    return this.view.getUint16(this.at - 2, true);
  }
  u32(): number {
    this.at += 4;
    return this.view.getUint32(this.at - 4, true);
  }
  f32(): number {
    this.at += 4;
    return this.view.getFloat32(this.at - 4, true);
  }
  f64(): number {
    this.at += 8;
    return this.view.getFloat64(this.at - 8, true);
  }
  vec3(): Vec3 {
    return [this.f32(), this.f32(), this.f32()];
  }
  quat(): Quat {
    return [this.f32(), this.f32(), this.f32(), this.f32()];
  }
  // Views into the message; every array is aligned to its element by the layout.
  floats(n: number): Float32Array {
    this.at += 4 * n;
    return new Float32Array(this.buffer, this.at - 4 * n, n);
  }
  doubles(n: number): Float64Array {
    this.at += 8 * n;
    return new Float64Array(this.buffer, this.at - 8 * n, n);
  }
  words(n: number): Uint32Array {
    this.at += 4 * n;
    return new Uint32Array(this.buffer, this.at - 4 * n, n);
  }
  bytes(n: number): Uint8Array {
    this.at += n;
    return new Uint8Array(this.buffer, this.at - n, n);
  }
  rest(): number {
    return this.buffer.byteLength - this.at;
  }
}

function live(r: Reader): Live {
  const count = r.u32();
  const channels = r.u32();
  const flags = r.u32();
  const lost = r.u32();
  const t_s = r.f64();
  const contactCount = r.u32();
  const vehicleOn = r.u32();
  const contacts: Contact[] = [];
  for (let i = 0; i < kContacts; ++i) {
    const contact = {
      object: r.u32(),
      material: r.u32(),
      point: r.vec3(),
      normal: r.vec3(),
      force: r.vec3(),
      slip: r.vec3(),
      normal_N: r.f32(),
      tangential_N: r.f32(),
      penetration_m: r.f32(),
    };
    if (i < contactCount) contacts.push(contact);
  }
  const sliding = r.u32() !== 0;
  const laps = r.u32();
  const hits = r.u32();
  const vehicle = {
    position: r.vec3(),
    heading: r.f32(),
    speed_m_s: r.f32(),
    lap_s: r.f32(),
    last_lap_s: r.f32(),
    best_lap_s: r.f32(),
    sliding,
    laps,
    hits,
  };
  const inputs = Array.from({ length: kInputs }, () => ({ value: r.f32(), presses: r.u32(), releases: r.u32() }));
  const aim = { present: r.u32() !== 0, tip: r.vec3(), axis: r.vec3() };
  r.u32(); // keeps the times aligned
  const times_s = r.doubles(count);
  const samples = r.floats(count * channels);
  return { t_s, flags, contacts, vehicle: vehicleOn !== 0 ? vehicle : null, inputs, aim, count, times_s, samples, lost };
}

function shape(r: Reader): Shape {
  const scene = r.u32();
  const part = r.u32();
  const vertices = r.u32();
  const count = r.u32();
  const coloured = r.u32() !== 0;
  const colour = r.vec3();
  const roughness = r.f32();
  return {
    scene,
    part,
    colour,
    roughness,
    positions: r.floats(3 * vertices),
    normals: r.floats(3 * vertices),
    triangles: r.words(3 * count),
    colours: coloured ? r.bytes(4 * vertices) : null,
  };
}

function surface(r: Reader): Surface {
  const scene = r.u32();
  const object = r.u32();
  const vertices = r.u32(); // 0: only the pose
  const count = r.u32(); // 0: triangles as before
  const rotation = r.quat();
  const translation = r.vec3();
  const largest_displacement_m = r.f32();
  return {
    scene,
    object,
    rotation,
    translation,
    largest_displacement_m,
    positions: vertices > 0 ? r.floats(3 * vertices) : null,
    triangles: count > 0 ? r.words(3 * count) : null,
  };
}

export function decode(buffer: ArrayBuffer): BinaryMessage {
  const r = new Reader(buffer);
  if (r.u32() !== kMagic) throw new RangeError('not a message of omni monitor');
  const kind = r.u16();
  r.u16(); // version: checked with the first message
  switch (kind) {
    case 1:
      return { kind: 'live', live: live(r) };
    case 2:
      return { kind: 'shape', shape: shape(r) };
    case 3:
      return { kind: 'surface', surface: surface(r) };
    case 4: {
      const number = r.u32();
      const name = new TextDecoder().decode(r.bytes(r.u32()));
      return { kind: 'file', file: { number, name, bytes: r.bytes(r.rest()) } };
    }
    default:
      throw new RangeError(`message of unknown kind ${kind}`);
  }
}
