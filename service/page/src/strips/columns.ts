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
