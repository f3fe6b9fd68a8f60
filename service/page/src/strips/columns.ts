// From the history to what uPlot draws: for every column of pixels that has samples, two rows: the least and the
// greatest value, whichever is nearer to the line so far first.
import type { History } from './history';

export type Rows = [number[], ...(number | null)[][]]; // x, then one array per series

const kGap_s = 0.1; // longer without samples: the line is broken
const kGapColumns = 3;

export interface Window {
  from_s: number;
  to_s: number;
  columns: number; // of pixels
}

export interface Range {
  low: number;
  high: number; // low > high: there was no value
}

// Reused from frame to frame: no garbage at sixty frames a second.
export class Columns {
  readonly rows: Rows;
  private readonly low: Float64Array;
  private readonly high: Float64Array;
  private readonly last: Float64Array; // value of each line so far

  constructor(
    private readonly indices: number[], // channels
    private readonly factors: number[], // shown = factor x value
  ) {
    this.rows = [[], ...indices.map(() => [])];
    this.low = new Float64Array(indices.length);
    this.high = new Float64Array(indices.length);
    this.last = new Float64Array(indices.length);
  }

  // Fills the rows; x is the time after to_s, so <= 0. Returns the range of the series that are shown.
  fill(history: History, window: Window, shown: boolean[]): Range {
    const { from_s, to_s, columns } = window;
    const column_s = (to_s - from_s) / columns;
    const level = history.level(from_s, to_s, column_s);
    const last = level.find(to_s + 1e-9);
    const gap_s = Math.max(kGap_s, kGapColumns * column_s);
    const range: Range = { low: Infinity, high: -Infinity };
    let n = 0; // rows
    let column = NaN; // number of the column since time began, so that columns do not creep
    let before_s = NaN;
    this.last.fill(NaN);
    for (let group = level.find(from_s); group < last; ++group) {
      const t_s = level.timeOf(group);
      const now = Math.floor(t_s / column_s);
      if (now !== column) {
        if (!Number.isNaN(column)) n = this.emit(n, column * column_s - to_s, column_s, shown, range);
        if (t_s - before_s > gap_s) n = this.emitGap(n, before_s - to_s + column_s);
        column = now;
        this.low.fill(Infinity);
        this.high.fill(-Infinity);
      }
      before_s = t_s;
      const base = (group % level.capacity) * history.channels;
      for (let s = 0; s < this.indices.length; ++s) {
        const at = base + (this.indices[s] ?? 0);
        const low = level.least[at] ?? NaN;
        const high = level.greatest[at] ?? NaN;
        if (low < (this.low[s] ?? 0)) this.low[s] = low;
        if (high > (this.high[s] ?? 0)) this.high[s] = high;
      }
    }
    if (!Number.isNaN(column)) n = this.emit(n, column * column_s - to_s, column_s, shown, range);
    for (const row of this.rows) row.length = n;
    return range;
  }

  private emit(n: number, x: number, column_s: number, shown: boolean[], range: Range): number {
    this.rows[0][n] = x;
    this.rows[0][n + 1] = x + column_s / 2;
    for (let s = 0; s < this.indices.length; ++s) {
      const row = this.rows[s + 1];
      if (row === undefined) continue;
      const factor = this.factors[s] ?? 1;
      const low = (this.low[s] ?? 0) * factor;
      const high = (this.high[s] ?? 0) * factor;
      if (!(low <= high)) {
        row[n] = row[n + 1] = null; // nothing measured
        this.last[s] = NaN;
        continue;
      }
      const before = this.last[s] ?? NaN;
      const falls = before - high > low - before || before >= high;
      row[n] = falls ? high : low;
      row[n + 1] = falls ? low : high;
      this.last[s] = falls ? low : high;
      if (shown[s] !== true) continue;
      if (low < range.low) range.low = low;
      if (high > range.high) range.high = high;
    }
    return n + 2;
  }

  private emitGap(n: number, x: number): number {
    const [times, ...values] = this.rows;
    times[n] = x;
    for (const row of values) row[n] = null;
    this.last.fill(NaN);
    return n + 1;
  }
}

const kPatience_ms = 1500;
const kShrinkBelow = 0.45; // of the axis is used

// The range of a strip's value axis: grows at once, shrinks only after a while, and ends on round numbers, so that
// the axis rests while the line moves.
export class RestingScale {
  private low = 0;
  private high = 1;
  private set = false;
  private roomy_ms = NaN; // since when it is larger than needed

  constructor(private readonly least: number) {} // smallest range: noise is not blown up to full height

  update(range: Range, now_ms: number): [number, number] {
    if (!(range.low <= range.high)) return [this.low, this.high];
    const used = range.high - range.low;
    const outside = range.low < this.low || range.high > this.high;
    const roomy = Math.max(used, this.least) < kShrinkBelow * (this.high - this.low);
    if (!roomy) this.roomy_ms = NaN;
    else if (Number.isNaN(this.roomy_ms)) this.roomy_ms = now_ms;
    if (!this.set || outside || now_ms - this.roomy_ms > kPatience_ms) {
      this.roomy_ms = NaN;
      const grows = this.set && outside;
      const low = grows ? Math.min(range.low, this.low) : range.low;
      const high = grows ? Math.max(range.high, this.high) : range.high;
      this.fit(low, high);
      this.set = true;
    }
    return [this.low, this.high];
  }

  private fit(low: number, high: number): void {
    const middle = (low + high) / 2;
    const half = Math.max((high - low) / 2, this.least / 2) * 1.1 || 0.5;
    const step = roundStep(half / 2);
    this.low = Math.floor((middle - half) / step) * step;
    this.high = Math.ceil((middle + half) / step) * step;
    if (low >= 0 && this.low < 0) this.low = 0; // what is never negative begins at zero
  }
}

// 1, 2 or 5 times a power of ten, at least x
function roundStep(x: number): number {
  const power = 10 ** Math.floor(Math.log10(x));
  const mantissa = x / power;
  return power * (mantissa <= 1 ? 1 : mantissa <= 2 ? 2 : mantissa <= 5 ? 5 : 10);
}
