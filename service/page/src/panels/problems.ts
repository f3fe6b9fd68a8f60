// Problems and what to do. A fault of one millisecond is seen, and stays long enough to be read.
import { Card } from '../ui/card';
import { KeyedList, make, setAttribute, setHidden, setText } from '../ui/dom';
import { findings } from './findings';
import type { Finding, Watched } from './findings';
import { plural } from '../ui/format';
import { statusOf } from './state';
import type { PageState, Panel } from './state';
import type { Live } from '../types';

const kStays_ms = 3000; // after it was seen last
const kLateOver = 20; // statuses, two a second, over which late ticks are counted
const kWords = { error: 'Error', warning: 'Warning', hint: 'Hint' };

export class ProblemsPanel implements Panel {
  readonly root: HTMLElement;
  private readonly card = new Card({ id: 'problems', title: 'Problems and what to do', important: true });
  private readonly well = make('p', { class: 'all-well' }, 'All is well.');
  private readonly list: KeyedList<Finding>;
  private readonly seen = new Map<string, { finding: Finding; at_ms: number }>();
  private deviceFaults = 0;
  private tickFaults = 0;
  private ticks: { status: unknown; count: number; late: number }[] = [];

  constructor() {
    this.root = this.card.root;
    const items = make('ul', { class: 'problems' });
    this.list = new KeyedList<Finding>(items, makeRow, writeRow);
    this.card.body.append(make('div', { 'aria-live': 'polite', 'data-testid': 'problems' }, this.well, items));
  }

  // Every sample counts, as faults may be short.
  add(live: Live, state: PageState): void {
    const device = state.signals.index('device_faults');
    const tick = state.signals.index('tick_faults');
    const channels = state.signals.channels;
    for (let i = 0; i < live.count; ++i) {
      if (device >= 0) this.deviceFaults |= live.samples[i * channels + device] ?? 0;
      if (tick >= 0) this.tickFaults |= live.samples[i * channels + tick] ?? 0;
    }
  }

  update(state: PageState): void {
    const now_ms = performance.now();
    for (const finding of findings(state, this.watch(state))) {
      this.seen.set(finding.key, { finding, at_ms: now_ms });
    }
    for (const [key, { at_ms }] of this.seen) if (now_ms - at_ms > kStays_ms) this.seen.delete(key);
    const shown = [...this.seen.values()].map((entry) => entry.finding);
    const order = { error: 0, warning: 1, hint: 2 };
    shown.sort((a, b) => order[a.severity] - order[b.severity]);
    this.list.update(shown, (finding) => finding.key);
    setText(this.well, shown.length > 0 ? '' : 'All is well.');
    setHidden(this.well, shown.length > 0);
    const bad = shown.filter((finding) => finding.severity !== 'hint').length;
    const hints = shown.length > 0 ? plural(shown.length, 'hint') : 'all is well';
    this.card.setNote(bad > 0 ? plural(bad, 'problem') : hints);
    setAttribute(this.root, 'data-worst', shown[0]?.severity ?? 'none');
  }

  private watch(state: PageState): Watched {
    const status = statusOf(state);
    const tick = status?.tick;
    const last = this.ticks.at(-1);
    if (tick !== undefined && last?.status !== status) {
      if (last !== undefined && tick.count < last.count) this.ticks = []; // omnid has started again
      this.ticks.push({ status, count: tick.count, late: tick.late });
      if (this.ticks.length > kLateOver) this.ticks.shift();
    }
    const oldest = this.ticks[0];
    const newest = this.ticks.at(-1);
    const watched = {
      deviceFaults: this.deviceFaults >>> 0,
      tickFaults: this.tickFaults >>> 0,
      late: (newest?.late ?? 0) - (oldest?.late ?? 0),
      ticks: (newest?.count ?? 0) - (oldest?.count ?? 0),
    };
    this.deviceFaults = this.tickFaults = 0;
    return watched;
  }
}

function makeRow(finding: Finding): HTMLElement {
  const level = make('span', { class: 'problem-level' }, kWords[finding.severity]);
  const what = make('span', { class: 'problem-what' });
  const fix = make('span', { class: 'problem-fix' });
  return make('li', { class: 'problem' }, level, make('span', { class: 'problem-text' }, what, fix));
}

function writeRow(row: HTMLElement, finding: Finding): void {
  setAttribute(row, 'data-severity', finding.severity);
  const [level, what, fix] = ['.problem-level', '.problem-what', '.problem-fix'].map((name) => row.querySelector(name));
  if (level) setText(level, kWords[finding.severity]);
  if (what) setText(what, finding.what);
  if (fix) setText(fix, finding.fix === '' ? '' : finding.fix);
}
