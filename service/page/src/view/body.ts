// An object of the scene that changes: where it is, and its surface in place of its parts. Live, or as a recording has
// it; what is live then goes on unseen, on a mesh of its own.
import { Group, type Mesh, type MeshStandardMaterial } from 'three';
import type { Quat, Shape, Surface, Vec3 } from '../types';
import { SurfaceMesh } from './surface_mesh';

interface Pose {
  rotation: Quat;
  translation: Vec3;
}

export type Parts = [shapes: Shape[], materials: MeshStandardMaterial[]];

const kAsLoaded: Pose = { rotation: [1, 0, 0, 0], translation: [0, 0, 0] };

export class Body {
  readonly group = new Group();
  private pose: Pose = kAsLoaded; // that is live
  private live: SurfaceMesh | null = null; // null: nothing has changed
  private replays = false;
  private then: Surface | null = null; // that is replayed; null: as loaded
  private replayed: SurfaceMesh | null = null;

  constructor(private readonly plain: MeshStandardMaterial) {}

  // What is drawn instead of the parts; null: they are.
  get mesh(): Mesh | null {
    const mesh = this.drawn?.mesh;
    return mesh?.visible === true ? mesh : null;
  }

  // A message.
  set(surface: Surface, parts: () => Parts): void {
    this.pose = surface;
    if (surface.positions !== null) {
      this.live ??= new SurfaceMesh(...parts(), this.plain);
      this.live.set(surface.positions, surface.triangles);
    }
    this.place();
  }

  // As it was at a time; null: as loaded. False: that is drawn already.
  replay(surface: Surface | null, parts: () => Parts): boolean {
    if (this.replays && surface === this.then) return false;
    if (surface !== null && surface.positions !== null) {
      // Without this, an unchanged mesh would be wired again for every state.
      const rewired = surface.triangles !== this.then?.triangles || this.replayed === null;
      this.replayed ??= new SurfaceMesh(...parts(), this.plain);
      this.replayed.set(surface.positions, rewired ? surface.triangles : null);
    }
    this.replays = true;
    this.then = surface;
    this.place();
    return true;
  }

  // Live again.
  endReplay(): void {
    this.replays = false;
    this.then = null;
    this.replayed?.mesh.removeFromParent();
    this.replayed?.dispose();
    this.replayed = null;
    this.place();
  }

  setParts(parts: Parts): void {
    this.live?.setParts(...parts);
    this.replayed?.setParts(...parts);
  }

  // Before drawing.
  update(): void {
    this.drawn?.update();
  }

  dispose(): void {
    this.live?.dispose();
    this.replayed?.dispose();
  }

  private get drawn(): SurfaceMesh | null {
    if (!this.replays) return this.live;
    return this.then !== null && this.then.positions !== null ? this.replayed : null;
  }

  private place(): void {
    const { rotation, translation } = this.replays ? (this.then ?? kAsLoaded) : this.pose;
    const [w, x, y, z] = rotation;
    this.group.quaternion.set(x, y, z, w).normalize();
    this.group.position.set(...translation);
    const { drawn } = this;
    for (const surface of [this.live, this.replayed]) if (surface !== drawn) surface?.mesh.removeFromParent();
    if (drawn !== null && drawn.mesh.parent !== this.group) this.group.add(drawn.mesh);
  }
}
