// The strips below the view: one per group of channels and unit, those that the person has chosen.
import 'uplot/dist/uPlot.min.css';
import { make, makeButton, recall, remember, setPressed, setText } from '../ui/dom';
import { shownUnit } from '../ui/format';
import type { PageState } from '../panels/state';
import type { Theme } from '../ui/theme';
import type { Channel, Hello } from '../types';
import type { History } from './history';
import { Strip } from './strip';
import type { StripOptions } from './strip';

const kSpans_s = [2, 10, 60];
const kBudget_ms = 3; // of a frame; strips that find no room are drawn in the next one
// Groups that are open before the person has chosen; on a narrow screen only the first ones.
const kFirst = ['position', 'force', 'speed', 'current', 'temperature', 'timing'];
const kFirstNarrow = 2;

export class StripBoard {
  readonly root: HTMLElement;
  private readonly chips = make('div', { class: 'chips', role: 'group', 'aria-label': 'Strips that are shown' });
  private readonly grid = make('div', { class: 'strip-grid' });
  private readonly mode = make('span', { class: 'badge replay', hidden: true }, 'REPLAY');
  private readonly empty = make('p', { class: 'muted', hidden: true }, 'No strip is chosen.');
  private readonly span: HTMLSelectElement;
  private strips: Strip[] = [];
  private open: boolean[] = [];
  private next = 0; // strip that is drawn first
  private shown = true; // else nothing is drawn

  constructor(private readonly theme: Theme) {
    const options = kSpans_s.map((s) => make('option', { value: s }, `${s} s`));
    this.span = make('select', { id: 'span', 'data-testid': 'span' }, ...options);
    this.span.value = kSpans_s.map(String).find((s) => s === recall('span')) ?? '10';
    this.span.addEventListener('change', () => remember('span', this.span.value));
    const chooser = make('span', { class: 'chooser' }, make('label', { for: 'span' }, 'Last'), this.span);
    const bar = make('div', { class: 'strip-bar' }, make('h2', {}, 'Strips'), this.mode, chooser, this.chips);
    this.root = make('section', { class: 'strips', 'aria-label': 'Strips' }, bar, this.grid, this.empty);
    theme.listen(() => {
      for (const strip of this.strips) strip.recolour();
    });
  }

  setHello(hello: Hello): void {
    const options = stripsOf(hello.channels);
    const first = kFirst.slice(0, matchMedia('(max-width: 699px)').matches ? kFirstNarrow : undefined);
    this.strips = options.map((option) => new Strip(option, this.theme));
    this.open = options.map((option) => {
      const chosen = recall(`strip.${option.id}`);
      return chosen === null ? option.main && first.includes(option.group) : chosen === 'open';
    });
    this.chips.replaceChildren(...options.map((option, i) => this.makeChip(option, i)));
    this.grid.replaceChildren(...this.strips.map((strip) => strip.root));
    this.strips.forEach((strip, i) => strip.setOpen(this.open[i] === true));
    this.showEmpty();
  }

  setShown(on: boolean): void {
    this.shown = on;
  }

  // Once a frame; `to_s`: end of the window.
  draw(history: History, to_s: number): void {
    if (!this.shown || !Number.isFinite(to_s)) return;
    const span_s = Number(this.span.value);
    const start_ms = performance.now();
    const count = this.strips.length;
    for (let i = 0; i < count; ++i) {
      const at = (this.next + i) % count;
      const strip = this.strips[at];
      if (strip === undefined || !strip.wants(to_s, span_s)) continue;
      const now_ms = performance.now();
      if (now_ms - start_ms > kBudget_ms) {
        this.next = at;
        return;
      }
      strip.draw(history, to_s, span_s, now_ms);
    }
    this.next = 0;
  }

  // Ten times a second: the values as text.
  update(state: PageState): void {
    if (!this.shown) return;
    for (const strip of this.strips) strip.update(state.live, state.signals.channels);
    if (this.mode.hidden === state.replay) this.mode.hidden = !state.replay;
    if (this.empty.hidden) return;
    setText(this.empty, this.strips.length === 0 ? 'Waiting for the first message.' : 'Choose a strip above.');
  }

  private makeChip(option: StripOptions, i: number): HTMLElement {
    const chip = makeButton(option.title, () => {
      const open = this.open[i] !== true;
      this.open[i] = open;
      remember(`strip.${option.id}`, open ? 'open' : 'closed');
      setPressed(chip, open);
      this.strips[i]?.setOpen(open);
      this.showEmpty();
    }, { class: 'chip', pressed: this.open[i] === true });
    chip.dataset['testid'] = `chip-${option.id}`;
    return chip;
  }

  private showEmpty(): void {
    this.empty.hidden = this.open.includes(true);
  }
}

interface GroupedStrip extends StripOptions {
  group: string;
  main: boolean; // has the most lines of its group
}

// One strip per group and unit, in the order of the channels.
function stripsOf(channels: Channel[]): GroupedStrip[] {
  const strips = new Map<string, GroupedStrip>();
  channels.forEach((channel, index) => {
    const key = `${channel.group}|${channel.unit}`;
    const strip = strips.get(key) ?? {
      id: key.toLowerCase().replace(/[^a-z0-9]+/g, '-').replace(/-$/, ''),
      title: channel.group,
      group: channel.group,
      main: false,
      unit: channel.unit,
      lines: [],
    };
    strip.lines.push({ channel: index, label: channel.label });
    strips.set(key, strip);
  });
  const all = [...strips.values()];
  for (const strip of all) {
    const group = all.filter((other) => other.group === strip.group);
    strip.main = group.every((other) => other === strip || other.lines.length < strip.lines.length);
    const name = strip.lines.length === 1 ? strip.lines[0]?.label : shownUnit(strip.unit).unit;
    if (!strip.main && name) strip.title = `${strip.group}: ${name}`;
  }
  for (const strip of all) strip.title = strip.title.charAt(0).toUpperCase() + strip.title.slice(1);
  return all;
}
