// A line across the page while something is wrong with the connection or with the page itself: what, and what to do.
import { make, makeButton, setHidden, setText } from '../ui/dom';
import { connectionOf } from './header';
import type { PageState } from './state';

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
