// The pen as it is measured, and its ghost where the hand wants it. Modelled in frame T: tip at the origin, body
// along +z.
import { BufferGeometry, Color, Group, Mesh, MeshStandardMaterial, Quaternion, Vector3 } from 'three';
import type { Hello, Quat, Vec3 } from '../types';
import { Glass } from './glass';
import { arc, lathe, type Profile } from './lathe';
import type { Palette } from './palette';

type Magnet = Hello['base']['magnet'];

export const kPenLength = 0.14; // m
const kGhostFull = 0.0025; // m from the pen at which the ghost is drawn in full ...
const kGhostNone = 0.0006; // ... and where it would only hide the pen

// The profiles that pen and ghost are turned from.
class Turned {
  readonly nose: Profile;
  readonly magnet: Profile;
  readonly body: Profile;
  readonly ring: Profile;

  constructor(magnet: Magnet) {
    const low = Math.max(magnet.tip_offset_m - magnet.half_height_m, 0.0008);
    const high = Math.max(magnet.tip_offset_m + magnet.half_height_m, low + 0.001);
    const r = magnet.radius_m;
    const bevel = Math.min(0.0008, 0.2 * (high - low), 0.2 * r);
    const collar = Math.min(0.009, 0.62 * r);
    this.nose = [[0, 0], [0.0003, 0.00004], [0.00055, 0.00022], [0.0008, 0.0006], [0.0016, low], [0.0022, low + 1e-4]];
    this.magnet = [
      [0, low],
      [r - bevel, low],
      ...arc(r - bevel, low + bevel, bevel, -Math.PI / 2, 0, 5),
      ...arc(r - bevel, high - bevel, bevel, 0, Math.PI / 2, 5),
      [0, high],
    ];
    const grip = 0.0041;
    const flare: Profile = Array.from({ length: 15 }, (_, i) => {
      const angle = (i / 14) * (Math.PI / 2); // from the collar into the shaft, like the bell of a trumpet
      return [grip + (collar - grip) * (1 - Math.sin(angle)), high + 0.0008 + 0.017 * (1 - Math.cos(angle))];
    });
    const end = 0.0027;
    this.body = [
      [collar, high],
      [collar, high + 0.0008],
      ...flare,
      [0.0044, 0.045],
      [0.0043, 0.062],
      [0.0038, 0.095],
      [0.0031, 0.125],
      ...arc(0, kPenLength - end, end, 0, Math.PI / 2, 8),
    ];
    const at = high + 0.021;
    this.ring = [
      [0.004, at],
      [0.0045, at + 0.0003],
      [0.0046, at + 0.0011],
      [0.0045, at + 0.0019],
      [0.0041, at + 0.0022],
    ];
  }
}

export function placePen(group: Group, tip: Vec3, orientation: Quat): void {
  group.position.set(...tip);
  group.quaternion.set(orientation[1], orientation[2], orientation[3], orientation[0]);
}

export class Pen {
  readonly group = new Group();
  private readonly body = new MeshStandardMaterial({ roughness: 0.36, metalness: 0.1 });
  private readonly metal = new MeshStandardMaterial({ roughness: 0.24, metalness: 0.9, transparent: true });
  private readonly ring = new MeshStandardMaterial({ roughness: 0.4, emissiveIntensity: 0.45 });
  private readonly tip = new MeshStandardMaterial({ roughness: 0.5 });
  private palette: Palette | null = null;
  private tracked = true;

  constructor(magnet: Magnet) {
    const turned = new Turned(magnet);
    const add = (profile: Profile, material: MeshStandardMaterial, order: number) => {
      const mesh = new Mesh(lathe(profile, 72), material);
      mesh.castShadow = true;
      mesh.renderOrder = order;
      this.group.add(mesh);
    };
    add(turned.body, this.body, 0);
    add(turned.ring, this.ring, 0);
    add(turned.nose, this.tip, 0);
    add(turned.magnet, this.metal, 3); // seen through, so that the disc does not hide what the tip touches
    this.group.visible = false;
  }

  place(tip: Vec3, orientation: Quat, tracked: boolean): void {
    placePen(this.group, tip, orientation);
    if (tracked === this.tracked) return;
    this.tracked = tracked;
    if (this.palette !== null) this.setPalette(this.palette);
  }

  setPalette(palette: Palette): void {
    this.palette = palette;
    const grey = (colour: Color, share: number) => colour.clone().lerp(palette.penLost, this.tracked ? 0 : share);
    this.body.color.copy(grey(palette.penBody, 0.85));
    this.metal.color.copy(grey(new Color('#d5dbe3'), 0.7));
    this.metal.opacity = this.tracked ? 0.72 : 0.4;
    this.ring.color.copy(grey(palette.accent, 1));
    this.ring.emissive.copy(this.tracked ? palette.accent : new Color(0));
    this.tip.color.copy(grey(palette.accent, 1));
    this.tip.emissive.copy(this.tracked ? palette.accent : new Color(0)).multiplyScalar(0.4);
    this.body.transparent = !this.tracked;
    this.body.opacity = this.tracked ? 1 : 0.45;
  }

  dispose(): void {
    disposeGroup(this.group);
  }
}

export class Ghost {
  readonly group = new Group();
  private readonly look = new Glass({ innerOpacity: 0.1, rimOpacity: 0.75, sharpness: 1.6, shine: 0.2 });

  constructor(magnet: Magnet) {
    const turned = new Turned(magnet);
    const outline: Profile = [...turned.nose.slice(0, 5), ...turned.magnet.slice(1, -1), ...turned.body];
    const mesh = new Mesh(lathe(outline, 64), this.look);
    mesh.renderOrder = 4;
    this.group.add(mesh);
    this.group.visible = false;
  }

  // `pen`: the measured tip, null if there is none.
  place(tip: Vec3, axis: Vec3, pen: Vec3 | null): void {
    const out = new Vector3(...axis);
    if (!(out.lengthSq() > 1e-9)) out.set(0, 0, -1);
    const turn = new Quaternion().setFromUnitVectors(new Vector3(0, 0, -1), out.normalize());
    this.group.position.set(...tip);
    this.group.quaternion.copy(turn);
    const away = pen === null ? kGhostFull : Math.hypot(tip[0] - pen[0], tip[1] - pen[1], tip[2] - pen[2]);
    const strength = Math.min(1, Math.max(0, (away - kGhostNone) / (kGhostFull - kGhostNone)));
    this.look.setStrength(strength);
    this.group.visible = strength > 0;
  }

  setPalette(palette: Palette): void {
    this.look.setColours(palette.hand, palette.hand);
  }

  dispose(): void {
    disposeGroup(this.group);
  }
}

function disposeGroup(group: Group): void {
  group.traverse((object) => {
    if (!(object instanceof Mesh)) return;
    (object.geometry as BufferGeometry).dispose();
    object.material.dispose();
  });
}
