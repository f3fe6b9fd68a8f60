// What of a Live message is drawn, read by the names of channels and flags. A service that lacks a name, or knows more
// of them, does no harm: what is missing is 0.
import type { ChannelName } from '../contract';
import { Signals } from '../signals';
import type { Aim, Contact, Hello, Live, Quat, Vec3, Vehicle } from '../types';

export interface Picture {
  valid: boolean; // there is a pose, perhaps an old one
  tracked: boolean; // the pose is of now
  tip: Vec3;
  orientation: Quat; // q_BT
  axis: Vec3; // out of the tip
  force: Vec3; // N
  currents: Vec3; // A
  covariance: [number, number, number, number, number, number]; // of the tip: xx, xy, xz, yy, yz, zz, m^2
  contacts: Contact[];
  vehicle: Vehicle | null;
  aim: Aim;
}

export function emptyPicture(): Picture {
  return {
    valid: false,
    tracked: false,
    tip: [0, 0, 0],
    orientation: [1, 0, 0, 0],
    axis: [0, 0, -1],
    force: [0, 0, 0],
    currents: [0, 0, 0],
    covariance: [0, 0, 0, 0, 0, 0],
    contacts: [],
    vehicle: null,
    aim: { present: false, tip: [0, 0, 0], axis: [0, 0, -1] },
  };
}

// A point of the tip's path: when and where.
export type TrailPoint = (t_s: number, x: number, y: number, z: number) => void;

export class PictureReader {
  private readonly signals: Signals;

  constructor(hello: Hello) {
    this.signals = new Signals(hello);
  }

  // Live without samples keeps what channels and flags said before.
  read(live: Live, before: Picture): Picture {
    const rest = { contacts: live.contacts, vehicle: live.vehicle, aim: live.aim };
    if (live.count === 0) return { ...before, ...rest };
    const valid = this.signals.flag(live, 'pose_valid') === true && this.signals.index('tip_x_m') >= 0;
    const tracked = this.signals.flag(live, 'tracked') === true;
    const at = (name: ChannelName) => this.value(live, live.count - 1, name);
    const orientation = unit([at('q_w'), at('q_x'), at('q_y'), at('q_z')]);
    return {
      ...rest,
      valid,
      tracked,
      tip: [at('tip_x_m'), at('tip_y_m'), at('tip_z_m')],
      orientation,
      axis: outOfTip(orientation),
      force: [at('force_x_N'), at('force_y_N'), at('force_z_N')],
      currents: [at('current_x_A'), at('current_y_A'), at('current_z_A')],
      covariance: [
        at('cov_xx_m2'), at('cov_xy_m2'), at('cov_xz_m2'), at('cov_yy_m2'), at('cov_yz_m2'), at('cov_zz_m2'),
      ],
    };
  }

  // The tip at about every `step`-th sample, oldest first, and at the newest one.
  path(live: Live, step: number, take: TrailPoint): void {
    for (let i = (live.count - 1) % step; i >= 0 && i < live.count; i += step) {
      const t = live.times_s[i] ?? 0;
      take(t, this.value(live, i, 'tip_x_m'), this.value(live, i, 'tip_y_m'), this.value(live, i, 'tip_z_m'));
    }
  }

  private value(live: Live, sample: number, name: ChannelName): number {
    const value = this.signals.at(live, name, sample);
    return Number.isFinite(value) ? value : 0;
  }
}

function unit(q: Quat): Quat {
  const n = Math.hypot(...q);
  if (!(n > 1e-6)) return [1, 0, 0, 0];
  return [q[0] / n, q[1] / n, q[2] / n, q[3] / n];
}

// -z of frame T in frame B.
function outOfTip([w, x, y, z]: Quat): Vec3 {
  return [-2 * (x * z + w * y), -2 * (y * z - w * x), -(1 - 2 * (x * x + y * y))];
}

// The picture in steps too small to see: as long as they stay the same, nothing needs to be drawn again.
export class PictureChanges {
  private last: number[] = [];

  differs(p: Picture): boolean {
    const key: number[] = [Number(p.valid), Number(p.tracked)];
    const add = (values: readonly number[], step: number) => {
      for (const value of values) key.push(Math.round(value / step));
    };
    if (p.valid) {
      add(p.tip, 4e-5);
      add(p.axis, 2e-3);
      add(p.force, 5e-3);
      for (const i of [0, 3, 5] as const) key.push(Math.round(20 * Math.log(p.covariance[i] + 1e-12)));
    }
    add(p.currents, 0.05);
    for (const contact of p.contacts) {
      add(contact.point, 4e-5);
      add(contact.normal, 1e-2);
    }
    key.push(p.contacts.length, Number(p.aim.present));
    if (p.aim.present) {
      add(p.aim.tip, 4e-5);
      add(p.aim.axis, 2e-3);
    }
    if (p.vehicle !== null) {
      add(p.vehicle.position, 4e-5);
      add([p.vehicle.heading, Number(p.vehicle.sliding)], 5e-3);
    }
    const same = key.length === this.last.length && key.every((value, i) => value === this.last[i]);
    this.last = key;
    return !same;
  }
}

const kForceLeast = 0.02; // N that are worth a word
const kAimLeast = 0.002; // m

// The view in words, for people who do not see it.
// `name`: of a touched object.
export function describe(picture: Picture, name: (object: number) => string): string {
  if (!picture.valid) return 'There is no pen.';
  if (!picture.tracked) return `The pen is lost. It was last seen ${place(picture.tip)}.`;
  const newton = Math.hypot(...picture.force);
  const touched = picture.contacts.map((contact) => name(contact.object) || 'the scene');
  const sentence = [`The pen's tip is ${place(picture.tip)}`];
  const tilt = Math.round((Math.acos(Math.min(1, Math.max(-1, -picture.axis[2]))) * 180) / Math.PI);
  if (tilt >= 10) sentence.push(`, tilted by ${tilt}°`);
  if (touched.length > 0) {
    const pressed = picture.contacts.reduce((most, contact) => Math.max(most, contact.normal_N), 0);
    sentence.push(`; it touches ${[...new Set(touched)].join(' and ')} with ${pressed.toFixed(2)} N`);
  } else {
    sentence.push('; it touches nothing');
  }
  if (newton >= kForceLeast) {
    sentence.push(`; the base pushes it with ${newton.toFixed(2)} N ${towards(picture.force)}`);
  }
  if (picture.aim.present) {
    const pull: Vec3 = [0, 1, 2].map((i) => picture.aim.tip[i]! - picture.tip[i]!) as Vec3;
    const away = Math.hypot(...pull);
    if (away >= kAimLeast) sentence.push(`; the hand pulls ${(1000 * away).toFixed(0)} mm ${towards(pull)}`);
  }
  return `${sentence.join('')}.`;
}

const kDirections: [string, string][] = [['left', 'right'], ['towards you', 'away from you'], ['down', 'up']];

// Where it points most.
function towards(v: Vec3): string {
  const size = v.map(Math.abs);
  const axis = size.indexOf(Math.max(...size)) as 0 | 1 | 2;
  return kDirections[axis]![v[axis] < 0 ? 0 : 1];
}

function place(p: Vec3): string {
  const mm = p.map((value) => Math.round(1000 * value)) as Vec3;
  const words = [
    mm[0] === 0 ? '' : `${Math.abs(mm[0])} mm to the ${mm[0] < 0 ? 'left' : 'right'}`,
    mm[1] === 0 ? '' : `${Math.abs(mm[1])} mm ${mm[1] < 0 ? 'towards' : 'away from'} you`,
    mm[2] === 0 ? '' : `${Math.abs(mm[2])} mm ${mm[2] < 0 ? 'down' : 'up'}`,
  ].filter((word) => word !== '');
  if (words.length === 0) return "at the core's centre";
  const last = words.pop()!;
  return `${words.length > 0 ? `${words.join(', ')} and ${last}` : last} from the core's centre`;
}
