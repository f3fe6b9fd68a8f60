// What divides the page: frames of panels, and the edge between view and strips.
import { make, recall, remember } from './dom';

const kNarrow = '(max-width: 699px)';
const kRoomy = '(min-width: 1600px)';

export interface CardOptions {
  id: string; // also its data-testid: "card-now"
  title: string;
  important?: boolean; // open on a narrow screen, too
  open?: 'always' | 'roomy'; // on a wide one, or a very wide one only; default: always
}

// A panel's frame: a heading that opens and closes it. What the person chose is kept; without a choice, a narrow
// screen starts with the important ones only.
export class Card {
  readonly root: HTMLDetailsElement;
  readonly body: HTMLElement;
  private readonly note: HTMLElement;
  private readonly id: string;
  private static readonly ids = new Set<string>();

  constructor(options: CardOptions) {
    if (Card.ids.has(options.id)) throw new Error(`two cards are named ${options.id}`);
    Card.ids.add(options.id);
    this.id = options.id;
    this.note = make('span', { class: 'card-note' });
    this.body = make('div', { class: 'card-body' });
    const heading = make('h2', {}, options.title);
    this.root = make('details', { class: 'card', id: `card-${options.id}`, 'data-testid': `card-${options.id}` });
    this.root.append(make('summary', {}, heading, this.note), this.body);
    const chosen = recall(`card.${options.id}`);
    this.root.open = chosen === null ? opensAtFirst(options) : chosen === 'open';
    this.root.querySelector('summary')?.addEventListener('click', () => {
      remember(`card.${options.id}`, this.root.open ? 'closed' : 'open'); // it toggles after this
    });
  }

  get open(): boolean {
    return this.root.open && !this.root.hidden;
  }

  // Closed, unless the person has chosen otherwise.
  fold(): void {
    if (recall(`card.${this.id}`) === null) this.root.open = false;
  }

  // A few words beside the heading, seen while closed as well.
  setNote(text: string): void {
    if (this.note.textContent !== text) this.note.textContent = text;
  }
}

function opensAtFirst(options: CardOptions): boolean {
  if (matchMedia(kNarrow).matches) return options.important === true;
  return options.open !== 'roomy' || matchMedia(kRoomy).matches;
}

const kLeast = 15; // percent of the column's height that the strips take
const kMost = 80;
const kFirst = 36;
const kStep = 4;

// The edge between view and strips: dragged, or moved by the arrow keys.
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
