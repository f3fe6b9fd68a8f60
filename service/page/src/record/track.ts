// The past of one array of words: groups of a whole state and the changes after it. The changes of a group are together
// no longer than its whole state, so that any time is shown at the cost of two states, however long the track is.
import { bisect } from './chunk';
import { changed, changedRuns } from './word_changes';
import type { Change } from './word_changes';

const kChangeBytes = 256; // what a change takes besides its words, generously; shorter states are always kept whole
const kGroupBytes = 512;

// Only its newest one grows.
interface Group {
  begin_s: number;
  whole: Uint32Array;
  changes: Change[];
  bytes: number;
}

// A state, or what of it has changed.
export interface Entry {
  t_s: number;
  whole: boolean;
  length: number; // of the whole state
  words: Uint32Array; // whole: the state; else runs, see word_changes.ts
}

export class Track {
  private readonly groups: Group[] = [];
  private total = 0; // bytes of the groups
  private now: Uint32Array | null = null; // as the groups have it: within the tolerance of what came last
  private last: { group: Group; changes: number; words: Uint32Array } | null = null; // what at() gave

  // `tolerance`: floats that differ by no more are the same; 0: everything is kept as it is.
  constructor(private readonly tolerance: number) {}

  // null: nothing was added.
  get newest(): Uint32Array | null {
    return this.now;
  }
  get bytes(): number {
    return this.total + this.nowBytes + (this.last?.words.buffer.byteLength ?? 0);
  }
  // From when on it is known after the oldest group has gone; Infinity: that is the only one.
  get second_s(): number {
    return this.groups[1]?.begin_s ?? Infinity;
  }
  get begin_s(): number {
    return this.groups[0]?.begin_s ?? Infinity;
  }

  // `words` may be changed afterwards. Times do not decrease.
  add(t_s: number, words: Uint32Array): void {
    const group = this.groups.at(-1);
    if (group === undefined || this.now === null) return this.begin(t_s, words);
    const used = group.bytes - kGroupBytes - group.whole.byteLength;
    const room = group.whole.byteLength - used - kChangeBytes;
    const runs = changedRuns(this.now, words, this.tolerance, Math.max(0, room) / 4);
    if (runs === null) return this.begin(t_s, words);
    if (runs.length === 0 && words.length === this.now.length) return;
    if (room < 0) return this.begin(t_s, words); // only shorter
    const change = { t_s, length: words.length, runs };
    group.changes.push(change);
    group.bytes += kChangeBytes + runs.byteLength;
    this.total += kChangeBytes + runs.byteLength;
    this.now = changed(this.now, [change]);
  }

  // The newest state at or before t_s: the same array again as long as it is the same state. null: t_s is before all.
  at(t_s: number): Uint32Array | null {
    const group = this.groupAt(t_s);
    if (group === undefined) return null;
    const changes = changesUntil(group, t_s);
    if (changes === 0) return group.whole;
    if (this.last?.group !== group || this.last.changes !== changes) {
      this.last = { group, changes, words: changed(group.whole, group.changes.slice(0, changes)) };
    }
    return this.last.words;
  }

  // Lets go of what at() gave.
  rest(): void {
    this.last = null;
  }

  dropOldest(): void {
    const group = this.groups.shift();
    if (group === undefined) return;
    this.total -= group.bytes;
    if (this.last?.group === group) this.rest();
    if (this.groups.length === 0) this.now = null;
  }

  // What makes up the states from from_s to to_s, oldest first; the first is whole.
  entries(from_s: number, to_s: number): Entry[] {
    const entries: Entry[] = [];
    const group = this.groupAt(from_s);
    if (group !== undefined) {
      const words = changed(group.whole, group.changes.slice(0, changesUntil(group, from_s)));
      entries.push({ t_s: from_s, whole: true, length: words.length, words });
    }
    for (const { begin_s, whole, changes } of this.groups) {
      if (begin_s > to_s) break;
      if (begin_s > from_s) entries.push({ t_s: begin_s, whole: true, length: whole.length, words: whole });
      for (const { t_s, length, runs } of changes) {
        if (t_s > from_s && t_s <= to_s) entries.push({ t_s, whole: false, length, words: runs });
      }
    }
    return entries;
  }

  private groupAt(t_s: number): Group | undefined {
    return this.groups[bisect(this.groups.length, (i) => this.groups[i]!.begin_s <= t_s) - 1];
  }

  private get nowBytes(): number {
    const shared = this.now === null || this.now === this.groups.at(-1)?.whole;
    return shared ? 0 : this.now!.buffer.byteLength;
  }

  private begin(t_s: number, words: Uint32Array): void {
    const whole = words.slice();
    const bytes = kGroupBytes + whole.byteLength;
    this.groups.push({ begin_s: t_s, whole, changes: [], bytes });
    this.total += bytes;
    this.now = whole;
  }
}

function changesUntil({ changes }: Group, t_s: number): number {
  return bisect(changes.length, (i) => changes[i]!.t_s <= t_s);
}
