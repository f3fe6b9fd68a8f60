// Bodies of revolution about z from a profile of [radius, z] in metres, from the lowest point up.
import { BufferGeometry, LatheGeometry, Vector2 } from 'three';

export type Profile = [radius: number, z: number][];

export function lathe(profile: Profile, segments = 64): BufferGeometry {
  const points = profile.map(([radius, z]) => new Vector2(Math.max(radius, 0), z));
  return new LatheGeometry(points, segments).rotateX(Math.PI / 2);
}

// An arc of a profile: from `start` to `end` rad about [radius, z], counter-clockwise from the radial direction.
export function arc(radius: number, z: number, size: number, start: number, end: number, steps: number): Profile {
  return Array.from({ length: steps + 1 }, (_, i) => {
    const angle = start + ((end - start) * i) / steps;
    return [radius + size * Math.cos(angle), z + size * Math.sin(angle)];
  });
}
