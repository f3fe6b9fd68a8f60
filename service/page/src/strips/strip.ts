// One strip: lines of one unit over the last seconds, and the list of their present values.
import uPlot from 'uplot';
import type { Live } from '../types';
import { make, setAttribute, setHidden, setPressed, setText } from '../ui/dom';
import { fixed, shownUnit } from '../ui/format';
import type { Theme } from '../ui/theme';
import { Columns, RestingScale, type Window } from './columns';
import type { History } from './history';

export interface Line {
  channel: number;
  label: string;
}

export interface StripOptions {
  id: string;
  title: string;
  unit: string; // of the messages
  lines: Line[];
}

const kMost_px = 1200; // columns per strip
const kLeast: Record<string, number> = { mm: 0.1, N: 0.02, A: 0.1, '°C': 1, µT: 1, µs: 10, 'mm/s': 2, V: 0.1 };
const kSync = 'omni-strips';

export class Strip {
  readonly root: HTMLElement;
  private readonly frame = make('div', { class: 'strip-chart', role: 'img' });
  private readonly entries: { button: HTMLButtonElement; value: HTMLElement; swatch: SVGLineElement }[] = [];
  private readonly columns: Columns;
  private readonly scale: RestingScale;
  private readonly shown: boolean[];
  private readonly factor: number;
  private readonly decimals: number;
  private plot: uPlot | null = null;
  private inSight = false;
  private dirty = true;
  private drawn_s = NaN; // end of the window that was drawn last
  private span_s = 10;

  constructor(
    private readonly options: StripOptions,
    private readonly theme: Theme,
  ) {
    const shown = shownUnit(options.unit);
    this.factor = shown.factor;
    this.decimals = shown.decimals;
    this.shown = options.lines.map(() => true);
    this.scale = new RestingScale(kLeast[shown.unit] ?? 0);
    this.columns = new Columns(
      options.lines.map((line) => line.channel),
      options.lines.map(() => shown.factor),
    );
    const unit = shown.unit === '' ? null : make('span', { class: 'strip-unit' }, shown.unit);
    const heading = make('h3', {}, options.title, unit === null ? '' : ' ', unit);
    const list = make('ul', { class: 'legend' }, ...options.lines.map((line, i) => this.makeEntry(line, i)));
    this.root = make('section', { class: 'strip', 'data-testid': `strip-${options.id}` }, heading, this.frame, list);
    this.root.setAttribute('aria-label', options.title);
    new ResizeObserver(() => this.resize()).observe(this.frame);
    new IntersectionObserver((seen) => {
      this.inSight = seen.at(-1)?.isIntersecting === true;
    }).observe(this.root);
    this.describe();
  }

  // Whether there is something to be drawn now.
  wants(to_s: number, span_s: number): boolean {
    if (!this.inSight || this.root.hidden || this.plot === null) return false;
    return this.dirty || to_s !== this.drawn_s || span_s !== this.span_s;
  }

  draw(history: History, to_s: number, span_s: number, now_ms: number): void {
    const plot = this.plot;
    if (plot === null) return;
    if (span_s !== this.span_s) {
      this.span_s = span_s;
      this.describe();
    }
    this.dirty = false;
    this.drawn_s = to_s;
    const width = Math.min(kMost_px, Math.max(50, Math.round(plot.bbox.width / uPlot.pxRatio)));
    const window: Window = { from_s: to_s - span_s, to_s, columns: width };
    const range = this.columns.fill(history, window, this.shown);
    const [low, high] = this.scale.update(range, now_ms);
    plot.batch(() => {
      plot.setData(this.columns.rows, false);
      plot.setScale('x', { min: -span_s, max: 0 });
      plot.setScale('y', { min: low, max: high });
    });
  }

  // Values as text: those under the pointer, else the newest.
  update(live: Live | null, channels: number): void {
    if (!this.inSight || this.root.hidden) return;
    const left = this.plot?.cursor.left ?? -1;
    const pointed = left >= 0 && this.plot !== null ? this.plot.posToIdx(left) : -1;
    this.entries.forEach((entry, i) => {
      const channel = this.options.lines[i]?.channel ?? 0;
      const newest = live === null ? NaN : (live.samples[(live.count - 1) * channels + channel] ?? NaN) * this.factor;
      const value = pointed >= 0 ? (this.columns.rows[i + 1]?.[pointed] ?? NaN) : newest;
      setText(entry.value, fixed(value, this.decimals));
    });
    setAttribute(this.root, 'data-pointed', String(pointed >= 0));
  }

  setOpen(open: boolean): void {
    setHidden(this.root, !open);
    this.dirty = true;
  }

  // New colours: canvases do not follow the style sheet.
  recolour(): void {
    this.entries.forEach((entry, i) => {
      entry.swatch.style.stroke = lineColour(i, this.theme.dark);
    });
    this.plot?.destroy();
    this.plot = null;
    this.resize();
  }

  private describe(): void {
    const what = `Chart of ${this.options.title} over the last ${this.span_s} seconds.`;
    setAttribute(this.frame, 'aria-label', `${what} Present values: in the list below.`);
  }

  private makeEntry(line: Line, i: number): HTMLElement {
    const svg = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
    const swatch = document.createElementNS('http://www.w3.org/2000/svg', 'line');
    svg.setAttribute('class', 'swatch');
    svg.setAttribute('viewBox', '0 0 18 4');
    svg.setAttribute('aria-hidden', 'true');
    for (const [name, at] of Object.entries({ x1: '0', y1: '2', x2: '18', y2: '2' })) swatch.setAttribute(name, at);
    swatch.style.stroke = lineColour(i, this.theme.dark);
    swatch.style.strokeDasharray = lineDash(i).join(' ');
    svg.append(swatch);
    const value = make('span', { class: 'legend-value' }, '-');
    const button = make('button', { type: 'button', class: 'legend-entry', 'aria-pressed': 'true' });
    button.title = 'Show or hide this line';
    button.append(svg, make('span', {}, line.label), value);
    button.addEventListener('click', () => {
      this.shown[i] = this.shown[i] !== true;
      setPressed(button, this.shown[i] === true);
      this.plot?.setSeries(i + 1, { show: this.shown[i] === true });
      this.dirty = true;
    });
    this.entries.push({ button, value, swatch });
    return make('li', {}, button);
  }

  private resize(): void {
    const { clientWidth, clientHeight } = this.frame;
    if (clientWidth === 0 || clientHeight === 0) return;
    if (this.plot === null) this.plot = this.makePlot(clientWidth, clientHeight);
    else this.plot.setSize({ width: clientWidth, height: clientHeight });
    this.dirty = true;
  }

  private makePlot(width: number, height: number): uPlot {
    const rem = parseFloat(getComputedStyle(document.documentElement).fontSize) / 16;
    const font = `${Math.round(11 * rem)}px system-ui, sans-serif`;
    const axis: uPlot.Axis = {
      stroke: this.theme.colour('muted'),
      font,
      grid: { stroke: this.theme.colour('grid'), width: 1 },
      ticks: { show: false },
      gap: 4,
    };
    const seconds = (_: uPlot, splits: number[]): string[] => splits.map((s) => `${s} s`);
    const line = (one: Line, i: number): uPlot.Series => ({
      label: one.label,
      show: this.shown[i] === true,
      scale: 'y',
      stroke: lineColour(i, this.theme.dark),
      dash: lineDash(i),
      width: 1.5,
      pxAlign: 0,
      points: { show: false },
    });
    return new uPlot(
      {
        width,
        height,
        legend: { show: false },
        padding: [8 * rem, 16 * rem, 0, 0],
        cursor: { drag: { x: false, y: false }, sync: { key: kSync }, points: { size: 5 }, y: false },
        scales: { x: { time: false, auto: false }, y: { auto: false } },
        axes: [
          { ...axis, size: 22 * rem, gap: 6, space: 60 * rem, values: seconds },
          { ...axis, size: 48 * rem, space: 26 * rem },
        ],
        series: [{}, ...this.options.lines.map(line)],
      },
      this.columns.rows,
      this.frame,
    );
  }
}

const kLight = ['#0072b2', '#c2410c', '#00805e', '#a8467a', '#8a6100', '#4a4fc4', '#0e7490', '#6b7280'];
const kDark = ['#56b4e9', '#ff8b4d', '#2bd4a0', '#e48fc0', '#f0c541', '#a5a9ff', '#5ad6e8', '#a9b1bd'];

// Colours of the lines, different for most people with a colour deficiency, too (Okabe and Ito, darker or lighter so
// that each has a contrast of at least 3 to the background of its theme).
export function lineColour(index: number, dark: boolean): string {
  const colours = dark ? kDark : kLight;
  return colours[index % colours.length] ?? '#888888';
}

// The same colours again are dashed.
export function lineDash(index: number): number[] {
  return index < kLight.length ? [] : index < 2 * kLight.length ? [6, 3] : [2, 3];
}
