// Binary messages of docs/protocol/page.md -> types.ts, by the layouts of contract.ts. Throws RangeError for anything that
// is not one.
import { kKind, kLayout, kMagic } from './contract';
import type { BinaryMessage, Live, Quat, Surface, Vec3 } from './types';

// Little endian, like every machine that Omni runs on; an array is a view into the message, aligned by the layout.
const kArrays = { u8: Uint8Array, u16: Uint16Array, u32: Uint32Array, f32: Float32Array, f64: Float64Array };
type Arrays = { [K in keyof typeof kArrays]: InstanceType<(typeof kArrays)[K]> };
type Layout = keyof Arrays | readonly [keyof Arrays, ...(string | number)[]] | readonly [number, Layout] | Fields;
interface Fields {
  readonly [name: string]: Layout;
}
type Read<L> =
  L extends keyof Arrays ? number
  : L extends readonly ['f32', 3] ? Vec3
  : L extends readonly ['f32', 4] ? Quat
  : L extends readonly [infer E extends keyof Arrays, ...unknown[]] ? Arrays[E]
  : L extends readonly [number, infer E] ? Read<E>[]
  : { -readonly [K in keyof L]: Read<L[K]> };

function reader(buffer: ArrayBuffer): <L extends Fields>(layout: L) => Read<L> {
  let at = 0;
  const array = (element: keyof Arrays, n: number) => {
    const Type = kArrays[element];
    at += n * Type.BYTES_PER_ELEMENT;
    return new Type(buffer, at - n * Type.BYTES_PER_ELEMENT, n);
  };
  // `read`: the fields before it, which lengths name.
  const value = (layout: Layout, read: Record<string, unknown>): unknown => {
    if (typeof layout === 'string') return array(layout, 1)[0];
    if (!Array.isArray(layout)) return fields(layout as Fields);
    const [first, ...rest] = layout as [keyof Arrays | number, ...(string | number | Fields)[]];
    if (typeof first === 'number') return Array.from({ length: first }, () => fields(rest[0] as Fields));
    if (rest.length === 0) return array(first, Math.floor((buffer.byteLength - at) / kArrays[first].BYTES_PER_ELEMENT));
    const lengths = rest.map((length) => (typeof length === 'string' ? (read[length] as number) : (length as number)));
    const values = array(first, lengths.reduce((product, length) => product * length, 1));
    return rest.length === 1 && typeof rest[0] === 'number' ? [...values] : values;
  };
  const fields = (layout: Fields): Record<string, unknown> => {
    const read: Record<string, unknown> = {};
    for (const name in layout) read[name] = value(layout[name]!, read);
    return read;
  };
  return (layout) => fields(layout) as Read<typeof layout>;
}

function live({ contact_count, has_vehicle, contacts, vehicle, aim, ...same }: Read<typeof kLayout.live>): Live {
  return {
    ...same,
    contacts: contacts.slice(0, contact_count),
    vehicle: has_vehicle !== 0 ? { ...vehicle, sliding: vehicle.sliding !== 0 } : null,
    aim: { ...aim, present: aim.present !== 0 },
  };
}

export function decode(buffer: ArrayBuffer): BinaryMessage {
  const { magic, kind } = reader(buffer)(kLayout.head);
  if (magic !== kMagic) throw new RangeError('not a message of omni monitor');
  const read = reader(buffer); // the version was checked with the first message
  switch (kind) {
    case kKind.live:
      return { kind: 'live', live: live(read(kLayout.live)) };
    case kKind.shape: {
      const shape = read(kLayout.shape);
      return { kind: 'shape', shape: { ...shape, colours: shape.coloured !== 0 ? shape.colours : null } };
    }
    case kKind.surface: {
      const { vertex_count, triangle_count, positions, triangles, ...pose } = read(kLayout.surface);
      return {
        kind: 'surface',
        surface: {
          ...pose,
          positions: vertex_count > 0 ? positions : null, // null: only the pose
          triangles: triangle_count > 0 ? triangles : null, // null: as before
        },
      };
    }
    case kKind.file: {
      const { number, name, bytes } = read(kLayout.file);
      return { kind: 'file', file: { number, name: new TextDecoder().decode(name), bytes } };
    }
    default:
      throw new RangeError(`message of unknown kind ${kind}`);
  }
}

// What makes a surface message one that can be drawn, and kept: the view and the recording take the same ones.
// Whole points and triangles, and a pose.
export function isSurface({ rotation, translation, positions, triangles }: Surface): boolean {
  const turns = Math.hypot(...rotation);
  if (!(turns > 1e-6 && turns < 1e6 && translation.every(Number.isFinite))) return false;
  return (positions?.length ?? 0) % 3 === 0 && (triangles?.length ?? 0) % 3 === 0;
}

// Whether every corner is one of the vertices.
export function fit(positions: Float32Array, triangles: Uint32Array): boolean {
  const vertices = positions.length / 3;
  return triangles.every((vertex) => vertex < vertices);
}
