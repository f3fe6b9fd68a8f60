// Keys that are held: one step when pressed, then, after a moment, a movement that gets faster. And the help on keys.
const kWait_s = 0.25;
const kFaster_s = 1.3; // until the full speed

export type Motion = 'left' | 'right' | 'away' | 'towards' | 'up' | 'down' | 'leanAway' | 'leanTowards' | 'leanLeft' |
  'leanRight';

const kMotions: Record<string, Motion> = {
  arrowleft: 'left',
  arrowright: 'right',
  arrowup: 'away',
  arrowdown: 'towards',
  pageup: 'up',
  pagedown: 'down',
  r: 'up',
  f: 'down',
  w: 'leanAway',
  s: 'leanTowards',
  a: 'leanLeft',
  d: 'leanRight',
};

export function motionOf(key: string): Motion | null {
  return kMotions[key.toLowerCase()] ?? null;
}

export class HeldKeys {
  private readonly held = new Map<Motion, number>(); // seconds

  get any(): boolean {
    return this.held.size > 0;
  }

  // True if it is pressed now (not repeated by the keyboard): that is one step.
  press(motion: Motion): boolean {
    if (this.held.has(motion)) return false;
    this.held.set(motion, 0);
    return true;
  }

  release(motion: Motion): void {
    this.held.delete(motion);
  }

  clear(): void {
    this.held.clear();
  }

  // `move` gets for each held key the seconds to move for, and a share of the full speed (0 ... 1).
  step(seconds: number, move: (motion: Motion, seconds: number, speed: number) => void): void {
    for (const [motion, before] of this.held) {
      const now = before + seconds;
      this.held.set(motion, now);
      const moving = Math.min(seconds, now - kWait_s);
      if (moving > 0) move(motion, moving, Math.min(1, (now - kWait_s) / kFaster_s));
    }
  }
}

// What the hand and the view take, for the help panel and for screen readers.
export const kLabelHand =
  'The pen over the base. Arrow keys move it left, right, away and towards you; Page Up and Page Down move it up and ' +
  'down; Shift makes small steps; W, A, S, D tilt it; Home puts it back to the start; Delete takes it away; Enter ' +
  'reports where it is and what it touches.';
export const kLabelView =
  'The pen over the base. Arrow keys turn the view; plus and minus zoom; Enter reports where the pen is and what it ' +
  'touches.';

export const kHelp: readonly { keys: string; does: string }[] = [
  { keys: 'Click, if there is no pen', does: 'put the pen above the scene' },
  { keys: 'Drag the pen', does: 'move it up, down and sideways; it follows like on a spring' },
  { keys: 'Shift + drag the pen, or scroll on it', does: 'move it away from you and towards you' },
  { keys: 'Ctrl + drag the pen', does: 'tilt it' },
  { keys: 'Touch: a second finger while you hold the pen', does: 'apart: towards you; together: away from you' },
  { keys: '← → ↑ ↓', does: 'move the pen left, right, away from you, towards you' },
  { keys: 'Page Up, Page Down or R, F', does: 'move it up, down' },
  { keys: 'W, S, A, D', does: 'tilt it away from you, towards you, left, right' },
  { keys: 'Shift + these keys', does: 'small steps: 0.2 mm instead of 1 mm' },
  { keys: 'Home', does: 'back to the start' },
  { keys: 'Delete or Backspace', does: 'take the pen away' },
  { keys: 'Drag beside the pen, or right drag', does: 'turn the view' },
  { keys: 'Scroll beside the pen or Ctrl + scroll', does: 'zoom' },
  { keys: 'Touch: two fingers', does: 'turn the view and zoom' },
  { keys: 'Middle drag or Shift + right drag', does: 'shift the view' },
  { keys: 'Ctrl + ← → ↑ ↓', does: 'turn the view (without the hand: also without Ctrl)' },
  { keys: '+ −', does: 'zoom' },
  { keys: 'Enter', does: 'say where the pen is, what it touches and how hard' },
];
