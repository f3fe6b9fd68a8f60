// The hand of `omni try`: mouse, fingers and keys say where the hand wants the pen. The pen follows by a spring in the
// simulator; nothing here sets its pose. Without the hand (omni monitor, a replay) the same moves turn the view.
import type { Live, Request, Vec3 } from '../types';
import type { View } from '../view/view';
import { add, clamp, clampTip, horizontal, rotate, same, unit, type Place } from './aim';
import { Gestures } from './gestures';
import { HeldKeys, kHelp, kLabelHand, kLabelView, motionOf, type Motion } from './keys';

const kStartHeight = 0.07; // m over the core's centre, where there is no scene
const kStartGap = 0.0025; // m over the scene: a small drag touches it
const kStartHighest = 0.2;
const kIdle_ms = 500; // after its last word the hand keeps its own aim for so long: the answer is on its way
const kTouchReach = 40; // pixels
const kPush = 4e-5; // m per pixel of the wheel
const kTiltDrag = 0.006; // rad per pixel
const kTurnKey = 24; // pixels of a drag that a key turns the view by
const kZoomKey = 1.15;

const kStep = { move: 1e-3, tilt: (2 * Math.PI) / 180 }; // a key, pressed once
const kSpeed = { slow: 0.015, fast: 0.09, tilt: (40 * Math.PI) / 180 }; // a key, held; m/s and rad/s
const kFine = 0.2; // with Shift

const kArrows: Partial<Record<string, [number, number]>> = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, -1],
  ArrowDown: [0, 1],
};

export class Hand {
  private enabled = false;
  private aim: Place | null = null; // null: the pen is not there
  private wanted: Place | null = null; // while dragged: beyond the limits too, so that the pointer finds back
  private open = false; // let go of the pen; what holds it draws it to where it rests
  private sent: Place | null = null;
  private spoke_ms = -Infinity; // when something was sent
  private frame = 0;
  private framed_ms = 0;
  private fine = false;
  private readonly keys = new HeldKeys();
  private readonly gestures: Gestures;

  constructor(
    private readonly view: View,
    private readonly send: (request: Request) => void,
    private readonly announce: (text: string) => void,
  ) {
    const { canvas } = view;
    canvas.tabIndex = 0;
    canvas.setAttribute('role', 'application');
    canvas.addEventListener('keydown', (event) => this.keyDown(event));
    canvas.addEventListener('keyup', (event) => this.keyUp(event));
    canvas.addEventListener('blur', () => this.keys.clear());
    window.addEventListener('blur', () => this.keys.clear());
    this.gestures = new Gestures(canvas, {
      take: (x, y, touch) => this.take(x, y, touch),
      drag: (fromX, fromY, toX, toY, other) => this.drag(fromX, fromY, toX, toY, other),
      push: (pixels) => this.move(add([0, 0, 0], view.depth(), kPush * pixels)),
      tilt: (dx, dy) => this.tiltBy(dx, dy),
      drop: () => this.drop(),
      orbit: (dx, dy) => view.orbit(dx, dy),
      pan: (dx, dy) => view.pan(dx, dy),
      zoom: (factor) => view.zoom(factor),
      isNearPen: (x, y, touch) => this.isNearPen(x, y, touch),
      takesWheel: () => this.enabled || document.activeElement === canvas,
    });
    this.setEnabled(false);
  }

  setEnabled(on: boolean): void {
    if (!on) {
      this.gestures.cancel();
      this.keys.clear();
      this.aim = this.wanted = this.sent = null;
    }
    this.enabled = on;
    this.view.canvas.setAttribute('aria-label', on ? kLabelHand : kLabelView);
    this.view.canvas.style.touchAction = on ? 'none' : 'pan-y'; // a page with a view only scrolls under the finger
  }

  // `held`: by clay, which lets go of a pen that is neither pressed nor pulled.
  setLive(live: Live, held: boolean): void {
    if (!held) this.open = false;
    const tip = this.view.tip();
    if (this.open && this.aim !== null && tip !== null) return this.set({ tip, axis: this.aim.axis });
    const busy = this.wanted !== null || this.keys.any || this.frame !== 0 || performance.now() - this.spoke_ms < kIdle_ms;
    if (!this.enabled || busy) return;
    this.aim = live.aim.present ? { tip: live.aim.tip, axis: live.aim.axis } : null;
    this.sent = this.aim;
  }

  // The server has taken the pen away: another scene comes.
  taken(): void {
    this.gestures.cancel();
    this.keys.clear();
    this.aim = this.wanted = this.sent = null;
  }

  lift(): void {
    if (!this.enabled) return;
    this.taken();
    this.spoke_ms = performance.now();
    this.send({ type: 'lift' });
    this.announce('The pen is taken away.');
  }

  help(): { keys: string; does: string }[] {
    return [...kHelp];
  }

  // ---- pointer

  private isNearPen(x: number, y: number, touch: boolean): boolean {
    return this.enabled && this.aim !== null && this.view.isNearPen(x, y, touch ? kTouchReach : undefined);
  }

  private take(x: number, y: number, touch: boolean): boolean {
    if (!this.enabled) return false;
    if (this.aim !== null && !this.isNearPen(x, y, touch)) return false;
    if (this.aim === null) this.start();
    this.wanted = this.aim;
    this.open = false;
    this.view.holdCamera(true);
    return true;
  }

  private drop(): void {
    this.wanted = null;
    this.open = true;
    this.view.holdCamera(false);
  }

  private drag(fromX: number, fromY: number, toX: number, toY: number, other: boolean): void {
    const at = (this.wanted ?? this.aim)?.tip;
    if (at !== undefined) this.move(this.view.dragBy(fromX, fromY, toX, toY, at, other));
  }

  private tiltBy(dx: number, dy: number): void {
    const at = this.wanted ?? this.aim;
    if (at === null) return;
    // The pen's upper end, -axis, goes with the pointer.
    const side = add(add([0, 0, 0], this.view.cameraRight(), -kTiltDrag * dx), this.view.cameraUp(), kTiltDrag * dy);
    this.set({ tip: at.tip, axis: unit(add(at.axis, side), at.axis) });
  }

  // ---- keys

  private keyDown(event: KeyboardEvent): void {
    this.fine = event.shiftKey;
    if (event.altKey || event.metaKey) return;
    const arrow = kArrows[event.key];
    if (arrow !== undefined && (event.ctrlKey || !this.enabled)) {
      this.view.orbit(-kTurnKey * arrow[0], -kTurnKey * arrow[1]);
    } else if (event.ctrlKey) {
      return;
    } else if (event.key === '+' || event.key === '=' || event.key === '-') {
      this.view.zoom(event.key === '-' ? 1 / kZoomKey : kZoomKey);
    } else if (event.key === 'Enter') {
      this.announce(this.view.describe());
    } else if (!this.enabled || !this.penKey(event.key)) {
      return;
    }
    event.preventDefault();
  }

  // False: no key of the pen.
  private penKey(key: string): boolean {
    const motion = motionOf(key);
    this.open = false;
    if (motion !== null) {
      if (this.aim === null) {
        this.start();
      } else if (this.keys.press(motion)) {
        this.go(motion, kStep.move, kStep.tilt);
        this.schedule();
      }
    } else if (key === 'Home') {
      this.start();
    } else if (key === 'Delete' || key === 'Backspace') {
      this.lift();
    } else {
      return false;
    }
    return true;
  }

  private keyUp(event: KeyboardEvent): void {
    this.fine = event.shiftKey;
    const motion = motionOf(event.key);
    if (motion !== null) this.keys.release(motion);
  }

  // By so much, in m or in rad.
  private go(motion: Motion, metres: number, radians: number): void {
    if (this.aim === null) return;
    const scale = this.fine ? kFine : 1;
    const { right, away } = horizontal(this.view.cameraRight());
    const step = scale * metres;
    const lean = (to: Vec3, sign: number) => {
      const about: Vec3 = [-to[1], to[0], 0]; // z x to: turns what points up towards `to`
      this.set({ tip: this.aim!.tip, axis: rotate(this.aim!.axis, about, sign * scale * radians) });
    };
    switch (motion) {
      case 'left': return this.move(add([0, 0, 0], right, -step));
      case 'right': return this.move(add([0, 0, 0], right, step));
      case 'away': return this.move(add([0, 0, 0], away, step));
      case 'towards': return this.move(add([0, 0, 0], away, -step));
      case 'up': return this.move([0, 0, step]);
      case 'down': return this.move([0, 0, -step]);
      case 'leanAway': return lean(away, 1);
      case 'leanTowards': return lean(away, -1);
      case 'leanLeft': return lean(right, -1);
      case 'leanRight': return lean(right, 1);
    }
  }

  // ---- the aim

  // Over the middle of the scene, tip down.
  private start(): void {
    const top = this.view.heightAt(0, 0);
    const height = Math.min(kStartHighest, top === null ? kStartHeight : top + kStartGap);
    const came = this.aim === null;
    this.set({ tip: [0, 0, height], axis: [0, 0, -1] });
    this.announce(came ? 'The pen is there, above the scene.' : 'The pen is back at the start.');
  }

  private move(by: Vec3): void {
    const at = this.wanted ?? this.aim;
    if (at !== null) this.set({ tip: add(at.tip, by), axis: at.axis });
  }

  private set(to: Place): void {
    if (!this.enabled || ![...to.tip, ...to.axis].every(Number.isFinite)) return;
    this.aim = clamp(to);
    if (this.wanted !== null) this.wanted = { tip: within(to.tip), axis: this.aim.axis };
    this.schedule();
  }

  private schedule(): void {
    if (this.frame !== 0) return;
    this.framed_ms = performance.now();
    this.frame = requestAnimationFrame(() => this.step());
  }

  // Once per frame: what the held keys do, and the aim, if it is another one.
  private step(): void {
    this.frame = 0;
    const now = performance.now();
    const seconds = Math.min(0.1, (now - this.framed_ms) / 1000);
    this.keys.step(seconds, (motion, held, share) => {
      const speed = kSpeed.slow + share * (kSpeed.fast - kSpeed.slow);
      this.go(motion, held * speed, held * kSpeed.tilt);
    });
    if (this.aim !== null && !same(this.aim, this.sent)) {
      this.sent = this.aim;
      this.spoke_ms = now;
      this.send({ type: 'aim', tip: this.aim.tip, axis: this.aim.axis });
    }
    if (this.keys.any) this.schedule();
  }
}

// A pointer that runs far out of reach must not have to come all the way back.
function within(tip: Vec3): Vec3 {
  const nearest = clampTip(tip);
  const out = add(tip, nearest, -1);
  const far = Math.hypot(...out);
  return far > 0.1 ? add(nearest, out, 0.1 / far) : tip;
}
