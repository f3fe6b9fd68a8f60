// What the person must read: notices, and the banner while something is wrong.
import { make, makeButton, setHidden, setText } from '../ui/dom';
import { connectionOf } from './header';
import type { PageState } from './state';

type Level = 'info' | 'warning' | 'error';

const kShown = 4; // at once; older ones go
const kInfo_ms = 8000;
const kWords: Record<Level, string> = { info: 'Note', warning: 'Warning', error: 'Error' };

// What just happened. Good news go by themselves; warnings and errors stay until the person has seen them.
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

// A line across the page while something is wrong with the connection or with the page itself: what, and what to do.
export class Banner {
  readonly root: HTMLElement;
  private readonly text = make('p', { class: 'banner-text', 'data-testid': 'banner' });
  private readonly reload = makeButton('Reload the page', () => location.reload(), { class: 'button primary' });
  private changed = ''; // why the page must be loaded again, whatever the connection is like

  constructor() {
    this.root = make('div', { class: 'banner', role: 'status' }, this.text, this.reload);
    this.root.hidden = true;
  }

  // The service is another one than this page was made for.
  mustReload(why: string): void {
    this.changed = why;
  }

  update(state: PageState): void {
    const connection = connectionOf(state);
    // The seconds since the loss are in the header: what is read out must not change all the time.
    const old = state.live === null ? '' : ' What is shown is old.';
    const lost = state.link.kind === 'lost' ? `No connection to omni: trying again.${old}` : '';
    const about = this.changed || [lost, connection.more].filter((text) => text !== '').join(' ');
    setHidden(this.reload, this.changed === '' && state.link.kind !== 'old');
    setText(this.text, about);
    setHidden(this.root, about === '');
  }
}
