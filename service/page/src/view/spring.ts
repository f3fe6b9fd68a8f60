// The spring by which the hand holds the pen, from the ghost's tip to the pen's: a coil of a fixed number of turns.
import { Group, Vector3, type Vector2 } from 'three';
import type { Vec3 } from '../types';
import type { Palette } from './palette';
import { Ribbon } from './ribbon';

const kShortest = 0.001; // m that are drawn
const kRadius = 0.0022;
const kTurns = 7;
const kPoints = 24 * kTurns + 1;
const kStraight = 0.12; // share of the length at each end

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
