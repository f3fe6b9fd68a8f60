// What makes a surface message one that can be drawn, and kept: the view and the recording take the same ones.
import type { Surface } from './types';

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
