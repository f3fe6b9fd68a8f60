// A panel's frame: a heading that opens and closes it. What the person chose is kept; without a choice, a narrow
// screen starts with the important ones only.
import { make } from './dom';
import { recall, remember } from './memory';

const kNarrow = '(max-width: 699px)';
const kRoomy = '(min-width: 1600px)';

export interface CardOptions {
  id: string; // also its data-testid: "card-now"
  title: string;
  important?: boolean; // open on a narrow screen, too
  open?: 'always' | 'roomy'; // on a wide one, or a very wide one only; default: always
}

export class Card {
  readonly root: HTMLDetailsElement;
  readonly body: HTMLElement;
  private readonly note: HTMLElement;
  private readonly id: string;

  constructor(options: CardOptions) {
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
