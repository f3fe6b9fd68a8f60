// Which channel and which flag is what. Channels are found by their names, so that the page also works with a service
// that has more or fewer of them: what is not there reads as NaN, and is not shown.
import type { Hello, Live, Vec3 } from '../types';

// First name that exists wins.
const kNames = {
  tip_x: ['tip_x_m', 'position_x_m', 'device_point_x_m'],
  tip_y: ['tip_y_m', 'position_y_m', 'device_point_y_m'],
  tip_z: ['tip_z_m', 'position_z_m', 'device_point_z_m'],
  force_x: ['force_x_N'],
  force_y: ['force_y_N'],
  force_z: ['force_z_N'],
  gap: ['gap_m'],
  sigma: ['sigma_m', 'position_sigma_m'],
  cov_xx: ['cov_xx_m2'],
  cov_yy: ['cov_yy_m2'],
  cov_zz: ['cov_zz_m2'],
  tick_time: ['tick_us'],
  chi2: ['fit_chi2', 'chi2'],
  dof: ['fit_dof', 'dof'],
  tick_faults: ['tick_faults'],
  device_faults: ['device_faults'],
  limits: ['tool_limits'],
  strokes: ['strokes'],
} as const;

export type Role = keyof typeof kNames;

// Bits of the channel "tool_limits" (base::ToolLimit) that say why there is no pose.
const kContradicted = 16;
const kFrozen = 64;

// Flags in words, compared without case, spaces and signs.
function plain(name: string): string {
  return name.toLowerCase().replace(/[^a-z0-9]/g, '');
}

export class Signals {
  readonly channels: number;
  private readonly indices = new Map<Role, number>();
  private readonly bits = new Map<string, number>();

  constructor(hello: Hello) {
    this.channels = hello.channels.length;
    const byName = new Map(hello.channels.map((channel, index) => [channel.name, index]));
    for (const [role, names] of Object.entries(kNames)) {
      const found = names.map((name) => byName.get(name)).find((index) => index !== undefined);
      if (found !== undefined) this.indices.set(role as Role, found);
    }
    for (const flag of hello.flags) this.bits.set(plain(flag.name), flag.bit);
  }

  // -1: there is none
  index(role: Role): number {
    return this.indices.get(role) ?? -1;
  }

  // Of sample i; NaN: not there.
  at(live: Live, role: Role, i: number): number {
    const c = this.index(role);
    if (c < 0 || i < 0 || i >= live.count) return NaN;
    return live.samples[i * this.channels + c] ?? NaN;
  }

  newest(live: Live, role: Role): number {
    return this.at(live, role, live.count - 1);
  }

  tip(live: Live, i = live.count - 1): Vec3 {
    return [this.at(live, 'tip_x', i), this.at(live, 'tip_y', i), this.at(live, 'tip_z', i)];
  }

  force(live: Live, i = live.count - 1): Vec3 {
    return [this.at(live, 'force_x', i), this.at(live, 'force_y', i), this.at(live, 'force_z', i)];
  }

  // One standard deviation of the tip, norm over the axes.
  sigma(live: Live): number {
    const given = this.newest(live, 'sigma');
    if (Number.isFinite(given)) return given;
    return Math.sqrt(this.newest(live, 'cov_xx') + this.newest(live, 'cov_yy') + this.newest(live, 'cov_zz'));
  }

  // A magnet is near, but no pose fits.
  contradicted(live: Live): boolean {
    return (this.newest(live, 'limits') & kContradicted) !== 0;
  }

  // Every sensor repeats itself.
  frozen(live: Live): boolean {
    return (this.newest(live, 'limits') & kFrozen) !== 0;
  }

  // Any of these flags; null: the service has none of them.
  flag(live: Live, ...names: string[]): boolean | null {
    let known = false;
    for (const name of names) {
      const bit = this.bits.get(plain(name));
      if (bit === undefined) continue;
      known = true;
      if (((live.flags >>> bit) & 1) === 1) return true;
    }
    return known ? false : null;
  }
}

export function length(v: Vec3): number {
  return Math.hypot(v[0], v[1], v[2]);
}
