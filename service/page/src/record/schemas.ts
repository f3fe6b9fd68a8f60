// JSON schemas of what is written into MCAP files. Every number is plainly a "number", and every array and object says
// what is in it: Foxglove refuses anything else. Where a number was not finite, null is written.
import type { Channel } from '../types';

export interface Schema extends Property {
  title: string;
}

type Property = Record<string, unknown>;

const kTime = { t_monotonic_s: number('time of the sample, CLOCK_MONOTONIC, s') };
const kObject = {
  scene: integer('counts up; surfaces of another number are of another scene'),
  scene_name: { type: 'string' },
  object: integer('index of the object in the scene'),
};

function number(description: string): Property {
  return { type: 'number', description };
}
function integer(description: string): Property {
  return { type: 'integer', minimum: 0, description };
}
function object(properties: Record<string, Property>, description?: string): Property {
  return { type: 'object', properties, ...(description === undefined ? {} : { description }) };
}
function vector(description: string, unit: string): Property {
  return object({ x: number(unit), y: number(unit), z: number(unit) }, description);
}

export function telemetry(channels: readonly Channel[], names: readonly string[]): Schema {
  const properties = channels.map((channel, c): [string, Property] => {
    const unit = channel.unit === '' ? '' : ` [${channel.unit}]`;
    return [names[c]!, number(`${channel.group}: ${channel.label}${unit}`)];
  });
  return { title: 'omni.Telemetry', ...object({ ...kTime, ...Object.fromEntries(properties) }) };
}

export const contacts: Schema = {
  title: 'omni.Contacts',
  ...object({
    ...kTime,
    contacts: {
      type: 'array',
      items: object({
        object: integer('index of the object in the scene'),
        material: integer('index of its material'),
        point: vector('on the surface, base frame', 'm'),
        normal: vector('of the surface, unit', ''),
        force: vector('on the tip, before the limits of the device', 'N'),
        slip: vector('velocity along the surface', 'm/s'),
        normal_N: number('force along the normal, N'),
        tangential_N: number('force across it, N'),
        penetration_m: number('m'),
      }),
    },
  }),
};

export const vehicle: Schema = {
  title: 'omni.Vehicle',
  ...object({
    ...kTime,
    position: vector('base frame', 'm'),
    heading: number('about +z, 0 is +x, rad'),
    speed_m_s: number('m/s'),
    sliding: { type: 'boolean' },
    laps: integer('completed'),
    hits: integer('of the walls'),
    lap_s: number('of this lap so far, s'),
    last_lap_s: number('s'),
    best_lap_s: number('s'),
  }),
};

export function inputs(names: readonly string[]): Schema {
  const input = object({
    value: number('0 to 1; of the thumbstick -1 to 1'),
    presses: integer('since the service started'),
    releases: integer('since the service started'),
  });
  return { title: 'omni.Inputs', ...object({ ...kTime, ...Object.fromEntries(names.map((name) => [name, input])) }) };
}

export const surfacePose: Schema = {
  title: 'omni.SurfacePose',
  ...object({
    ...kTime,
    ...kObject,
    rotation: object({ w: number(''), x: number(''), y: number(''), z: number('') }, 'of the vertices, then ...'),
    translation: vector('... moved by this, base frame', 'm'),
    largest_displacement_m: number('of a vertex from where the scene has it, m'),
  }),
};

export const surface: Schema = {
  title: 'omni.Surface',
  ...object({
    ...kTime,
    ...kObject,
    part: { type: 'string', description: '"positions" (float32 x, y, z per vertex, m) or "triangles" (uint32 x 3)' },
    length: integer('of the array, in words of 32 bits'),
    whole: { type: 'boolean', description: 'false: the array is that of the message before, but for what has changed' },
    data: {
      type: 'string',
      contentEncoding: 'base64',
      description: 'little endian. whole: the array; else runs of uint32 first, uint32 count, that many words',
    },
  }),
};

export const force: Schema = {
  title: 'omni.Force',
  ...object({
    ...kTime,
    frame_id: { type: 'string' },
    x: number('N'),
    y: number('N'),
    z: number('N'),
  }),
};

// A schema that Foxglove knows by its name, and the time of the sample.
export const pose: Schema = {
  title: 'foxglove.PoseInFrame',
  ...object({
    ...kTime,
    timestamp: { title: 'time', ...object({ sec: integer('s'), nsec: { ...integer('ns'), maximum: 999_999_999 } }) },
    frame_id: { type: 'string' },
    pose: {
      title: 'foxglove.Pose',
      ...object({
        position: { title: 'foxglove.Vector3', ...vector('the tip, base frame', 'm') },
        orientation: {
          title: 'foxglove.Quaternion',
          ...object({ x: number(''), y: number(''), z: number(''), w: number('') }),
        },
      }),
    },
  }),
};
