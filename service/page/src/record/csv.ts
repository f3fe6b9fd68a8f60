// A recording as CSV (RFC 4180): one row per sample, "time_s, channels ..., t_monotonic_s". Made in pieces of a quarter
// megabyte that are handed to the browser at once, so that a long one neither blocks the page nor fills its memory.
import type { Channel } from '../types';
import type { Slice } from './chunk';
import { Pace } from './pace';
import { shortest, unique } from './text';

const kPieceLength = 1 << 18;
const kRowsAtOnce = 64; // between two looks at the clock
const kTime = 'time_s'; // since the start of the range
const kMonotonic = 't_monotonic_s';

function field(text: string): string {
  return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}

export async function writeCsv(channels: readonly Channel[], slices: readonly Slice[], start_s: number): Promise<Blob> {
  const pace = new Pace();
  const pieces: Blob[] = [];
  const names = unique(channels.map((channel) => channel.name), [kTime, kMonotonic]);
  let text = `${[kTime, ...names, kMonotonic].map(field).join(',')}\r\n`;
  for (const { chunk, first, last } of slices) {
    for (let i = first; i < last; ++i) {
      const t_s = chunk.time(i);
      let row = (t_s - start_s).toFixed(6);
      for (let c = 0; c < channels.length; ++c) row += `,${shortest(chunk.value(i, c))}`;
      text += `${row},${t_s.toFixed(6)}\r\n`;
      if (text.length >= kPieceLength) {
        pieces.push(new Blob([text]));
        text = '';
      }
      if (i % kRowsAtOnce === 0) await pace.rest();
    }
  }
  return new Blob([...pieces, text], { type: 'text/csv;charset=utf-8;header=present' });
}
