// The way of the tip during the last seconds, fading out.
import type { Vector2 } from 'three';
import type { Palette } from './palette';
import { Ribbon } from './ribbon';

const kSeconds = 3;
const kPoints = 400; // for kSeconds at about 120 points per second
const kJump = 0.02; // m from point to point: not a movement
const kVisible = 3e-4; // m of extent

export class Trail {
  readonly line: Ribbon;
  private times = new Float64Array(kPoints); // ring
  private places = new Float32Array(3 * kPoints);
  private first = 0;
  private count = 0;
  private readonly points = new Float32Array(3 * kPoints);
  private readonly opacities = new Float32Array(kPoints);

  constructor(resolution: { value: Vector2 }) {
    this.line = new Ribbon(kPoints, 2.5, resolution);
    this.line.renderOrder = 3;
  }

  add(t_s: number, x: number, y: number, z: number): void {
    const newest = (this.first + this.count - 1) % kPoints;
    if (this.count > 0 && t_s <= this.times[newest]!) {
      if (t_s < this.times[newest]! - 1) this.clear(); // a recording was wound back
      else return;
    }
    if (this.count === kPoints) {
      this.first = (this.first + 1) % kPoints;
      this.count -= 1;
    }
    const at = (this.first + this.count) % kPoints;
    this.times[at] = t_s;
    this.places.set([x, y, z], 3 * at);
    this.count += 1;
  }

  clear(): void {
    this.count = 0;
  }

  // True if there is anything to see, which then changes by fading.
  update(now_s: number): boolean {
    while (this.count > 0 && this.times[this.first]! < now_s - kSeconds) {
      this.first = (this.first + 1) % kPoints;
      this.count -= 1;
    }
    let extent = 0;
    for (let i = 0; i < this.count; ++i) {
      const at = (this.first + i) % kPoints;
      const p = this.places.subarray(3 * at, 3 * at + 3);
      this.points.set(p, 3 * i);
      const far = (j: number) =>
        Math.hypot(p[0]! - this.points[j]!, p[1]! - this.points[j + 1]!, p[2]! - this.points[j + 2]!);
      extent = Math.max(extent, far(0));
      const age = Math.max(0, now_s - this.times[at]!) / kSeconds;
      this.opacities[i] = 0.8 * Math.max(0, 1 - age) ** 1.5;
      if (i > 0 && far(3 * (i - 1)) > kJump) this.opacities[i] = this.opacities[i - 1] = 0;
    }
    const seen = extent > kVisible;
    if (seen || this.line.visible) this.line.setPoints(this.points, this.opacities, seen ? this.count : 0);
    this.line.visible = seen;
    return seen;
  }

  setPalette(palette: Palette): void {
    this.line.setColour(palette.accent);
  }
}
