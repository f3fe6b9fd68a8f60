// Forces as they are drawn: an arrow for that of the base, a spring for that of the hand.
import {
  BufferGeometry, Color, ConeGeometry, CylinderGeometry, GreaterDepth, Group, Mesh, MeshBasicMaterial,
  MeshStandardMaterial, Vector3, type Vector2,
} from 'three';
import type { Vec3 } from '../types';
import type { Palette } from './palette';
import { Ribbon } from './ribbon';

export const kArrowPerNewton = 0.04; // m
const kLeast = 0.01; // N that are shown

// The force that the base exerts on the tip.
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

// Marks must be seen even where something hides them: their hidden part is drawn once more, translucent.
export class Mark {
  readonly mesh: Mesh<BufferGeometry, MeshStandardMaterial>;
  private readonly hidden: MeshBasicMaterial;

  constructor(geometry: BufferGeometry, opacity = 1, hiddenOpacity = 0.5) {
    const material = new MeshStandardMaterial({ roughness: 0.55, transparent: opacity < 1, opacity });
    material.depthWrite = opacity === 1;
    this.hidden = new MeshBasicMaterial({ transparent: true, opacity: hiddenOpacity * opacity, toneMapped: false });
    this.hidden.depthFunc = GreaterDepth;
    this.hidden.depthWrite = false;
    this.mesh = new Mesh(geometry, material);
    const behind = new Mesh(geometry, this.hidden);
    behind.renderOrder = 6;
    this.mesh.renderOrder = opacity < 1 ? 5 : 0;
    this.mesh.add(behind);
  }

  setColour(colour: Color, glow = 0.35): void {
    this.mesh.material.color.copy(colour);
    this.mesh.material.emissive.copy(colour).multiplyScalar(glow);
    this.hidden.color.copy(colour);
  }
}

const kShortest = 0.001; // m that are drawn
const kRadius = 0.0022;
const kTurns = 7;
const kPoints = 24 * kTurns + 1;
const kStraight = 0.12; // share of the length at each end

// The spring by which the hand holds the pen, from the ghost's tip to the pen's: a coil of a fixed number of turns.
export class Spring {
  readonly group = new Group();
  private readonly line: Ribbon;

  constructor(resolution: { value: Vector2 }) {
    this.line = new Ribbon(kPoints, 2.2, resolution, 0.05);
    // Along z from 0 to 1, radius 1; the group scales it.
    const points = new Float32Array(3 * kPoints);
    for (let i = 0; i < kPoints; ++i) {
      const t = i / (kPoints - 1);
      const u = Math.min(1, Math.max(0, (t - kStraight) / (1 - 2 * kStraight)));
      const radius = Math.min(1, 6 * u, 6 * (1 - u));
      const angle = 2 * Math.PI * kTurns * u;
      points.set([radius * Math.cos(angle), radius * Math.sin(angle), t], 3 * i);
    }
    this.line.setPoints(points, new Float32Array(kPoints).fill(1), kPoints);
    this.line.renderOrder = 8;
    this.line.material.depthTest = false; // its end is often inside of something
    this.group.add(this.line);
    this.group.visible = false;
  }

  place(from: Vec3, to: Vec3): void {
    const along = new Vector3(...to).sub(new Vector3(...from));
    const length = along.length();
    this.group.visible = length > kShortest;
    if (!this.group.visible) return;
    const radius = kRadius * Math.min(1, length / 0.008); // a short one is slender
    this.group.position.set(...from);
    this.group.quaternion.setFromUnitVectors(new Vector3(0, 0, 1), along.divideScalar(length));
    this.group.scale.set(radius, radius, length);
    this.line.setOpacity(Math.min(1, (length - kShortest) / 0.002));
  }

  setPalette(palette: Palette): void {
    this.line.setColour(palette.hand);
  }
}
