// Keeps what the service sent: always the newest ten minutes, and what the person asked to keep. For replay, and for
// files. Bounded in memory: chunks of samples, of which the oldest go first, those of a recording last; surfaces have a
// bound of their own.
import type { Hello, Live } from '../types';
import { Chunk, bisect } from './chunk';
import type { Slice } from './chunk';
import { writeMcap } from './omni_mcap';
import { SurfaceRecord } from './surface_record';
import { writeCsv } from './text';

export interface Limits {
  length_s: number;
  bytes: number;
  chunk: number; // samples
  surface_bytes: number; // besides
}

const kLimits: Limits = { length_s: 600, bytes: 192e6, chunk: 4096, surface_bytes: 128e6 };
const kRecordingShare = 0.9; // of both limits; the rest is for what comes after the recording
const kGap_s = 1; // longer ones between two messages are not counted as recorded time
const kLatest_s = 4e9; // 127 years after the machine was started: no such time
const kJump_s = 1; // back by more: another clock. By less: samples that were sent before

export class Recorder {
  readonly surfaces: SurfaceRecord;
  private readonly channels: number;
  private readonly limits: Limits;
  private chunks: Chunk[] = [];
  private newest_s = NaN;
  private isRecording = false;
  private from_s = NaN; // what start and stop marked; NaN: nothing
  private to_s = NaN;
  private why = '';
  private refused = 0;
  private epoch_ms = 0; // what the clock of this computer showed at 0 of CLOCK_MONOTONIC

  constructor(
    private readonly hello: Hello,
    limits: Partial<Limits> = {},
  ) {
    this.channels = hello.channels.length;
    this.limits = { ...kLimits, ...limits };
    this.surfaces = new SurfaceRecord(this.limits.surface_bytes);
  }

  get recording(): boolean {
    return this.isRecording;
  }
  // Why the recording stopped itself; "": it did not.
  get stopped_why(): string {
    return this.why;
  }
  // Messages that do not fit the channels of the first one.
  get ignored(): number {
    return this.refused;
  }
  // Seconds of samples, without gaps.
  get length_s(): number {
    return lengthOf(this.chunks);
  }
  get samples(): number {
    return this.chunks.reduce((sum, chunk) => sum + chunk.count, 0);
  }
  get bytes(): number {
    return bytesOf(this.chunks);
  }
  // NaN while nothing is kept.
  get begin_s(): number {
    return this.chunks[0]?.begin_s ?? NaN;
  }
  get end_s(): number {
    return this.chunks.at(-1)?.end_s ?? NaN;
  }
  // null also between start and the first sample.
  get kept(): { from_s: number; to_s: number } | null {
    if (Number.isNaN(this.from_s)) return null;
    return { from_s: this.from_s, to_s: this.isRecording ? this.newest_s : this.to_s };
  }

  // From the next sample on; forgets what was marked before.
  start(): void {
    if (this.isRecording) return;
    this.isRecording = true;
    this.from_s = NaN;
    this.to_s = NaN;
    this.why = '';
  }

  stop(): void {
    if (!this.isRecording) return;
    this.to_s = this.newest_s;
    this.isRecording = false;
  }

  // Drops everything. A recording goes on with what comes next.
  clear(): void {
    this.chunks = [];
    this.surfaces.clear();
    this.from_s = NaN;
    this.to_s = NaN;
  }

  add(live: Live): void {
    if (live.times_s.length !== live.count || live.samples.length !== live.count * this.channels) {
      ++this.refused;
      return;
    }
    const rows = this.newRows(live.times_s);
    if (rows.length === 0) return;
    const first_s = live.times_s[rows[0]!]!;
    this.chunkFor(rows.length, first_s).add(live, rows);
    this.newest_s = live.times_s[rows.at(-1)!]!;
    this.surfaces.sample(this.newest_s);
    this.epoch_ms = Date.now() - 1e3 * this.newest_s;
    if (this.isRecording && Number.isNaN(this.from_s)) this.from_s = first_s;
    this.bound();
  }

  // The message of the newest sample at or before t_s, with its samples up to t_s (views). null: t_s is before all.
  at(t_s: number): Live | null {
    const chunk = this.chunks[bisect(this.chunks.length, (i) => this.chunks[i]!.begin_s <= t_s) - 1];
    if (chunk === undefined) return null;
    const last = chunk.before(t_s, true);
    const message = chunk.messageOf(last - 1);
    const first = chunk.start(message);
    return {
      ...chunk.state(message),
      t_s: chunk.time(last - 1),
      count: last - first,
      times_s: chunk.timesOf(first, last),
      samples: chunk.samplesOf(first, last),
    };
  }

  // Copies of the samples from from_s to to_s, both included; here and below.
  range(from_s: number, to_s: number): { times_s: Float64Array; samples: Float32Array; count: number } {
    const slices = this.slices(from_s, to_s);
    const count = slices.reduce((sum, { first, last }) => sum + last - first, 0);
    const times_s = new Float64Array(count);
    const samples = new Float32Array(count * this.channels);
    let at = 0;
    for (const { chunk, first, last } of slices) {
      times_s.set(chunk.timesOf(first, last), at);
      samples.set(chunk.samplesOf(first, last), at * this.channels);
      at += last - first;
    }
    return { times_s, samples, count };
  }

  // Files of what is kept now; what is dropped meanwhile is still in them.
  csv(from_s: number, to_s: number): Promise<Blob> {
    return writeCsv(this.hello.channels, this.slices(from_s, to_s), Math.max(from_s, this.begin_s));
  }

  mcap(from_s: number, to_s: number): Promise<Blob> {
    const epoch_ns = BigInt(Math.round(1e3 * this.epoch_ms)) * 1000n;
    return writeMcap(this.hello, this.slices(from_s, to_s), this.surfaces.entries(from_s, to_s), epoch_ns);
  }

  // Which samples of a message are newer than all before. If the clock has gone back, everything before is dropped:
  // it has no place in the same time.
  private newRows(times_s: Float64Array): number[] {
    let rows: number[] = [];
    let newest_s = this.newest_s;
    times_s.forEach((t_s, row) => {
      if (!(t_s >= 0 && t_s <= kLatest_s)) return;
      if (t_s < newest_s - kJump_s) {
        this.forget();
        rows = [];
      } else if (t_s <= newest_s) {
        return;
      }
      rows.push(row);
      newest_s = t_s;
    });
    return rows;
  }

  private forget(): void {
    this.clear();
    if (!this.isRecording) return;
    this.isRecording = false;
    this.why = 'Recording stopped: the clock of the service was set back. What was recorded before is gone.';
  }

  // The chunk for the next message; a message is never split.
  private chunkFor(samples: number, first_s: number): Chunk {
    const last = this.chunks.at(-1);
    if (last !== undefined && last.fits(samples) && first_s - last.end_s <= kGap_s) return last;
    last?.trim(); // nothing fits any more
    const chunk = new Chunk(this.channels, Math.max(this.limits.chunk, samples));
    this.chunks.push(chunk);
    return chunk;
  }

  // Whether start and stop marked anything of it.
  private isMarked(chunk: Chunk): boolean {
    return chunk.end_s >= this.from_s && (this.isRecording || chunk.begin_s <= this.to_s); // false while from_s is NaN
  }

  private bound(): void {
    const { length_s, bytes } = this.limits;
    if (this.isRecording) {
      const marked = this.chunks.filter((chunk) => this.isMarked(chunk));
      const full = bytesOf(marked) > kRecordingShare * bytes;
      if (full || lengthOf(marked) > kRecordingShare * length_s) this.stopFull();
    }
    const { begin_s } = this;
    while (this.bytes > bytes || this.length_s > length_s) {
      const unmarked = this.chunks.findIndex((chunk) => !this.isMarked(chunk));
      const [dropped] = this.chunks.splice(Math.max(unmarked, 0), 1);
      if (unmarked < 0) this.unmark(dropped!);
    }
    if (this.begin_s !== begin_s) this.surfaces.dropBefore(this.begin_s);
  }

  private stopFull(): void {
    this.stop();
    const minutes = ((this.to_s - this.from_s) / 60).toFixed(1);
    this.why = `Recording stopped after ${minutes} minutes: there is no room for more. Save it, then start again.`;
  }

  // The beginning of the recording, which has stopped, is gone: a message was larger than what is left for new ones.
  private unmark(dropped: Chunk): void {
    const next = this.chunks.find((chunk) => chunk.begin_s > dropped.end_s);
    this.from_s = next !== undefined && next.begin_s <= this.to_s ? next.begin_s : NaN;
  }

  private slices(from_s: number, to_s: number): Slice[] {
    if (!(from_s <= to_s)) return [];
    return this.chunks
      .map((chunk) => ({ chunk, first: chunk.before(from_s, false), last: chunk.before(to_s, true) }))
      .filter(({ first, last }) => last > first);
  }
}

function bytesOf(chunks: readonly Chunk[]): number {
  return chunks.reduce((sum, chunk) => sum + chunk.bytes, 0);
}

function lengthOf(chunks: readonly Chunk[]): number {
  return chunks.reduce((sum, chunk, i) => {
    const gap_s = i > 0 ? chunk.begin_s - chunks[i - 1]!.end_s : 0;
    return sum + chunk.end_s - chunk.begin_s + (gap_s <= kGap_s ? gap_s : 0);
  }, 0);
}
