// The edge between view and strips: dragged, or moved by the arrow keys.
import { make } from './dom';
import { recall, remember } from './memory';

const kLeast = 15; // percent of the column's height that the strips take
const kMost = 80;
const kFirst = 36;
const kStep = 4;

export class Splitter {
  readonly root = make('div', { class: 'splitter', role: 'separator', tabindex: 0, 'aria-orientation': 'horizontal' });
  private percent: number;

  constructor(private readonly column: HTMLElement) {
    this.root.setAttribute('aria-label', 'Height of the strips');
    this.root.setAttribute('aria-valuemin', String(kLeast));
    this.root.setAttribute('aria-valuemax', String(kMost));
    const kept = Number(recall('strips') ?? NaN);
    this.percent = kept >= kLeast && kept <= kMost ? kept : kFirst;
    this.apply();
    this.root.addEventListener('pointerdown', (event) => this.root.setPointerCapture(event.pointerId));
    this.root.addEventListener('pointermove', (event) => {
      if (!this.root.hasPointerCapture(event.pointerId)) return;
      const box = this.column.getBoundingClientRect();
      this.set((100 * (box.bottom - event.clientY)) / box.height);
    });
    this.root.addEventListener('keydown', (event) => {
      const steps: Record<string, number> = { ArrowUp: kStep, ArrowDown: -kStep, Home: -100, End: 100 };
      const step = steps[event.key];
      if (step === undefined) return;
      event.preventDefault();
      this.set(this.percent + step);
    });
  }

  private set(percent: number): void {
    this.percent = Math.min(kMost, Math.max(kLeast, Math.round(percent)));
    remember('strips', String(this.percent));
    this.apply();
  }

  private apply(): void {
    this.root.setAttribute('aria-valuenow', String(this.percent));
    this.column.style.setProperty('--strips', `${this.percent}%`);
  }
}
