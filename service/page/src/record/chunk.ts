// A piece of a recording: whole messages with their samples, times strictly increasing. It only ever grows at its end,
// so that what was read of it stays true, also after the recorder has dropped it.
import type { Live } from '../types';
import { States } from './states';
import type { State } from './states';

// Samples [first, last) of a chunk.
export interface Slice {
  chunk: Chunk;
  first: number;
  last: number;
}

export class Chunk {
  count = 0; // samples
  private times: Float64Array;
  private samples: Float32Array;
  private starts = new Uint32Array(64); // the first sample of each message
  private readonly states = new States();

  constructor(
    private readonly channels: number,
    capacity: number, // samples
  ) {
    this.times = new Float64Array(capacity);
    this.samples = new Float32Array(capacity * channels);
  }

  get bytes(): number {
    return this.times.byteLength + this.samples.byteLength + this.starts.byteLength + this.states.bytes;
  }
  get begin_s(): number {
    return this.times[0]!;
  }
  get end_s(): number {
    return this.times[this.count - 1]!;
  }
  get messages(): number {
    return this.states.count;
  }

  fits(samples: number): boolean {
    return this.count + samples <= this.times.length;
  }

  // The message without those of its samples that are not in `rows`.
  add(live: Live, rows: readonly number[]): void {
    if (this.messages === this.starts.length) {
      const longer = new Uint32Array(2 * this.messages);
      longer.set(this.starts);
      this.starts = longer;
    }
    this.starts[this.messages] = this.count;
    this.states.add(live);
    for (const row of rows) {
      this.times[this.count] = live.times_s[row]!;
      const from = row * this.channels;
      const to = this.count * this.channels;
      for (let c = 0; c < this.channels; ++c) this.samples[to + c] = live.samples[from + c]!;
      ++this.count;
    }
  }

  // Gives back the memory that is not used; nothing is added any more.
  trim(): void {
    this.states.trim();
    this.starts = this.starts.slice(0, this.messages);
    if (this.count === this.times.length) return;
    this.times = this.times.slice(0, this.count);
    this.samples = this.samples.slice(0, this.count * this.channels);
  }

  // How many samples are before t_s; with `same`, those at t_s too.
  before(t_s: number, same: boolean): number {
    return bisect(this.count, (i) => this.times[i]! < t_s || (same && this.times[i] === t_s));
  }

  time(sample: number): number {
    return this.times[sample]!;
  }
  value(sample: number, channel: number): number {
    return this.samples[sample * this.channels + channel]!;
  }
  // Views, not copies.
  timesOf(first: number, last: number): Float64Array {
    return this.times.subarray(first, last);
  }
  samplesOf(first: number, last: number): Float32Array {
    return this.samples.subarray(first * this.channels, last * this.channels);
  }

  // The message of a sample.
  messageOf(sample: number): number {
    return bisect(this.messages, (i) => this.starts[i]! <= sample) - 1;
  }
  // Its first sample; that of the one after the last message: the end.
  start(message: number): number {
    return message < this.messages ? this.starts[message]! : this.count;
  }
  state(message: number): State {
    return this.states.get(message);
  }
}

// How many of n items, in order, are true; those that are come first.
export function bisect(n: number, isTrue: (i: number) => boolean): number {
  let low = 0;
  let high = n;
  while (low < high) {
    const middle = (low + high) >>> 1;
    if (isTrue(middle)) low = middle + 1;
    else high = middle;
  }
  return low;
}
