// Measured vectors among the channels, by the names of service/monitor/page/channels.cc.
import type { Channel, Quat, Vec3 } from '../types';
import type { Chunk } from './chunk';

export const kTip = ['tip_x_m', 'tip_y_m', 'tip_z_m'];
export const kOrientation = ['q_w', 'q_x', 'q_y', 'q_z']; // of the tool's frame: -z out of the tip
export const kForce = ['force_x_N', 'force_y_N', 'force_z_N'];

// Where these channels are; null: not all are measured.
export function columnsOf(channels: readonly Channel[], names: readonly string[]): number[] | null {
  const columns = names.map((name) => channels.findIndex((channel) => channel.name === name));
  return columns.includes(-1) ? null : columns;
}

export function vectorAt(chunk: Chunk, sample: number, columns: readonly number[]): Vec3 {
  return columns.map((column) => chunk.value(sample, column)) as Vec3;
}

// Upright where it is not known.
export function orientationAt(chunk: Chunk, sample: number, columns: readonly number[] | null): Quat {
  const q = columns?.map((column) => chunk.value(sample, column)) ?? [];
  const length = Math.hypot(...q);
  if (!(length > 0.5 && length < 2)) return [1, 0, 0, 0];
  return q.map((component) => component / length) as Quat;
}
