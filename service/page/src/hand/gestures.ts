// Mouse, trackpad, stylus and fingers on the canvas -> what they mean: on the pen they move it, beside it the view.
export interface Gestured {
  take(clientX: number, clientY: number, touch: boolean): boolean; // pressed: is it the pen?
  // The pen: up, down and sideways; `other` (Shift): level, away and sideways.
  drag(fromX: number, fromY: number, toX: number, toY: number, other: boolean): void;
  push(pixels: number): void; // the pen away from the viewer; < 0: towards
  tilt(dx: number, dy: number): void; // the pen's upper end
  drop(): void; // let go
  orbit(dx: number, dy: number): void;
  pan(dx: number, dy: number): void;
  zoom(factor: number): void;
  isNearPen(clientX: number, clientY: number, touch: boolean): boolean;
  takesWheel(): boolean; // else the page scrolls
}

type Mode = 'none' | 'waiting' | 'pen' | 'tilt' | 'orbit' | 'pan' | 'two-on-pen' | 'two-on-view';

interface Pointer {
  x: number;
  y: number;
}

const kTouchWait_ms = 130; // a finger waits so long for a second one ...
const kTouchSlack = 7; // ... or until it has moved so many pixels
const kWheelPause_ms = 350; // between events of one turn of the wheel
const kWheelLine = 20; // pixels
const kWheelPage = 400;
const kZoom = 0.0015; // per pixel of the wheel
const kPinchZoom = 0.01; // per pixel of a trackpad's pinch

export class Gestures {
  private mode: Mode = 'none';
  private readonly pointers = new Map<number, Pointer>();
  private timer = 0; // of a waiting finger
  private wheelAt_ms = -Infinity;
  private wheelOnPen = false;

  constructor(private readonly canvas: HTMLCanvasElement, private readonly on: Gestured) {
    canvas.addEventListener('pointerdown', (event) => this.down(event));
    canvas.addEventListener('pointermove', (event) => this.move(event));
    for (const end of ['pointerup', 'pointercancel', 'lostpointercapture'] as const) {
      canvas.addEventListener(end, (event) => this.up(event));
    }
    canvas.addEventListener('wheel', (event) => this.wheel(event), { passive: false });
    canvas.addEventListener('contextmenu', (event) => event.preventDefault());
    window.addEventListener('blur', () => this.cancel());
  }

  // Everything is let go; the fingers that are still there mean nothing any more.
  cancel(): void {
    for (const id of this.pointers.keys()) if (this.canvas.hasPointerCapture(id)) this.canvas.releasePointerCapture(id);
    this.pointers.clear();
    this.enter('none');
  }

  private down(event: PointerEvent): void {
    this.canvas.focus({ preventScroll: true });
    const touch = event.pointerType === 'touch';
    if (this.pointers.size > 0 && !touch) return; // another button of the same mouse
    this.pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    this.canvas.setPointerCapture(event.pointerId);
    if (this.pointers.size === 1) this.enter(touch ? 'waiting' : this.modeOfMouse(event));
    else if (this.pointers.size === 2) this.enter(this.mode === 'pen' ? 'two-on-pen' : 'two-on-view');
    else this.enter('none');
    if (event.button === 1) event.preventDefault(); // no scrolling by the middle button
    if (this.mode === 'waiting') this.timer = window.setTimeout(() => this.decide(), kTouchWait_ms);
  }

  private modeOfMouse(event: PointerEvent): Mode {
    if (event.button === 1 || (event.button === 2 && event.shiftKey)) return 'pan';
    if (event.button !== 0) return 'orbit';
    if (!this.on.take(event.clientX, event.clientY, false)) return 'orbit';
    return event.ctrlKey || event.metaKey || event.altKey ? 'tilt' : 'pen';
  }

  // A single finger that stays alone: on the pen or beside it.
  private decide(): void {
    const [finger] = this.pointers.values();
    if (this.mode !== 'waiting' || finger === undefined) return;
    this.enter(this.on.take(finger.x, finger.y, true) ? 'pen' : 'orbit');
  }

  private enter(mode: Mode): void {
    window.clearTimeout(this.timer);
    const holds = (m: Mode) => m === 'pen' || m === 'tilt' || m === 'two-on-pen';
    const dropped = holds(this.mode) && !holds(mode);
    this.mode = mode;
    if (dropped) this.on.drop();
    this.canvas.style.cursor = holds(mode) ? 'grabbing' : mode === 'orbit' || mode === 'pan' ? 'move' : '';
  }

  private move(event: PointerEvent): void {
    const pointer = this.pointers.get(event.pointerId);
    if (pointer === undefined) {
      if (event.pointerType === 'touch') return;
      this.canvas.style.cursor = this.on.isNearPen(event.clientX, event.clientY, false) ? 'grab' : '';
      return;
    }
    const [x, y] = [event.clientX, event.clientY];
    const [dx, dy] = [x - pointer.x, y - pointer.y];
    if (this.mode === 'waiting') {
      if (Math.hypot(dx, dy) < kTouchSlack) return;
      this.decide();
    }
    if (this.pointers.size === 2) {
      this.pair(pointer, x, y);
    } else {
      const from = { ...pointer };
      [pointer.x, pointer.y] = [x, y];
      if (this.mode === 'pen') this.on.drag(from.x, from.y, x, y, event.shiftKey);
      else if (this.mode === 'tilt') this.on.tilt(dx, dy);
      else if (this.mode === 'orbit') this.on.orbit(dx, dy);
      else if (this.mode === 'pan') this.on.pan(dx, dy);
    }
  }

  // Two fingers: what their distance and their middle do.
  private pair(moved: Pointer, x: number, y: number): void {
    const other = [...this.pointers.values()].find((pointer) => pointer !== moved);
    if (other === undefined) return;
    const before = Math.hypot(moved.x - other.x, moved.y - other.y);
    const after = Math.hypot(x - other.x, y - other.y);
    const [dx, dy] = [(x - moved.x) / 2, (y - moved.y) / 2];
    [moved.x, moved.y] = [x, y];
    if (this.mode === 'two-on-pen') {
      this.on.push(before - after);
    } else if (this.mode === 'two-on-view') {
      this.on.orbit(dx, dy);
      if (before > 10 && after > 10) this.on.zoom(after / before);
    }
  }

  private up(event: PointerEvent): void {
    if (!this.pointers.has(event.pointerId)) return;
    if (this.mode === 'waiting' && event.type === 'pointerup') this.decide(); // a tap
    this.pointers.delete(event.pointerId);
    this.enter('none'); // a finger that is left does not go on: it would jump
    if (event.pointerType !== 'touch') this.move(event); // the cursor
  }

  private wheel(event: WheelEvent): void {
    const control = event.ctrlKey || event.metaKey; // also a trackpad's pinch
    if (!control && !this.on.takesWheel()) return;
    event.preventDefault();
    const unit = [1, kWheelLine, kWheelPage][event.deltaMode] ?? 1;
    const pixels = unit * (event.deltaY || event.deltaX); // with Shift some browsers turn it aside
    if (control) {
      const pinch = event.deltaMode === 0 && Math.abs(pixels) < 50; // a wheel makes larger steps
      this.on.zoom(Math.exp(-pixels * (pinch ? kPinchZoom : kZoom)));
      return;
    }
    // One turn of the wheel stays with what it began on, though the pen moves away under it.
    if (event.timeStamp - this.wheelAt_ms > kWheelPause_ms) {
      this.wheelOnPen = this.mode === 'pen' || this.on.isNearPen(event.clientX, event.clientY, false);
    }
    this.wheelAt_ms = event.timeStamp;
    if (this.wheelOnPen || this.mode === 'pen') this.on.push(-pixels * (event.shiftKey ? 0.2 : 1));
    else this.on.zoom(Math.exp(-pixels * kZoom));
  }
}
