// States of an array of 32-bit words (floats, vertex numbers) as what has changed since the state before: runs of
// [first, count, that many words].

const kGap = 2; // so many unchanged words between two changed ones are cheaper kept than skipped

export interface Change {
  t_s: number;
  length: number; // of the whole array from now on
  runs: Uint32Array;
}

// null: that would be more than `most` words. Floats that differ by at most `tolerance` are the same; 0: words are
// compared, whatever they are.
export function changedRuns(
  before: Uint32Array,
  after: Uint32Array,
  tolerance: number,
  most: number,
): Uint32Array | null {
  const old = new Float32Array(before.buffer, before.byteOffset, before.length);
  const next = new Float32Array(after.buffer, after.byteOffset, after.length);
  const ends: number[] = []; // first word and end of each run
  let length = 0;
  for (let i = 0; i < after.length; ++i) {
    if (i < before.length) {
      if (before[i] === after[i]) continue;
      if (tolerance > 0 && Math.abs(old[i]! - next[i]!) <= tolerance) continue;
    }
    const end = ends.length > 0 ? ends[ends.length - 1]! : -Infinity;
    if (i - end <= kGap) {
      ends[ends.length - 1] = i + 1;
      length += i + 1 - end;
    } else {
      ends.push(i, i + 1);
      length += 3;
    }
    if (length > most) return null;
  }
  const runs = new Uint32Array(length);
  for (let run = 0, at = 0; run < ends.length; run += 2) {
    const words = after.subarray(ends[run]!, ends[run + 1]!);
    runs[at] = ends[run]!;
    runs[at + 1] = words.length;
    runs.set(words, at + 2);
    at += 2 + words.length;
  }
  return runs;
}

// The state after all of the changes. A copy; `whole` stays.
export function changed(whole: Uint32Array, changes: readonly Change[]): Uint32Array {
  const longest = changes.reduce((most, { length }) => Math.max(most, length), whole.length);
  const words = new Uint32Array(longest);
  words.set(whole);
  for (const { runs } of changes) {
    for (let at = 0; at < runs.length; ) {
      const end = at + 2 + runs[at + 1]!;
      words.set(runs.subarray(at + 2, end), runs[at]!);
      at = end;
    }
  }
  return words.subarray(0, changes.at(-1)?.length ?? whole.length);
}
