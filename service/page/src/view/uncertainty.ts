// How well the tip is known: an ellipsoid of three standard deviations, enlarged to be seen.
import { Matrix4, Mesh, SphereGeometry, Vector3 } from 'three';
import type { Vec3 } from '../types';
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

interface Eigen {
  values: Vec3;
  vectors: [Vec3, Vec3, Vec3]; // unit, right handed, vectors[i] belongs to values[i]
}

const kPairs = [[0, 1], [0, 2], [1, 2]] as const;

// Eigenvalues and eigenvectors of a symmetric 3 x 3 matrix by Jacobi rotations: exact enough after a few sweeps, and
// never in trouble with equal eigenvalues.
function symmetricEigen(xx: number, xy: number, xz: number, yy: number, yz: number, zz: number): Eigen {
  const a: [Vec3, Vec3, Vec3] = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
  const v: [Vec3, Vec3, Vec3] = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]; // columns are the eigenvectors
  const size = Math.abs(xx) + Math.abs(yy) + Math.abs(zz);
  for (let sweep = 0; sweep < 12; ++sweep) {
    const off = Math.abs(a[0][1]) + Math.abs(a[0][2]) + Math.abs(a[1][2]);
    if (!(off > 1e-12 * size)) break;
    for (const [p, q] of kPairs) {
      if (a[p][q] === 0) continue;
      const theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
      const t = (theta >= 0 ? 1 : -1) / (Math.abs(theta) + Math.hypot(theta, 1));
      const c = 1 / Math.hypot(t, 1);
      const s = t * c;
      for (let k = 0 as 0 | 1 | 2; k < 3; ++k) {
        [a[k][p], a[k][q]] = [c * a[k][p] - s * a[k][q], s * a[k][p] + c * a[k][q]];
      }
      for (let k = 0 as 0 | 1 | 2; k < 3; ++k) {
        [a[p][k], a[q][k]] = [c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]];
        [v[k][p], v[k][q]] = [c * v[k][p] - s * v[k][q], s * v[k][p] + c * v[k][q]];
      }
    }
  }
  const column = (i: 0 | 1 | 2): Vec3 => [v[0][i], v[1][i], v[2][i]];
  return { values: [a[0][0], a[1][1], a[2][2]], vectors: [column(0), column(1), column(2)] };
}
