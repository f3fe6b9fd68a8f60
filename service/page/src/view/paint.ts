// Which part of the file a triangle of a changing surface belongs to, and the colour of its vertices: by what is
// nearest when the surface is first seen; later, where its mesh has changed, by what was nearest on it before.
import type { Shape } from '../types';
import { Nearest } from './nearest';

const kSame = 0.003; // m: a vertex that jumps further is another one

export interface Paint {
  parts: Uint16Array; // of each triangle, index in the list of shapes
  colours: Uint8Array | null; // 4 per vertex; null: no part has colours of its own
}

export interface Painted {
  positions: Float32Array;
  triangles: Uint32Array;
  paint: Paint;
}

export function paintFromShapes(shapes: Shape[], positions: Float32Array, triangles: Uint32Array): Paint {
  const parts = new Uint16Array(triangles.length / 3);
  if (shapes.length > 1) {
    const centres = shapes.map((shape) => centresOf(shape.positions, shape.triangles));
    const owner = Uint16Array.from(centres.flatMap((list, part) => new Array<number>(list.length / 3).fill(part)));
    take(new Nearest(joined(centres)), centresOf(positions, triangles), (triangle, found) => {
      parts[triangle] = owner[found]!;
    });
  }
  if (shapes.every((shape) => shape.colours === null)) return { parts, colours: null };
  const known = shapes.map((shape) => shape.colours ?? new Uint8Array((4 * shape.positions.length) / 3).fill(255));
  const all = new Uint8Array(known.reduce((n, list) => n + list.length, 0));
  let at = 0;
  for (const list of known) {
    all.set(list, at);
    at += list.length;
  }
  const colours = new Uint8Array((4 * positions.length) / 3);
  take(new Nearest(joined(shapes.map((shape) => shape.positions))), positions, (vertex, found) => {
    colours.set(all.subarray(4 * found, 4 * found + 4), 4 * vertex);
  });
  return { parts, colours };
}

export function paintFromBefore(before: Painted, positions: Float32Array, triangles: Uint32Array): Paint {
  const parts = new Uint16Array(triangles.length / 3);
  if (before.paint.parts.some((part) => part !== 0)) {
    const old = before.triangles;
    let nearest: Nearest | null = null;
    const centres = centresOf(positions, triangles);
    for (let t = 0; t < parts.length; ++t) {
      const i = 3 * t;
      const same = old[i] === triangles[i] && old[i + 1] === triangles[i + 1] && old[i + 2] === triangles[i + 2];
      if (!same) nearest ??= new Nearest(centresOf(before.positions, old));
      const from = same ? t : nearest!.find(centres[i]!, centres[i + 1]!, centres[i + 2]!);
      parts[t] = before.paint.parts[from] ?? 0;
    }
  }
  const known = before.paint.colours;
  if (known === null) return { parts, colours: null };
  const colours = new Uint8Array((4 * positions.length) / 3);
  let nearest: Nearest | null = null;
  for (let v = 0; v < positions.length / 3; ++v) {
    const [x, y, z] = [positions[3 * v]!, positions[3 * v + 1]!, positions[3 * v + 2]!];
    const old = before.positions;
    const stays =
      3 * v < old.length && Math.hypot(old[3 * v]! - x, old[3 * v + 1]! - y, old[3 * v + 2]! - z) < kSame;
    if (!stays) nearest ??= new Nearest(old);
    const from = stays ? v : nearest!.find(x, y, z);
    if (from >= 0) colours.set(known.subarray(4 * from, 4 * from + 4), 4 * v);
  }
  return { parts, colours };
}

function take(nearest: Nearest, points: Float32Array, found: (point: number, nearest: number) => void): void {
  for (let i = 0; i < points.length / 3; ++i) {
    const at = nearest.find(points[3 * i]!, points[3 * i + 1]!, points[3 * i + 2]!);
    if (at >= 0) found(i, at);
  }
}

function centresOf(positions: Float32Array, triangles: Uint32Array): Float32Array {
  const centres = new Float32Array(triangles.length);
  for (let t = 0; t < triangles.length; t += 3) {
    for (let axis = 0; axis < 3; ++axis) {
      const sum = [0, 1, 2].reduce((total, k) => total + (positions[3 * triangles[t + k]! + axis] ?? 0), 0);
      centres[t + axis] = sum / 3;
    }
  }
  return centres;
}

function joined(lists: Float32Array[]): Float32Array {
  const all = new Float32Array(lists.reduce((n, list) => n + list.length, 0));
  let at = 0;
  for (const list of lists) {
    all.set(list, at);
    at += list.length;
  }
  return all;
}
