// How well the tip is known: an ellipsoid of three standard deviations, enlarged to be seen.
import { Matrix4, Mesh, SphereGeometry, Vector3 } from 'three';
import type { Vec3 } from '../types';
import { symmetricEigen } from './eigen';
import { Glass } from './glass';
import type { Palette } from './palette';
import type { Picture } from './picture';

export const kSigmas = 3;
export const kUncertaintyScale = 10; // the ellipsoid is drawn so much larger than it is
const kLargest = 0.05; // m of a half axis in the picture

export class Uncertainty {
  readonly mesh: Mesh<SphereGeometry, Glass>;

  constructor() {
    const look = new Glass({ innerOpacity: 0.1, rimOpacity: 0.6, sharpness: 1.7, shine: 0.15 });
    this.mesh = new Mesh(new SphereGeometry(1, 32, 24), look);
    this.mesh.renderOrder = 4;
    this.mesh.visible = false;
  }

  place(tip: Vec3, covariance: Picture['covariance']): void {
    const { values, vectors } = symmetricEigen(...covariance);
    this.mesh.visible = values.some((value) => value > 0);
    if (!this.mesh.visible) return;
    const half = values.map((value) => Math.min(kLargest, kUncertaintyScale * kSigmas * Math.sqrt(Math.max(value, 0))));
    const frame = new Matrix4().makeBasis(
      new Vector3(...vectors[0]),
      new Vector3(...vectors[1]),
      new Vector3(...vectors[2]),
    );
    this.mesh.position.set(...tip);
    this.mesh.quaternion.setFromRotationMatrix(frame);
    this.mesh.scale.set(half[0]! + 1e-6, half[1]! + 1e-6, half[2]! + 1e-6);
  }

  setPalette(palette: Palette): void {
    this.mesh.material.setColours(palette.accent, palette.accent);
  }
}
