// Keys that are held: one step when pressed, then, after a moment, a movement that gets faster.
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
