// The 3-D view: base, pen, forces, scene. Draws only when something has changed, at most once per animation frame.
import { Vector2, Vector3 } from 'three';
import type { Hello, Live, SceneMessage, Shape, Surface, Vec3 } from '../types';
import { Caption } from './caption';
import { depthOf, dragged, planeFor, type Pointed } from './drag';
import { Drawing, repeatsHull } from './drawing';
import { Orbit, type CameraName } from './orbit';
import { kDark, kLight } from './palette';
import { kPenLength } from './pen';
import { describe, emptyPicture, PictureChanges, PictureReader } from './picture';
import { SceneParts, type Replayed } from './scene_parts';

const kReach = 26; // pixels around pen and ghost in which the pointer takes hold
const kTrailStep = 8; // of the samples of a Live message, one is a point of the trail
const kTurn = 0.0065; // rad per pixel
const kNoWebGl =
  'The 3-D view needs WebGL 2, which this browser does not offer here. ' +
  'Turn on hardware acceleration in its settings, or open this page in another browser. Everything else works.';

export class View {
  readonly canvas = document.createElement('canvas');
  private readonly orbitCamera = new Orbit();
  private readonly parts = new SceneParts((shape) => repeatsHull(shape, this.hello));
  private readonly caption = new Caption();
  private readonly drawing: Drawing | null;
  private changes = new PictureChanges();
  private readonly still = matchMedia('(prefers-reduced-motion: reduce)');
  private hello: Hello | null = null;
  private reader: PictureReader | null = null;
  private picture = emptyPicture();
  private now_s = 0; // of the newest Live
  private frame = 0; // requested; 0: none
  private requested_ms = 0; // when
  private drawn_ms = 0; // when
  private moving = false; // the frame before belongs to the same movement

  constructor(private readonly host: HTMLElement) {
    const style = this.canvas.style;
    style.display = 'block';
    style.position = 'absolute';
    style.inset = '0';
    style.width = '100%';
    style.height = '100%';
    style.outlineOffset = '-3px'; // the focus ring stays inside
    if (getComputedStyle(host).position === 'static') host.style.position = 'relative';
    host.append(this.canvas, this.caption.element);
    this.drawing = this.start();
    this.setTheme(matchMedia('(prefers-color-scheme: dark)').matches);
    new ResizeObserver(() => this.resize()).observe(host);
    this.watchPixelRatio();
  }

  setHello(hello: Hello): void {
    this.hello = hello;
    this.reader = new PictureReader(hello);
    this.picture = emptyPicture();
    this.changes = new PictureChanges();
    this.drawing?.trail.clear();
    this.drawing?.setBase(hello.base);
    if (this.drawing !== null) this.drawing.visitor = hello.hand;
    this.caption.setVisitor(hello.hand);
    this.drawing?.place(this.picture);
    this.parts.hideAgain();
    this.invalidate();
  }

  setScene(scene: SceneMessage): void {
    this.parts.setScene(scene);
    this.invalidate();
  }

  addShape(shape: Shape): void {
    if (!this.parts.add(shape)) return;
    this.frameScene();
    this.invalidate();
  }

  setSurface(surface: Surface): void {
    if (this.parts.setSurface(surface)) this.invalidate();
  }

  // Surfaces as a recording has them, while what is live goes on unseen; null: live again.
  setReplay(replayed: Replayed | null): void {
    if (this.parts.setReplay(replayed)) this.invalidate();
  }

  setLive(live: Live): void {
    if (this.reader === null) return;
    this.picture = this.reader.read(live, this.picture);
    this.now_s = live.t_s;
    const { valid, tracked, aim, tip } = this.picture;
    if (this.drawing !== null) {
      const { trail } = this.drawing;
      if (valid && tracked) this.reader.path(live, kTrailStep, (t, x, y, z) => trail.add(t, x, y, z));
      else if (!valid) trail.clear();
      const trailing = trail.update(this.now_s);
      if (!this.changes.differs(this.picture) && !trailing) return;
    }
    this.drawing?.place(this.picture);
    this.caption.show(this.drawing !== null && valid, aim.present);
    if (valid) this.orbitCamera.follow(tip);
    this.invalidate();
  }

  setTheme(dark: boolean): void {
    const palette = dark ? kDark : kLight;
    this.host.style.backgroundColor = `#${palette.skyBottom.getHexString()}`;
    this.host.style.color = `#${palette.text.getHexString()}`;
    this.caption.setPalette(palette);
    this.drawing?.setPalette(palette);
    this.invalidate();
  }

  setCamera(name: CameraName): void {
    const { valid, tip, aim } = this.picture;
    this.orbitCamera.preset(name, valid ? tip : aim.present ? aim.tip : null, this.still.matches);
    this.invalidate();
  }

  // Of the pen; null: it is not there.
  tip(): Vec3 | null {
    return this.picture.valid ? this.picture.tip : null;
  }

  describe(): string {
    return describe(this.picture, (object) => this.parts.name(object));
  }

  // How far a pen at `tip` goes with the pointer. `other`: in the other plane than usual (drag.ts).
  dragBy(fromX: number, fromY: number, toX: number, toY: number, tip: Vec3, other: boolean): Vec3 {
    const { camera } = this.orbitCamera;
    const perPixel = this.orbitCamera.metresPerPixel(this.canvas.clientHeight);
    const plane = planeFor(this.orbitCamera.forward(), other);
    return dragged(camera, this.pointed(fromX, fromY), this.pointed(toX, toY), tip, plane, perPixel);
  }

  // Away from the eye, out of the plane in which the pen is usually dragged; unit.
  depth(): Vec3 {
    const forward = this.orbitCamera.forward();
    return depthOf(forward, planeFor(forward, false));
  }

  cameraRight(): Vec3 {
    return this.orbitCamera.right();
  }

  cameraUp(): Vec3 {
    return this.orbitCamera.up();
  }

  // Whether a pointer there is on the pen or its ghost, or within `reach` pixels.
  isNearPen(clientX: number, clientY: number, reach = kReach): boolean {
    const { valid, tip, axis, aim } = this.picture;
    return (valid && this.isNear(clientX, clientY, tip, axis, reach)) ||
      (aim.present && this.isNear(clientX, clientY, aim.tip, aim.axis, reach));
  }

  // Turns the scene with the pointer; pixels.
  orbit(dx: number, dy: number): void {
    this.orbitCamera.turn(-kTurn * dx, kTurn * dy);
    this.invalidate();
  }

  // More than 1: closer.
  zoom(factor: number): void {
    this.orbitCamera.zoom(factor);
    if (this.still.matches) this.orbitCamera.jump();
    this.invalidate();
  }

  // Shifts what is seen with the pointer; pixels.
  pan(dx: number, dy: number): void {
    const scale = this.orbitCamera.metresPerPixel(this.canvas.clientHeight);
    this.orbitCamera.pan(scale * dx, -scale * dy);
    this.invalidate();
  }

  // A close-up does not follow the pen while the hand drags it: the pointer would lose it.
  holdCamera(on: boolean): void {
    this.orbitCamera.hold(on);
    if (!on && this.picture.valid && this.orbitCamera.follow(this.picture.tip)) this.invalidate();
  }

  // Height of the scene's highest point over x, y; null if there is nothing.
  heightAt(x: number, y: number): number | null {
    return this.parts.heightAt(x, y);
  }

  // All of the detail, however slow that is; false: as much as the machine can draw.
  setDetail(full: boolean): void {
    this.drawing?.stage.setDetail(full);
    this.invalidate();
  }

  // A PNG of what is seen now.
  snapshot(): Promise<Blob> {
    this.drawing?.draw(this.orbitCamera.camera); // in this task: the canvas keeps its picture only that long
    return new Promise((resolve, reject) => {
      this.canvas.toBlob((blob) => (blob ? resolve(blob) : reject(new Error('no picture: the view is not drawn'))));
    });
  }

  private start(): Drawing | null {
    try {
      const drawing = new Drawing(this.canvas, this.parts);
      this.canvas.addEventListener('webglcontextrestored', () => {
        drawing.stage.restore();
        this.invalidate();
      });
      return drawing;
    } catch {
      const text = document.createElement('p');
      text.textContent = kNoWebGl;
      text.style.position = 'relative';
      text.style.margin = '0';
      text.style.padding = '1.5em';
      text.style.maxWidth = '36em';
      text.style.pointerEvents = 'none'; // the keys of the hand work on the empty canvas as well
      this.host.append(text);
      return null;
    }
  }

  // For a visitor; who watches a base sees all of it.
  private frameScene(): void {
    if (this.hello?.hand !== true) return;
    const box = this.parts.bounds();
    const [centre, size] = [box.getCenter(new Vector3()), box.getSize(new Vector3())];
    this.orbitCamera.setSubject(box.isEmpty() ? null : { centre: centre.toArray(), width: Math.max(size.x, size.y) });
  }

  private invalidate(): void {
    if (this.drawing === null) {
      this.orbitCamera.jump();
      return;
    }
    if (this.frame !== 0) return;
    this.requested_ms = performance.now();
    this.frame = requestAnimationFrame((time) => this.draw(time));
  }

  private draw(time_ms: number): void {
    this.frame = 0;
    const step = time_ms - this.drawn_ms;
    this.drawn_ms = time_ms;
    const settling = this.orbitCamera.update(this.moving ? Math.min(step, 100) / 1000 : 1 / 60);
    this.moving = settling;
    this.drawing?.stage.pace(performance.now() - this.requested_ms);
    this.drawing?.draw(this.orbitCamera.camera);
    if (settling) this.invalidate();
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.host;
    if (width === 0 || height === 0) return;
    this.orbitCamera.resize(width, height);
    this.caption.setWidth(width);
    this.drawing?.stage.resize(width, height);
    this.drawing?.draw(this.orbitCamera.camera); // at once: a resized canvas is empty
  }

  // Zoom of the browser, another screen.
  private watchPixelRatio(): void {
    const query = matchMedia(`(resolution: ${window.devicePixelRatio}dppx)`);
    query.addEventListener('change', () => {
      this.resize();
      this.watchPixelRatio();
    }, { once: true });
  }

  private pointed(clientX: number, clientY: number): Pointed {
    const box = this.canvas.getBoundingClientRect();
    const x = (clientX - box.left) / (box.width || 1);
    const y = (clientY - box.top) / (box.height || 1);
    return { screen: new Vector2(2 * x - 1, 1 - 2 * y), pixels: new Vector2(clientX, -clientY) };
  }

  private isNear(clientX: number, clientY: number, tip: Vec3, axis: Vec3, reach: number): boolean {
    const box = this.canvas.getBoundingClientRect();
    const project = (along: number) => {
      const p = new Vector3(...tip).addScaledVector(new Vector3(...axis), -along).project(this.orbitCamera.camera);
      return new Vector2(box.left + (0.5 + 0.5 * p.x) * box.width, box.top + (0.5 - 0.5 * p.y) * box.height);
    };
    const [a, b, p] = [project(0), project(kPenLength), new Vector2(clientX, clientY)];
    const along = b.clone().sub(a);
    const share = p.clone().sub(a).dot(along) / (along.lengthSq() || 1);
    return p.distanceTo(a.addScaledVector(along, Math.min(1, Math.max(0, share)))) <= reach;
  }
}
