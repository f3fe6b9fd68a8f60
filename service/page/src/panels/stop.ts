// The emergency stop: always there, also on a page that may only watch. F9 does the same: a key that types nothing,
// scrolls nothing and is on every keyboard.
import { make, setAttribute, setText } from '../ui/dom';
import { isSimulated, statusOf } from './state';
import type { Actions, PageState } from './state';

export const kStopKey = 'F9';
const kAnswer_ms = 2000; // without one, the button can be pressed again
const kCalm_ms = 1500; // after the last press: a frightened person presses again, and must not release by that
const kReleaseElsewhere =
  'This page only watches. A page of omni monitor --control or of omni try can release the stop.';
const kNoService = 'omnid is not there, so nothing drives the coils. To be sure, unplug the base.';

export class StopButton {
  readonly root: HTMLElement;
  private readonly button: HTMLButtonElement;
  private readonly label = make('span', { class: 'stop-label' });
  private readonly hint = make('span', { class: 'stop-hint', id: 'stop-hint' });
  private stopped = false;
  private control = false;
  private service = true; // omnid is there, as far as is known
  private requested_ms = -Infinity; // when something was requested last
  private pressed_ms = -Infinity; // when the button was pressed last
  private requested: boolean | null = null; // for what

  constructor(private readonly actions: Actions) {
    this.button = make('button', { type: 'button', class: 'stop', 'aria-describedby': 'stop-hint' }, this.label);
    this.button.dataset['testid'] = 'stop';
    this.button.addEventListener('click', () => this.press());
    this.root = make('div', { class: 'stop-box' }, this.button, this.hint);
    addEventListener('keydown', (event) => {
      if (event.key !== kStopKey || event.repeat) return;
      event.preventDefault();
      this.pressed_ms = performance.now();
      if (!this.stopped) this.request(true); // the key never releases: that must be meant
    });
    this.show();
  }

  update(state: PageState): void {
    this.stopped = typeof statusOf(state)?.stopped === 'string';
    this.control = state.hello.control;
    this.service = state.status?.connected !== false;
    setAttribute(this.button, 'data-simulated', String(isSimulated(statusOf(state))));
    if (this.stopped === this.requested || performance.now() - this.requested_ms > kAnswer_ms) this.requested = null;
    this.show();
  }

  private press(): void {
    const calm = performance.now() - this.pressed_ms > kCalm_ms;
    this.pressed_ms = performance.now();
    if (!this.stopped) this.request(true);
    else if (!calm) return;
    else if (this.control) this.request(false);
    else this.actions.notify('warning', kReleaseElsewhere);
  }

  private request(on: boolean): void {
    if (this.actions.send({ type: 'stop', on })) {
      this.requested = on;
      this.requested_ms = performance.now();
      this.show();
      if (on && !this.service) this.actions.notify('warning', kNoService);
    } else if (on) {
      this.actions.notify('error', 'Not stopped: this page has no connection. Run omni device estop, or unplug the base.');
    } else {
      this.actions.notify('warning', 'Not released: this page has no connection.');
    }
  }

  private show(): void {
    setAttribute(this.button, 'data-stopped', String(this.stopped));
    if (this.requested !== null) {
      setText(this.label, this.requested ? 'Stopping …' : 'Releasing …');
    } else if (!this.stopped) {
      setText(this.label, 'EMERGENCY STOP');
    } else {
      setText(this.label, this.control ? 'Release the stop' : 'STOPPED');
    }
    if (!this.stopped) setText(this.hint, `key ${kStopKey}`);
    else setText(this.hint, this.control ? 'no force until released' : 'omni try or --control releases it');
  }
}
