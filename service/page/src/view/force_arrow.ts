// The force that the base exerts on the tip, as an arrow.
import { BufferGeometry, ConeGeometry, CylinderGeometry, Group, Vector3 } from 'three';
import type { Vec3 } from '../types';
import type { Palette } from './palette';
import { Mark } from './xray';

export const kArrowPerNewton = 0.04; // m
const kLeast = 0.01; // N that are shown

export class ForceArrow {
  readonly group = new Group();
  // Both from z = 0 to 1.
  private readonly shaft = new Mark(alongZ(new CylinderGeometry(1, 1, 1, 20)), 1, 0.75);
  private readonly head = new Mark(alongZ(new ConeGeometry(1, 1, 28)), 1, 0.75);

  constructor() {
    this.group.add(this.shaft.mesh, this.head.mesh);
    this.group.visible = false;
  }

  place(tip: Vec3, force: Vec3): void {
    const newton = Math.hypot(...force);
    this.group.visible = newton >= kLeast;
    if (!this.group.visible) return;
    const length = kArrowPerNewton * newton;
    const thick = Math.min(1, 0.35 + newton); // small forces: a slender arrow
    const head = Math.min(0.009 * thick + 0.002, 0.55 * length);
    const radius = 0.0009 * thick + 0.0002;
    this.group.position.set(...tip);
    this.group.quaternion.setFromUnitVectors(new Vector3(0, 0, 1), new Vector3(...force).normalize());
    this.shaft.mesh.scale.set(radius, radius, length - head);
    this.head.mesh.position.z = length - head;
    this.head.mesh.scale.set(0.36 * head, 0.36 * head, head);
  }

  setPalette(palette: Palette): void {
    this.shaft.setColour(palette.force);
    this.head.setColour(palette.force);
  }
}

function alongZ(geometry: BufferGeometry): BufferGeometry {
  return geometry.translate(0, 0.5, 0).rotateX(Math.PI / 2);
}
