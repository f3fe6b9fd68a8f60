// The range of a strip's value axis: grows at once, shrinks only after a while, and ends on round numbers, so that
// the axis rests while the line moves.
import type { Range } from './columns';

const kPatience_ms = 1500;
const kShrinkBelow = 0.45; // of the axis is used

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
