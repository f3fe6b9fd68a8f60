// The surfaces of a recording: objects that are soft, sculpted, extruded or moved, as they were at any time of it. At
// most ten states a second of each; the oldest go when there is no room.
import { isSurface } from '../decode';
import type { SceneMessage, Surface } from '../types';
import { bisect } from './chunk';
import { SurfaceTracks } from './surface_tracks';
import type { Entry } from './track';

const kObjects = 64; // of one scene: omnid has no more that change
const kStateShare = 1 / 8; // of the bytes: what all objects may have as they are now
const kSceneBytes = 512;

// While one scene was loaded.
interface Chapter {
  scene: number;
  name: string;
  begin_s: number; // NaN: no samples have come since
  objects: Map<number, SurfaceTracks>;
  state: number; // bytes of them as they are now
  complete: boolean; // false: an object was too large
}

export interface SurfacesThen {
  scene: number;
  name: string; // of the scene
  surfaces: Surface[]; // without those that were still as they are loaded
  late_s: number; // they are as they were so much later than asked for: what was before is no longer kept
  complete: boolean; // false: what is missing may have been too large to be kept
}

// For files.
export interface SurfaceEntry extends Entry {
  scene: number;
  name: string;
  object: number;
  part: 'pose' | 'positions' | 'triangles';
}

export class SurfaceRecord {
  private readonly chapters: Chapter[] = []; // that have samples, oldest first
  private now: Chapter | null = null; // the last of them, or to become it
  private total = 0; // bytes
  private lost_s = -Infinity;
  private newest_s = -Infinity; // of the samples
  private shown: Chapter | null = null; // that at() has looked at

  // `limit`: bytes.
  constructor(private readonly limit: number) {}

  get bytes(): number {
    return this.total;
  }
  // Before that, surfaces are no longer kept; -Infinity: as far back as there are samples.
  get from_s(): number {
    return this.lost_s;
  }

  setScene({ number, name }: Pick<SceneMessage, 'number' | 'name'>): void {
    if (this.now?.scene === number) return;
    if (this.now !== null && Number.isNaN(this.now.begin_s)) this.total -= bytesOf(this.now); // nothing was shown of it
    this.now = { scene: number, name, begin_s: NaN, objects: new Map(), state: 0, complete: true };
    this.total += bytesOf(this.now);
    this.bound();
  }

  add(surface: Surface): void {
    const chapter = this.now;
    if (chapter === null || surface.scene !== chapter.scene || !isSurface(surface)) return;
    const known = chapter.objects.get(surface.object);
    const tracks = known ?? new SurfaceTracks(surface.scene, surface.object);
    const bytes = known?.bytes ?? 0;
    chapter.state -= known?.stateBytes() ?? 0;
    const full = known === undefined && chapter.objects.size >= kObjects;
    if (full || chapter.state + tracks.stateBytes(surface) > kStateShare * this.limit) {
      chapter.objects.delete(surface.object);
      chapter.complete = false;
      this.total -= bytes;
      return;
    }
    tracks.take(surface);
    chapter.objects.set(surface.object, tracks);
    chapter.state += tracks.stateBytes();
    this.total += tracks.bytes - bytes;
    this.bound();
  }

  // Samples up to t_s have come: what is newest is as it was then. Times do not decrease.
  sample(t_s: number): void {
    const chapter = this.now;
    this.newest_s = t_s;
    if (chapter === null) return;
    if (Number.isNaN(chapter.begin_s)) {
      chapter.begin_s = t_s;
      this.chapters.push(chapter);
    }
    for (const tracks of chapter.objects.values()) {
      if (tracks.isDue(t_s)) this.counted(tracks, () => tracks.sample(t_s));
    }
    this.bound();
  }

  // Lets go of what at() gave: nothing is looked at any more.
  rest(): void {
    for (const tracks of this.shown?.objects.values() ?? []) this.counted(tracks, () => tracks.rest());
    this.shown = null;
  }

  // null: nothing is known of any time.
  at(t_s: number): SurfacesThen | null {
    const first = this.chapters[0];
    if (first === undefined || Number.isNaN(t_s)) return null;
    const then_s = Math.max(t_s, this.lost_s, first.begin_s);
    const chapter = this.chapters[bisect(this.chapters.length, (i) => this.chapters[i]!.begin_s <= then_s) - 1]!;
    if (this.shown !== chapter) this.rest();
    this.shown = chapter;
    const surfaces: Surface[] = [];
    for (const tracks of chapter.objects.values()) {
      const surface = this.counted(tracks, () => tracks.at(then_s));
      if (surface !== null) surfaces.push(surface);
    }
    const { scene, name, complete } = chapter;
    return { scene, name, surfaces, complete, late_s: Math.max(0, this.lost_s - t_s) };
  }

  // What makes up the surfaces from from_s to to_s, by time: of each object whole first, then what changes.
  entries(from_s: number, to_s: number): SurfaceEntry[] {
    const entries: SurfaceEntry[] = [];
    const begin_s = Math.max(from_s, this.lost_s);
    this.chapters.forEach(({ scene, name, objects }, i) => {
      const end_s = this.chapters[i + 1]?.begin_s ?? Infinity;
      if (!(end_s > begin_s)) return;
      for (const [object, tracks] of objects) {
        for (const part of ['pose', 'positions', 'triangles'] as const) {
          const found = tracks[part].entries(begin_s, to_s);
          for (const entry of found) entries.push({ ...entry, scene, name, object, part });
        }
      }
    });
    return entries.filter(({ t_s }) => t_s <= to_s).sort((a, b) => a.t_s - b.t_s);
  }

  // Forgets everything but what is now.
  clear(): void {
    this.chapters.length = 0;
    this.shown = null;
    this.total = 0;
    this.lost_s = -Infinity;
    if (this.now !== null) this.restart(this.now);
  }

  // Forgets what is only of times before.
  dropBefore(t_s: number): void {
    while ((this.chapters[1]?.begin_s ?? Infinity) <= t_s) this.forget(this.chapters.shift()!);
    for (const tracks of this.chapters[0]?.objects.values() ?? []) {
      for (const track of tracks.all) {
        while (track.second_s <= t_s) this.counted(tracks, () => track.dropOldest());
      }
    }
  }

  private forget(chapter: Chapter): void {
    this.total -= bytesOf(chapter);
    if (this.shown === chapter) this.shown = null;
  }

  private restart(chapter: Chapter): void {
    const objects = [...chapter.objects].map(([object, tracks]) => [object, tracks.restarted()] as const);
    this.now = { ...chapter, begin_s: NaN, objects: new Map(objects) };
    this.total += bytesOf(this.now);
  }

  private bound(): void {
    while (this.total > this.limit && this.dropOldest());
  }

  // Of the oldest scene, and of that what is oldest. False: nothing of the past is left.
  private dropOldest(): boolean {
    const chapter = this.chapters[0];
    if (chapter === undefined) return false;
    const all = [...chapter.objects.values()].flatMap((tracks) => tracks.all.map((track) => ({ tracks, track })));
    const old = all.filter(({ track }) => track.second_s < Infinity);
    if (old.length > 0) {
      const { tracks, track } = old.reduce((a, b) => (b.track.begin_s < a.track.begin_s ? b : a));
      this.lost_s = Math.max(this.lost_s, track.second_s);
      this.counted(tracks, () => track.dropOldest());
      return true;
    }
    this.chapters.shift();
    this.forget(chapter);
    this.lost_s = this.chapters[0]?.begin_s ?? this.newest_s;
    if (chapter !== this.now) return true;
    this.restart(chapter); // what is now has grown by many small changes
    return false;
  }

  // Does something with an object of a chapter, and counts what it takes.
  private counted<T>(tracks: SurfaceTracks, change: () => T): T {
    const before = tracks.bytes;
    const result = change();
    this.total += tracks.bytes - before;
    return result;
  }
}

function bytesOf({ name, objects }: Chapter): number {
  let bytes = kSceneBytes + 2 * name.length;
  for (const tracks of objects.values()) bytes += tracks.bytes;
  return bytes;
}
