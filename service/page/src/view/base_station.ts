// The base: iron core, three windings in the colour of their currents, the translucent hull and foot, the sensors.
import {
  BufferGeometry, Group, InstancedMesh, Matrix4, Mesh, MeshStandardMaterial, Quaternion, SphereGeometry, Vector3,
} from 'three';
import type { Hello, Vec3 } from '../types';
import { Glass } from './glass';
import { arc, lathe, type Profile } from './lathe';
import type { Palette } from './palette';

type Base = Hello['base'];

const kWires = 9; // that are drawn of a winding's outermost layer
const kWeave = 0.0011; // m: how much further in a winding lies than the one over it
const kFootMargin = 0.02; // m of the foot around the sensors

export class BaseStation {
  readonly group = new Group();
  readonly deskHeight: number;
  readonly footRadius: number;
  private readonly windings: MeshStandardMaterial[] = [];
  private readonly iron = new MeshStandardMaterial({ metalness: 0.55, roughness: 0.42 });
  private readonly dots = new MeshStandardMaterial({ roughness: 0.4, emissiveIntensity: 0.55 });
  private readonly shell = new Glass({ innerOpacity: 0.07, rimOpacity: 0.72, sharpness: 2.6, shine: 0.7 });
  private readonly foot = new Glass({ innerOpacity: 0.2, rimOpacity: 0.62, sharpness: 1.6, shine: 0.25 });
  private currents: Vec3 = [0, 0, 0];
  private palette: Palette | null = null;

  constructor(private readonly base: Base) {
    const sensors = base.sensors;
    const radius = Math.max(0.04, ...sensors.map(([x, y]) => Math.hypot(x, y)));
    const lowest = Math.min(-base.hull_radius_m - 0.02, ...sensors.map((p) => p[2]));
    const highest = Math.min(-base.hull_radius_m - 0.008, Math.max(lowest, ...sensors.map((p) => p[2])));
    this.deskHeight = lowest - 0.008;
    this.footRadius = radius + kFootMargin;

    const core = new Mesh(new SphereGeometry(base.core_radius_m, 48, 32), this.iron);
    this.group.add(core);
    base.coils.forEach((coil, i) => this.wind(coil, i));
    this.addSensors(sensors);

    const foot = this.solid(lathe(this.standProfile(highest + 0.005), 96), this.foot);
    const hull = this.solid(new SphereGeometry(base.hull_radius_m, 64, 48), this.shell);
    foot.renderOrder = 1;
    hull.renderOrder = 2;
  }

  setCurrents(currents: Vec3): void {
    this.currents = currents;
    const { palette } = this;
    if (palette === null) return;
    this.windings.forEach((material, i) => {
      const share = (currents[i] ?? 0) / (this.base.current_max_A || 1);
      const strength = Math.min(1, Math.abs(share)) ** 0.6;
      material.color.copy(palette.copper).lerp(share < 0 ? palette.negative : palette.positive, strength);
      material.emissive.copy(material.color).multiplyScalar(0.5 * strength);
    });
  }

  setPalette(palette: Palette): void {
    this.palette = palette;
    this.iron.color.copy(palette.iron);
    this.dots.color.copy(palette.sensor);
    this.dots.emissive.copy(palette.sensor);
    this.shell.setColours(palette.glass, palette.glassRim);
    this.foot.setColours(palette.glass, palette.glassRim);
    this.setCurrents(this.currents);
  }

  dispose(): void {
    this.group.traverse((object) => {
      if (!(object instanceof Mesh)) return;
      object.geometry.dispose();
      object.material.dispose();
      if (object instanceof InstancedMesh) object.dispose();
    });
  }

  private solid(geometry: BufferGeometry, material: Glass): Mesh {
    const mesh = new Mesh(geometry, material);
    mesh.castShadow = true;
    this.group.add(mesh);
    return mesh;
  }

  // A band around the core whose turns lie on a sphere: windings cross over one another, the later ones outside.
  private wind(coil: Base['coils'][number], i: number): void {
    const half = 0.5 * coil.length_m;
    const shells = this.base.coils.slice(i + 1).filter((c) => Math.abs(c.outer_radius_m - coil.outer_radius_m) < 1e-4);
    const outer = Math.min(coil.outer_radius_m, this.base.hull_radius_m - 0.001) - kWeave * shells.length;
    const wire = half / kWires;
    const on = (z: number) => Math.sqrt(Math.max(outer * outer - z * z, 1e-6));
    const inner = Math.max(coil.inner_radius_m, on(half) - 3 * wire);
    const profile: Profile = [[inner, -half]];
    for (let k = 0; k < kWires; ++k) {
      const z = -half + (2 * k + 1) * wire;
      profile.push(...arc(on(z) - wire, z, wire, -Math.PI / 2, Math.PI / 2, 6));
    }
    profile.push([inner, half], [inner, half], [inner, -half]);
    const material = new MeshStandardMaterial({ metalness: 0.35, roughness: 0.42 });
    const mesh = new Mesh(lathe(profile, 96), material);
    mesh.quaternion.setFromUnitVectors(new Vector3(0, 0, 1), new Vector3(...coil.axis).normalize());
    this.windings.push(material);
    this.group.add(mesh);
  }

  private addSensors(sensors: Vec3[]): void {
    const mesh = new InstancedMesh(new SphereGeometry(0.0026, 20, 14), this.dots, sensors.length);
    const at = new Matrix4();
    const flat = new Vector3(1, 1, 0.55); // a chip rather than a ball
    sensors.forEach((p, i) => mesh.setMatrixAt(i, at.compose(new Vector3(...p), new Quaternion(), flat)));
    mesh.frustumCulled = false;
    this.group.add(mesh);
  }

  // From the desk up: a flat foot over the sensors that flows into a neck under the hull.
  private standProfile(top: number): Profile {
    const r = this.footRadius;
    const round = Math.min(0.006, 0.3 * (top - this.deskHeight));
    const neck = 0.42 * this.base.hull_radius_m;
    const under = -Math.sqrt(Math.max(this.base.hull_radius_m ** 2 - neck ** 2, 0)); // where it meets the hull
    const profile: Profile = [[r, this.deskHeight + 2e-4]];
    profile.push(...arc(r - round, top - round, round, 0, Math.PI / 2, 8));
    const steps = 16;
    const start = neck + Math.min(0.018, under - top);
    for (let i = 0; i <= steps; ++i) {
      const angle = (i / steps) * (Math.PI / 2); // a concave quarter of an ellipse
      profile.push([neck + (start - neck) * (1 - Math.sin(angle)), top + (under - top) * (1 - Math.cos(angle))]);
    }
    return profile;
  }
}

// Separates scene parts that only repeat the base's own hull (some scenes bring a picture of it) from others.
export function liesInHull(positions: Float32Array, base: Base): boolean {
  const limit = (base.hull_radius_m + 5e-4) ** 2;
  for (let i = 0; i + 2 < positions.length; i += 3) {
    const [x, y, z] = [positions[i]!, positions[i + 1]!, positions[i + 2]!];
    if (!(x * x + y * y + z * z <= limit)) return false;
  }
  return positions.length > 0;
}
