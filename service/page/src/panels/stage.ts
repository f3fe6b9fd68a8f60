// The stage: the 3-D view with its buttons, the badges over it, and a text of what it shows.
import { download, make, makeButton, recall, remember, setHidden, setText } from '../ui/dom';
import type { View } from '../view/view';
import type { Actions, PageState } from './state';
import { replayNote, tracking } from './words';

const kCameras = ['front', 'side', 'top', 'near'] as const;
const kWords = { front: 'Front', side: 'Side', top: 'Top', near: 'Near' };
const kDescribe_ms = 2000;

export class Stage {
  readonly root: HTMLElement;
  readonly host = make('div', { class: 'view-host', id: 'view' });
  private readonly replay = make('strong', { class: 'badge replay', 'data-testid': 'replay-badge' }, 'REPLAY');
  private readonly note = make('p', { class: 'replay-note', role: 'status', 'data-testid': 'replay-note' });
  private readonly hint = make('p', { class: 'hint', role: 'status', 'data-testid': 'hint' });
  private readonly text = make('p', { class: 'unseen', id: 'view-text', 'data-testid': 'view-text' });
  private readonly buttons = make('div', { class: 'cameras', role: 'group', 'aria-label': 'Camera' });
  private view: View | null = null;
  private full = false; // detail
  private described_ms = -Infinity;
  private readonly hints = new Hints();

  constructor(private readonly actions: Actions) {
    const badges = make('div', { class: 'view-badges' }, this.replay, this.note);
    this.replay.hidden = true;
    this.root = make('section', { class: 'stage', 'aria-label': '3-D view', 'aria-describedby': 'view-text' });
    this.root.append(this.host, badges, this.hint, this.buttons, this.text);
  }

  setView(view: View): void {
    this.view = view;
    const cameras = kCameras.map((name) => makeButton(kWords[name], () => view.setCamera(name)));
    const picture = makeButton('Picture', () => void this.savePicture(), { title: 'Save a picture of the view' });
    const detail = makeButton('Full detail', () => this.setDetail(view, detail, !this.full), {
      title: 'Draw all of the detail, also where that is slow',
    });
    this.setDetail(view, detail, recall('detail') === 'full');
    this.buttons.replaceChildren(...cameras, picture, detail);
  }

  update(state: PageState): void {
    setHidden(this.replay, !state.replay);
    setText(this.note, replayNote(state));
    const hint = this.hints.next(state, performance.now());
    setText(this.hint, hint);
    setHidden(this.hint, hint === '');
    const now_ms = performance.now();
    if (this.view === null || now_ms - this.described_ms < kDescribe_ms) return;
    this.described_ms = now_ms;
    setText(this.text, this.view.describe());
  }

  private setDetail(view: View, button: HTMLButtonElement, full: boolean): void {
    this.full = full;
    button.setAttribute('aria-pressed', String(full));
    remember('detail', full ? 'full' : 'auto');
    view.setDetail(full);
  }

  private async savePicture(): Promise<void> {
    try {
      const picture = await this.view?.snapshot();
      if (picture !== undefined) download(`omni-${stamp()}.png`, picture);
    } catch (error) {
      this.actions.notify('error', `No picture: ${error instanceof Error ? error.message : String(error)}`);
    }
  }
}

// "2026-11-27-125800": for names of files
export function stamp(): string {
  const now = new Date();
  const local = new Date(now.getTime() - now.getTimezoneOffset() * 60_000).toISOString();
  return local.slice(0, 19).replace('T', '-').replace(/:/g, '');
}

const kLimit_ms = 700; // so long it is said after it was so

// One hint on the picture of omni try: what to do next, until something was touched; then only that the base is at its
// limit, or the pen inside what makes no force yet, while it is so.
class Hints {
  private touched = false;
  private limit_ms = -Infinity;

  // "": none.
  next(state: PageState, now_ms: number): string {
    const { hello, live, scene, signals } = state;
    if (!hello.hand || state.replay || state.link.kind !== 'open' || live === null) return '';
    if (live.contacts.length > 0) {
      this.touched = true;
      if (signals.flag(live, 'saturated') === true) this.limit_ms = now_ms;
    }
    if (signals.flag(live, 'waits') === true) return 'The pen is inside: draw it out, then touch.';
    if (now_ms - this.limit_ms < kLimit_ms) return 'The base is at its limit: it cannot push harder here.';
    if (this.touched || scene?.state !== 'ready') return '';
    if (!live.aim.present) return 'Press on the picture to take the pen.';
    if (tracking(state).state !== 'tracked') return '';
    return live.vehicle !== null ? 'Drag the pen: it steers the car.' : 'Drag the pen straight down.';
  }
}
