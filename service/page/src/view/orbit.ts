// The eye: turns about a point, z stays up. Knows nothing of drawing, so that it works without WebGL too.
import { MathUtils, PerspectiveCamera, Vector3 } from 'three';
import type { Vec3 } from '../types';

export type CameraName = 'front' | 'side' | 'top' | 'near';

// What the first view shows: around `centre`, `width` m wide in all.
export interface Subject {
  centre: Vec3;
  width: number;
}

interface Eye {
  azimuth: number; // rad, of the eye as seen from the target; -pi/2: in front of the base
  elevation: number; // rad
  distance: number; // in units of what fits everything
  target: Vector3;
}

const kFieldOfView = 25; // degrees, vertical
const kSlope = Math.tan(MathUtils.degToRad(kFieldOfView / 2));
const kShare = 0.25; // of the picture's width, for what there is to touch ...
const kHalfHeightLeast = 0.05; // ... but so much of pen and base is seen, m
const kCentre = new Vector3(0, 0, 0.03); // of base, scene and pen
const kHalfHeight = 0.15; // that fits around it ...
const kHalfWidth = 0.112; // ... and in a narrow window
const kDistances = { min: 0.12, max: 2.5 };
const kElevations = { min: MathUtils.degToRad(-6), max: MathUtils.degToRad(89.5) };
const kPanMax = 0.2; // m, of the target from the centre
const kFollowSlack = 0.012; // m that the pen moves in a close-up before the eye follows
const kSettle = 9; // 1/s: how fast a move of the camera is completed

const kPresets: Record<CameraName, { azimuth: number; elevation: number; distance: number }> = {
  front: { azimuth: -70, elevation: 23, distance: 0.84 },
  side: { azimuth: -4, elevation: 12, distance: 0.84 },
  top: { azimuth: -90, elevation: 89.5, distance: 0.8 },
  near: { azimuth: -66, elevation: 24, distance: 0.25 },
};

export class Orbit {
  readonly camera = new PerspectiveCamera(kFieldOfView, 1, 0.01, 5);
  private readonly now: Eye;
  private readonly goal: Eye;
  private shown: CameraName | null = null; // null: turned or moved by hand
  private subject: Subject | null = null;
  private following = false;
  private held = false;

  constructor() {
    this.camera.up.set(0, 0, 1);
    this.now = { azimuth: 0, elevation: 0, distance: 1, target: new Vector3() };
    this.goal = { azimuth: 0, elevation: 0, distance: 1, target: new Vector3() };
    this.preset('front', null, true);
  }

  resize(width: number, height: number): void {
    this.camera.aspect = width / Math.max(height, 1);
    this.camera.updateProjectionMatrix();
    this.frame(true);
    this.place();
  }

  // What there is to touch, for the views that show it: a quarter of the picture's width. null: nothing.
  setSubject(subject: Subject | null): void {
    const [a, b] = [this.subject, subject];
    if (a?.width === b?.width && a?.centre.every((value, i) => value === b?.centre[i])) return;
    const jump = a === null; // the first scene
    this.subject = subject;
    this.frame(jump);
  }

  // `pen`: the tip, if there is one.
  preset(name: CameraName, pen: Vec3 | null, jump: boolean): void {
    const preset = kPresets[name];
    const azimuth = MathUtils.degToRad(preset.azimuth);
    const turns = Math.round((this.now.azimuth - azimuth) / (2 * Math.PI)); // the short way round
    this.goal.azimuth = azimuth + turns * 2 * Math.PI;
    this.goal.elevation = MathUtils.degToRad(preset.elevation);
    this.goal.distance = preset.distance;
    this.following = name === 'near';
    this.shown = name;
    if (this.following) {
      this.goal.target.set(...(pen ?? ([0, 0, 0.055] as Vec3)));
    } else if (this.subject !== null && name !== 'top') {
      this.goal.target.set(...this.subject.centre);
      this.goal.distance = Math.min(preset.distance, this.distanceTo(this.subject));
    } else {
      this.goal.target.copy(kCentre);
    }
    if (jump) this.jump();
  }

  // A close-up keeps the pen in the middle, calmly: not while the hand drags it, and not for small movements.
  follow(pen: Vec3): boolean {
    if (!this.following || this.held) return false;
    const to = new Vector3(...pen).sub(this.goal.target);
    const slack = to.length() - kFollowSlack;
    if (slack <= 0) return false;
    this.goal.target.addScaledVector(to.normalize(), slack);
    return true;
  }

  hold(on: boolean): void {
    this.held = on;
  }

  // By hand: at once.
  turn(azimuth: number, elevation: number): void {
    this.shown = null;
    this.goal.azimuth += azimuth;
    this.goal.elevation = MathUtils.clamp(this.goal.elevation + elevation, kElevations.min, kElevations.max);
    this.now.azimuth = this.goal.azimuth;
    this.now.elevation = this.goal.elevation;
    this.place();
  }

  zoom(factor: number): void {
    if (!(factor > 0)) return;
    this.shown = null;
    this.goal.distance = MathUtils.clamp(this.goal.distance / factor, kDistances.min, kDistances.max);
  }

  // Shifts what is seen by so many metres to the right and up.
  pan(right: number, up: number): void {
    this.following = false;
    this.shown = null;
    const shift = new Vector3(...this.right()).multiplyScalar(-right).addScaledVector(new Vector3(...this.up()), -up);
    this.goal.target.add(shift).sub(kCentre).clampLength(0, kPanMax).add(kCentre);
    this.now.target.copy(this.goal.target);
    this.place();
  }

  // True as long as it moves.
  update(seconds: number): boolean {
    const share = 1 - Math.exp(-kSettle * seconds);
    const { now, goal } = this;
    now.azimuth += share * (goal.azimuth - now.azimuth);
    now.elevation += share * (goal.elevation - now.elevation);
    now.distance *= (goal.distance / now.distance) ** share;
    now.target.lerp(goal.target, share);
    const rest =
      Math.abs(goal.azimuth - now.azimuth) +
      Math.abs(goal.elevation - now.elevation) +
      Math.abs(Math.log(goal.distance / now.distance)) +
      10 * goal.target.distanceTo(now.target);
    if (rest < 1e-3) this.jump();
    else this.place();
    return rest >= 1e-3;
  }

  jump(): void {
    this.now.azimuth = this.goal.azimuth;
    this.now.elevation = this.goal.elevation;
    this.now.distance = this.goal.distance;
    this.now.target.copy(this.goal.target);
    this.place();
  }

  forward(): Vec3 {
    return this.axis(2, -1);
  }

  right(): Vec3 {
    return this.axis(0, 1);
  }

  up(): Vec3 {
    return this.axis(1, 1);
  }

  // Metres per pixel of a canvas of this height, at the target.
  metresPerPixel(height: number): number {
    const distance = this.camera.position.distanceTo(this.now.target);
    return (2 * distance * kSlope) / Math.max(height, 1);
  }

  private axis(column: number, sign: number): Vec3 {
    const e = this.camera.matrixWorld.elements;
    return [sign * e[4 * column]!, sign * e[4 * column + 1]!, sign * e[4 * column + 2]!];
  }

  // Again, in a view that shows the subject.
  private frame(jump: boolean): void {
    if (this.shown === 'front' || this.shown === 'side') this.preset(this.shown, null, jump);
  }

  // Distance at which everything fits, m.
  private fit(): number {
    return Math.max(kHalfHeight / kSlope, kHalfWidth / (kSlope * this.camera.aspect));
  }

  private distanceTo(subject: Subject): number {
    const halfWidth = subject.width / (2 * kShare);
    const halfHeight = Math.max(halfWidth / this.camera.aspect, kHalfHeightLeast);
    return Math.max(kDistances.min, halfHeight / (kSlope * this.fit()));
  }

  private place(): void {
    const { azimuth, elevation, distance, target } = this.now;
    const d = this.fit() * distance;
    this.camera.position.set(
      target.x + d * Math.cos(elevation) * Math.cos(azimuth),
      target.y + d * Math.cos(elevation) * Math.sin(azimuth),
      target.z + d * Math.sin(elevation),
    );
    this.camera.lookAt(target);
    this.camera.updateMatrixWorld();
  }
}
