// The aim: where the hand wants the pen. Pure functions.
import type { Vec3 } from '../types';

const kReach = 0.25; // m from the core's centre
const kLowest = -0.02; // m
const kTiltMax = (100 * Math.PI) / 180; // between the axis and straight down
const kDown: Vec3 = [0, 0, -1];

export interface Place {
  tip: Vec3;
  axis: Vec3; // out of the tip, unit
}

export function add(a: Vec3, b: Vec3, scale = 1): Vec3 {
  return [a[0] + scale * b[0], a[1] + scale * b[1], a[2] + scale * b[2]];
}

export function dot(a: Vec3, b: Vec3): number {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

export function cross(a: Vec3, b: Vec3): Vec3 {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

export function unit(v: Vec3, otherwise: Vec3): Vec3 {
  const n = Math.hypot(...v);
  return n > 1e-9 ? [v[0] / n, v[1] / n, v[2] / n] : otherwise;
}

// About a unit axis.
export function rotate(v: Vec3, about: Vec3, angle: number): Vec3 {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  const k = dot(about, v) * (1 - c);
  const side = cross(about, v);
  return [0, 1, 2].map((i) => c * v[i]! + s * side[i]! + k * about[i]!) as Vec3;
}

export function clampTip(tip: Vec3): Vec3 {
  const low: Vec3 = [tip[0], tip[1], Math.max(tip[2], kLowest)];
  const far = Math.hypot(...low);
  return far > kReach ? (low.map((value) => (value * kReach) / far) as Vec3) : low;
}

export function clampAxis(axis: Vec3): Vec3 {
  const u = unit(axis, kDown);
  const angle = Math.acos(Math.min(1, Math.max(-1, -u[2])));
  if (angle <= kTiltMax) return u;
  const about = unit(cross(kDown, u), [1, 0, 0]);
  return unit(rotate(kDown, about, kTiltMax), kDown);
}

export function clamp(place: Place): Place {
  return { tip: clampTip(place.tip), axis: clampAxis(place.axis) };
}

export function same(a: Place | null, b: Place | null): boolean {
  if (a === null || b === null) return a === b;
  return [0, 1, 2].every((i) => a.tip[i] === b.tip[i] && a.axis[i] === b.axis[i]);
}

// Where arrow keys lead: the base's horizontal axes that are nearest to the screen's right and to "away from the eye".
export function horizontal(right: Vec3): { right: Vec3; away: Vec3 } {
  if (Math.abs(right[0]) >= Math.abs(right[1])) {
    const sign = right[0] < 0 ? -1 : 1;
    return { right: [sign, 0, 0], away: [0, sign, 0] };
  }
  const sign = right[1] < 0 ? -1 : 1;
  return { right: [0, sign, 0], away: [-sign, 0, 0] };
}
