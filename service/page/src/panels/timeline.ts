// The time line: a slider over the kept minutes, with the range that would be exported marked in it.
import { make, setAttribute, setHidden } from '../ui/dom';
import { clock } from '../ui/format';

export class Timeline {
  readonly root: HTMLElement;
  private readonly range: HTMLInputElement;
  private readonly marked = make('span', { class: 'timeline-marked' });
  private begin_s = 0;
  private end_s = 0;

  constructor(scrub: (t_s: number) => void) {
    this.range = make('input', { type: 'range', min: 0, max: 0, step: 0.01, 'aria-label': 'Time that is shown' });
    this.range.dataset['testid'] = 'timeline';
    this.range.addEventListener('input', () => scrub(this.begin_s + this.range.valueAsNumber));
    this.root = make('span', { class: 'timeline' }, this.marked, this.range);
  }

  // `mark`: what would be exported is less than everything.
  update(begin_s: number, end_s: number, t_s: number, mark: { from_s: number; to_s: number } | null): void {
    const length_s = end_s - begin_s;
    const disabled = !(length_s > 0);
    if (this.range.disabled !== disabled) this.range.disabled = disabled;
    if (disabled) return;
    this.begin_s = begin_s;
    this.end_s = end_s;
    setAttribute(this.range, 'max', length_s.toFixed(2));
    const value = (t_s - begin_s).toFixed(2);
    if (this.range.value !== value) this.range.value = value;
    const before = this.end_s - t_s;
    setAttribute(this.range, 'aria-valuetext', before < 0.01 ? 'newest' : `${clock(before, 1)} before the newest`);
    const percent = (time_s: number): string =>
      `${Math.min(100, Math.max(0, (100 * (time_s - begin_s)) / length_s)).toFixed(2)}%`;
    setHidden(this.marked, mark === null);
    if (mark === null) return;
    this.marked.style.setProperty('--from', percent(mark.from_s));
    this.marked.style.setProperty('--to', percent(mark.to_s));
  }
}
