// One hint on the picture of omni try: what to do next, until something was touched; then only that the base is at its
// limit, or the pen inside what makes no force yet, while it is so.
import type { PageState } from './state';
import { tracking } from './words';

const kLimit_ms = 700; // so long it is said after it was so

export class Hints {
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
