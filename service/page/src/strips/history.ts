// What the strips draw: the last minute sample by sample, and longer ago as the least and greatest values of groups of
// samples, so that no peak is ever missed and every window is drawn from about as many numbers as it has pixels.
import type { Live } from '../types';

const kRaw = 1 << 16; // samples: a minute at 1 kHz
const kLevels = [
  { samples: 8, groups: 1 << 13 }, // the same minute
  { samples: 64, groups: 1 << 14 }, // 17 minutes
];
const kJump_s = 1; // back by more: another clock, and all before has no place in its time

// A ring of groups of samples.
class Level {
  readonly times: Float64Array; // of a group's first sample
  readonly least: Float32Array;
  readonly greatest: Float32Array;
  begun = 0; // groups so far; the newest may be unfinished

  constructor(
    readonly samples: number,
    readonly capacity: number,
    private readonly channels: number,
  ) {
    this.times = new Float64Array(capacity);
    this.least = new Float32Array(capacity * channels);
    this.greatest = samples === 1 ? this.least : new Float32Array(capacity * channels);
  }

  get oldest(): number {
    return Math.max(0, this.begun - this.capacity);
  }

  timeOf(group: number): number {
    return this.times[group % this.capacity] ?? NaN;
  }

  // Sample number `index` since the beginning.
  add(index: number, t_s: number, row: Float32Array, from: number): void {
    const slot = Math.floor(index / this.samples) % this.capacity;
    const base = slot * this.channels;
    if (index % this.samples === 0) {
      this.begun = Math.floor(index / this.samples) + 1;
      this.times[slot] = t_s;
      for (let c = 0; c < this.channels; ++c) {
        const value = row[from + c] ?? NaN;
        this.least[base + c] = value;
        this.greatest[base + c] = value;
      }
      return;
    }
    for (let c = 0; c < this.channels; ++c) {
      const value = row[from + c] ?? NaN;
      const low = this.least[base + c] ?? NaN;
      const high = this.greatest[base + c] ?? NaN;
      // NaN, nothing measured, gives way to any number
      if (!(low <= value) && value === value) this.least[base + c] = value;
      if (!(high >= value) && value === value) this.greatest[base + c] = value;
    }
  }

  // First group that begins at or after t_s.
  find(t_s: number): number {
    let low = this.oldest;
    let high = this.begun;
    while (low < high) {
      const middle = (low + high) >>> 1;
      if (this.timeOf(middle) < t_s) low = middle + 1;
      else high = middle;
    }
    return low;
  }
}

export class History {
  private readonly levels: Level[];
  private count = 0;
  private last_s = -Infinity;

  constructor(readonly channels: number) {
    this.levels = [
      new Level(1, kRaw, channels),
      ...kLevels.map(({ samples, groups }) => new Level(samples, groups, channels)),
    ];
  }

  add(live: Live): void {
    for (let i = 0; i < live.count; ++i) {
      const t_s = live.times_s[i] ?? NaN;
      if (t_s < this.last_s - kJump_s) this.clear();
      if (!(t_s > this.last_s)) continue; // sent before
      this.last_s = t_s;
      for (const level of this.levels) level.add(this.count, t_s, live.samples, i * this.channels);
      ++this.count;
    }
  }

  // NaN: there is none.
  get newest_s(): number {
    return this.last_s === -Infinity ? NaN : this.last_s;
  }

  private clear(): void {
    for (const level of this.levels) level.begun = 0;
    this.count = 0;
    this.last_s = -Infinity;
  }

  // The level that has the time `from_s` and about one group in `column_s`: fine enough, and no finer.
  level(from_s: number, to_s: number, column_s: number): Level {
    let chosen = this.levels[0] as Level;
    for (const level of this.levels) {
      const reaches = chosen.oldest === 0 || chosen.timeOf(chosen.oldest) <= from_s;
      const groups = level.find(to_s) - level.find(from_s);
      const fine = groups * column_s >= to_s - from_s;
      if (!reaches || fine) chosen = level;
    }
    return chosen;
  }

  // The values of one channel in the last `span_s` before `to_s`, sample by sample, NaN left out.
  values(channel: number, to_s: number, span_s: number): Float32Array {
    const raw = this.levels[0] as Level;
    const from = raw.find(to_s - span_s);
    const to = raw.find(to_s + 1e-9);
    const values = new Float32Array(Math.max(0, to - from));
    let n = 0;
    for (let i = from; i < to; ++i) {
      const value = raw.least[(i % raw.capacity) * this.channels + channel] ?? NaN;
      if (value === value) values[n++] = value;
    }
    return values.subarray(0, n);
  }
}

export type { Level };
