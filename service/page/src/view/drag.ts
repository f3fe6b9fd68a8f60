// Where the pen goes with the pointer: in the upright plane that holds the camera's right, so that "down" is down; in
// the level one with Shift, or where the camera looks down from above.
import { Plane, Raycaster, Vector2, Vector3, type PerspectiveCamera } from 'three';
import type { Vec3 } from '../types';

export type DragPlane = 'upright' | 'level';

const kSteep = Math.sin((60 * Math.PI) / 180);
const kGrazing = 0.3; // sine between view and plane: under it the plane runs away from the pointer

// `forward`: the camera's, unit. `other`: the one that is not usual for this camera.
export function planeFor(forward: Vec3, other: boolean): DragPlane {
  return Math.abs(forward[2]) > kSteep !== other ? 'level' : 'upright';
}

// Unit, out of the plane and away from the eye.
export function depthOf(forward: Vec3, plane: DragPlane): Vec3 {
  if (plane === 'level') return [0, 0, -1];
  const size = Math.hypot(forward[0], forward[1]);
  return size > 0 ? [forward[0] / size, forward[1] / size, 0] : [0, 1, 0];
}

export interface Pointed {
  screen: Vector2; // -1 ... 1
  pixels: Vector2; // right and up
}

// The way of the pen that is at `tip`, m. `perPixel`: the size of a pixel there, m.
export function dragged(
  camera: PerspectiveCamera, from: Pointed, to: Pointed, tip: Vec3, plane: DragPlane, perPixel: number,
): Vec3 {
  const axis = (i: number) => new Vector3().setFromMatrixColumn(camera.matrixWorld, i); // right, up, towards the eye
  const forward = axis(2).negate();
  const normal = new Vector3(...depthOf(forward.toArray(), plane));
  if (Math.abs(forward.dot(normal)) < kGrazing) {
    const by = to.pixels.clone().sub(from.pixels).multiplyScalar(perPixel);
    const up = plane === 'upright' ? new Vector3(0, 0, 1) : axis(1).setZ(0).normalize();
    return axis(0).multiplyScalar(by.x).addScaledVector(up, by.y).toArray();
  }
  const through = new Plane().setFromNormalAndCoplanarPoint(normal, new Vector3(...tip));
  const at = (point: Pointed) => {
    const ray = new Raycaster();
    ray.setFromCamera(point.screen, camera);
    return ray.ray.intersectPlane(through, new Vector3());
  };
  const [a, b] = [at(from), at(to)];
  return a === null || b === null ? [0, 0, 0] : b.sub(a).toArray();
}
