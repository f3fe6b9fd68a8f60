// Notices: what just happened. Good news go by themselves; warnings and errors stay until the person has seen them.
import { make, makeButton } from '../ui/dom';

type Level = 'info' | 'warning' | 'error';

const kShown = 4; // at once; older ones go
const kInfo_ms = 8000;
const kWords: Record<Level, string> = { info: 'Note', warning: 'Warning', error: 'Error' };

export class Notices {
  readonly root = make('div', { class: 'notices', 'data-testid': 'notices' });
  // Screen readers watch these two; they must be there before the text is.
  private readonly polite = make('div', { class: 'notice-list', role: 'status' });
  private readonly urgent = make('div', { class: 'notice-list', role: 'alert' });

  constructor() {
    this.root.append(this.urgent, this.polite);
  }

  notify(level: Level, text: string): void {
    const list = level === 'error' ? this.urgent : this.polite;
    for (const old of [...list.children]) {
      if (old.querySelector('.notice-text')?.textContent === text) old.remove(); // again: once is enough
    }
    const notice = make('div', { class: `notice ${level}` });
    const close = makeButton('×', () => notice.remove(), { class: 'button quiet close', title: 'Close' });
    close.setAttribute('aria-label', `Close: ${text}`);
    const word = make('strong', { class: 'notice-level' }, `${kWords[level]}: `);
    notice.append(make('p', {}, word, make('span', { class: 'notice-text' }, text)), close);
    list.append(notice);
    while (list.childElementCount > kShown) list.firstElementChild?.remove();
    if (level === 'info') this.expire(notice);
  }

  // Not while the person reads it: neither under the pointer nor with the focus inside.
  private expire(notice: HTMLElement): void {
    setTimeout(() => {
      if (notice.matches(':hover, :focus-within')) this.expire(notice);
      else notice.remove();
    }, kInfo_ms);
  }
}
