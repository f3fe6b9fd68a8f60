// The past of one object that changes: its pose, vertices and triangles, each as a track of its own, since most
// messages bring only some of them.
import { fit } from '../decode';
import type { Surface } from '../types';
import { Track } from './track';

const kStep_s = 0.1; // between two states that are kept
const kSame_m = 5e-6; // vertices that move less stay where they were: nobody sees that
const kPoseWords = 8; // rotation w x y z, translation, largest displacement
const kObjectBytes = 2048; // what it takes besides its tracks, generously

// What came since the last state that was kept.
interface News {
  pose: Uint32Array;
  positions: Uint32Array | null; // null: as before; the same below
  triangles: Uint32Array | null;
}

type PoseNumbers = [number, number, number, number, number, number, number, number];

interface Shown {
  pose: Uint32Array;
  positions: Uint32Array | null;
  triangles: Uint32Array | null;
  surface: Surface;
}

export class SurfaceTracks {
  readonly pose = new Track(0);
  readonly positions = new Track(kSame_m);
  readonly triangles = new Track(0);
  private news: News | null = null;
  private due_s = -Infinity; // when the next state is kept
  private shown: Shown | null = null; // what at() gave

  constructor(
    private readonly scene: number,
    private readonly object: number,
  ) {}

  get all(): readonly Track[] {
    return [this.pose, this.positions, this.triangles];
  }
  get bytes(): number {
    const { news } = this;
    const waiting = (news?.positions?.buffer.byteLength ?? 0) + (news?.triangles?.buffer.byteLength ?? 0);
    return kObjectBytes + waiting + this.all.reduce((sum, track) => sum + track.bytes, 0);
  }
  // Of its state after a message.
  stateBytes(surface: Surface | null = null): number {
    const positions = surface?.positions ?? this.newestPositions;
    const triangles = surface?.triangles ?? this.newestTriangles;
    return 4 * kPoseWords + (positions?.byteLength ?? 0) + (triangles?.byteLength ?? 0);
  }

  // A message, which must not be changed afterwards. What the view does not draw is not taken either.
  take(surface: Surface): void {
    const { rotation, translation, largest_displacement_m } = surface;
    const pose = new Uint32Array(Float32Array.of(...rotation, ...translation, largest_displacement_m).buffer);
    const shape = this.shapeOf(surface);
    this.news = {
      pose,
      positions: shape?.positions ?? this.news?.positions ?? null,
      triangles: shape?.triangles ?? this.news?.triangles ?? null,
    };
  }

  // Whether something is new, and the state before was long enough ago.
  isDue(t_s: number): boolean {
    return this.news !== null && t_s >= this.due_s;
  }

  // Keeps the newest state as that of t_s.
  sample(t_s: number): void {
    const { news } = this;
    if (news === null) return;
    this.due_s = t_s + kStep_s;
    this.news = null;
    this.pose.add(t_s, news.pose);
    if (news.positions !== null) this.positions.add(t_s, news.positions);
    if (news.triangles !== null) this.triangles.add(t_s, news.triangles);
  }

  // null: it had not changed yet. The same object again as long as nothing is different.
  at(t_s: number): Surface | null {
    const pose = this.pose.at(t_s);
    if (pose === null) return null;
    const positions = this.positions.at(t_s);
    const triangles = this.triangles.at(t_s);
    const { shown } = this;
    const same = pose === shown?.pose && positions === shown.positions && triangles === shown.triangles;
    if (same) return shown.surface;
    const surface: Surface = {
      scene: this.scene,
      object: this.object,
      ...poseOfWords(pose),
      positions: positions === null ? null : floatsOf(positions),
      triangles,
    };
    this.shown = { pose, positions, triangles, surface };
    return surface;
  }

  // Lets go of what at() gave.
  rest(): void {
    this.shown = null;
    for (const track of this.all) track.rest();
  }

  // Only its newest state, to be kept again.
  restarted(): SurfaceTracks {
    const tracks = new SurfaceTracks(this.scene, this.object);
    const pose = this.news?.pose ?? this.pose.newest;
    if (pose !== null) tracks.news = { pose, positions: this.newestPositions, triangles: this.newestTriangles };
    return tracks;
  }

  private get newestPositions(): Uint32Array | null {
    return this.news?.positions ?? this.positions.newest;
  }
  private get newestTriangles(): Uint32Array | null {
    return this.news?.triangles ?? this.triangles.newest;
  }

  // null: only the pose counts, as in SurfaceMesh.
  private shapeOf({ positions, triangles }: Surface): Pick<News, 'positions' | 'triangles'> | null {
    if (positions === null) return null;
    const corners = triangles ?? this.newestTriangles;
    if (corners === null) return null;
    const rewired = triangles !== null || positions.length !== this.newestPositions?.length;
    if (rewired && !fit(positions, corners)) return null;
    return { positions: new Uint32Array(positions.buffer, positions.byteOffset, positions.length), triangles };
  }
}

export function poseOfWords(words: Uint32Array): Pick<Surface, 'rotation' | 'translation' | 'largest_displacement_m'> {
  const [w, x, y, z, tx, ty, tz, largest_displacement_m] = [...floatsOf(words)] as PoseNumbers;
  return { rotation: [w, x, y, z], translation: [tx, ty, tz], largest_displacement_m };
}

function floatsOf(words: Uint32Array): Float32Array {
  return new Float32Array(words.buffer, words.byteOffset, words.length);
}
