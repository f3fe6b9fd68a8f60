// Values of channels and flags by name. A service that has more or fewer of them does no harm: what is not there reads as
// NaN, and is not shown.
import { kToolLimit } from './contract';
import type { ChannelName, FlagName } from './contract';
import type { Hello, Live, Vec3 } from './types';

export class Signals {
  readonly channels: number;
  private readonly indices: Map<string, number>;
  private readonly bits: Map<string, number>;

  constructor(hello: Hello) {
    this.channels = hello.channels.length;
    this.indices = new Map(hello.channels.map((channel, index) => [channel.name, index]));
    this.bits = new Map(hello.flags.map((flag) => [flag.name, flag.bit]));
  }

  // -1: there is none
  index(name: ChannelName): number {
    return this.indices.get(name) ?? -1;
  }

  // null: not all are there.
  columns(names: readonly ChannelName[]): number[] | null {
    const columns = names.map((name) => this.index(name));
    return columns.includes(-1) ? null : columns;
  }

  // Of sample i; NaN: not there.
  at(live: Live, name: ChannelName, i: number): number {
    const c = this.index(name);
    if (c < 0 || i < 0 || i >= live.count) return NaN;
    return live.samples[i * this.channels + c] ?? NaN;
  }

  newest(live: Live, name: ChannelName): number {
    return this.at(live, name, live.count - 1);
  }

  tip(live: Live, i = live.count - 1): Vec3 {
    return [this.at(live, 'tip_x_m', i), this.at(live, 'tip_y_m', i), this.at(live, 'tip_z_m', i)];
  }

  force(live: Live, i = live.count - 1): Vec3 {
    return [this.at(live, 'force_x_N', i), this.at(live, 'force_y_N', i), this.at(live, 'force_z_N', i)];
  }

  // One standard deviation of the tip, norm over the axes.
  sigma(live: Live): number {
    const given = this.newest(live, 'sigma_m');
    if (Number.isFinite(given)) return given;
    return Math.sqrt(this.newest(live, 'cov_xx_m2') + this.newest(live, 'cov_yy_m2') + this.newest(live, 'cov_zz_m2'));
  }

  // A magnet is near, but no pose fits.
  contradicted(live: Live): boolean {
    return (this.newest(live, 'tool_limits') & kToolLimit.contradicted) !== 0;
  }

  // Every sensor repeats itself.
  frozen(live: Live): boolean {
    return (this.newest(live, 'tool_limits') & kToolLimit.frozen) !== 0;
  }

  // 0: the service does not have it.
  mask(name: FlagName): number {
    const bit = this.bits.get(name);
    return bit === undefined ? 0 : 1 << bit;
  }

  // null: the service does not have it.
  flag(live: Live, name: FlagName): boolean | null {
    const mask = this.mask(name);
    return mask === 0 ? null : (live.flags & mask) !== 0;
  }
}

export function length(v: Vec3): number {
  return Math.hypot(v[0], v[1], v[2]);
}
