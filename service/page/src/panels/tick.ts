// How long ticks take: their distribution over the last seconds, and what omnid has counted since it started.
import type { History } from '../strips/history';
import { Card } from '../ui/card';
import { Drawing, fontOf, type Theme } from '../ui/theme';
import { make, setHidden, setText } from '../ui/dom';
import { plural, withUnit } from '../ui/format';
import { statusOf } from './state';
import type { PageState, Panel } from './state';

const kSpan_s = 4;
const kFirst_us = 1; // bins from here ...
const kLast_us = 10_000; // ... to here, each by a constant factor
const kBins = 48;
const kPeriod_us = 1000; // of a tick
const kEvery = 5; // updates: twice a second

export interface TickSummary {
  bins: number[];
  count: number;
  p50_us: number;
  p99_us: number;
  max_us: number;
}

export function summarize(values_us: Float32Array): TickSummary {
  const sorted = values_us.slice().sort();
  const bins = new Array<number>(kBins).fill(0);
  const factor = kBins / Math.log(kLast_us / kFirst_us);
  for (const value of sorted) {
    const bin = Math.floor(Math.log(Math.max(value, kFirst_us) / kFirst_us) * factor);
    const at = Math.min(kBins - 1, bin);
    bins[at] = (bins[at] ?? 0) + 1;
  }
  const quantile = (share: number): number => sorted[Math.max(0, Math.ceil(share * sorted.length) - 1)] ?? NaN;
  return { bins, count: sorted.length, p50_us: quantile(0.5), p99_us: quantile(0.99), max_us: quantile(1) };
}

export class TickPanel implements Panel {
  readonly root: HTMLElement;
  readonly card = new Card({ id: 'tick', title: 'Tick', open: 'roomy' });
  private readonly drawing = new Drawing('tick-histogram');
  private readonly rows = make('dl', { class: 'rows wide' });
  private readonly values = new Map<string, HTMLElement>();
  private updates = 0;

  constructor(
    private readonly theme: Theme,
    private readonly window: () => { history: History | null; to_s: number },
  ) {
    this.root = this.card.root;
    this.drawing.root.classList.add('histogram');
    for (const name of ['Median', '99 of 100 below', 'Longest', 'Late', 'No scan in time', 'Dropped', 'Real time']) {
      const value = make('span', { class: 'row-value' });
      value.dataset['testid'] = `tick-${name.toLowerCase().replace(/ /g, '-')}`;
      this.values.set(name, value);
      this.rows.append(make('div', { class: 'row' }, make('dt', {}, name), make('dd', {}, value)));
    }
    const about = `Time of each tick in the last ${kSpan_s} s. Beyond the line: longer than its period.`;
    this.card.body.append(this.drawing.root, make('p', { class: 'muted' }, about), this.rows);
    theme.listen(() => {
      this.updates = 0;
    });
  }

  update(state: PageState): void {
    setHidden(this.root, state.signals.index('tick_us') < 0 && statusOf(state)?.tick === undefined);
    if (this.updates++ % kEvery !== 0) return;
    const { history, to_s } = this.window();
    const channel = state.signals.index('tick_us');
    if (!this.card.open || history === null || channel < 0) return this.writeStatus(state, null);
    const summary = summarize(history.values(channel, to_s, kSpan_s));
    this.drawing.draw((context, width, height) => this.paint(context, width, height, summary));
    const [p50, p99, max] = [summary.p50_us, summary.p99_us, summary.max_us].map((value) => withUnit(value, 'us'));
    const words = `median ${p50}, 99 of 100 below ${p99}, longest ${max}`;
    this.drawing.describe(`Tick times of the last ${kSpan_s} seconds: ${words}.`);
    this.writeStatus(state, summary);
  }

  private write(name: string, text: string): void {
    const value = this.values.get(name);
    if (value !== undefined) setText(value, text);
  }

  private writeStatus(state: PageState, summary: TickSummary | null): void {
    const tick = statusOf(state)?.tick;
    if (summary !== null) this.card.setNote(`median ${withUnit(summary.p50_us, 'us', 0)}`);
    else if (tick !== undefined) this.card.setNote(`median ${withUnit(tick.us_median, 'us', 0)}`);
    this.write('Median', withUnit(summary?.p50_us ?? tick?.us_median ?? NaN, 'us'));
    this.write('99 of 100 below', withUnit(summary?.p99_us ?? tick?.us_p99 ?? NaN, 'us'));
    this.write('Longest', `${withUnit(summary?.max_us ?? NaN, 'us')}, ever ${withUnit(tick?.us_max ?? NaN, 'us')}`);
    this.write('Late', tick === undefined ? '-' : `${tick.late} of ${tick.count}`);
    this.write('No scan in time', tick === undefined ? '-' : plural(tick.timeouts, 'time'));
    this.write('Dropped', `${plural(state.lost, 'sample')} on the way to this page`);
    const reason = tick?.realtime_reason ? `: ${tick.realtime_reason}` : '';
    this.write('Real time', tick === undefined ? '-' : tick.realtime ? 'granted' : `no${reason}`);
  }

  private paint(context: CanvasRenderingContext2D, width: number, height: number, summary: TickSummary): void {
    const foot = 1.25 * parseFloat(getComputedStyle(document.documentElement).fontSize);
    const tall = height - foot;
    const x = (us: number): number => (Math.log(us / kFirst_us) / Math.log(kLast_us / kFirst_us)) * width;
    const most = Math.log1p(Math.max(1, ...summary.bins));
    context.font = fontOf(0.6875);
    context.textBaseline = 'bottom';
    for (let us = kFirst_us; us <= kLast_us; us *= 10) {
      context.fillStyle = this.theme.colour('grid');
      context.fillRect(Math.round(x(us)), 0, 1, tall);
      context.fillStyle = this.theme.colour('muted');
      context.textAlign = us === kFirst_us ? 'left' : us === kLast_us ? 'right' : 'center';
      context.fillText(us < 1000 ? `${us} µs` : `${us / 1000} ms`, x(us), height);
    }
    const slot = width / kBins;
    const limit = Math.round((Math.log(kPeriod_us / kFirst_us) / Math.log(kLast_us / kFirst_us)) * kBins);
    summary.bins.forEach((count, bin) => {
      if (count === 0) return;
      const bar = Math.max(2, (Math.log1p(count) / most) * (tall - 4)); // logarithmic: a single late tick is seen
      context.fillStyle = this.theme.colour(bin >= limit ? 'error' : 'accent');
      context.fillRect(bin * slot + 0.5, tall - bar, Math.max(1, slot - 1), bar);
    });
    context.fillStyle = this.theme.colour('error');
    context.fillRect(Math.round(x(kPeriod_us)), 0, 1, tall);
    context.fillStyle = this.theme.colour('line');
    context.fillRect(0, tall, width, 1);
  }
}
