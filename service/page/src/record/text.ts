// Numbers and names as they are written into files, and CSV files.
import type { Channel } from '../types';
import type { Slice } from './chunk';

const kDigits = 7; // what most measured values need
const kMaximumDigits = 10; // 9 are always enough; one more, because the exponent below may be one too large
const kPieceBytes = 8192; // that are made into text at once
const kPowers = Array.from({ length: 23 }, (_, k) => Number(`1e${k}`)); // the powers of ten that a double holds exactly

// x to `digits` decimal digits, of which the first is at 10^exponent. The last step has exact operands and rounds
// correctly, so that the result is the very double that the decimal text is read as.
function rounded(x: number, digits: number, exponent: number): number {
  const shift = digits - 1 - exponent;
  const power = kPowers[Math.abs(shift)];
  if (power === undefined) return Number(x.toPrecision(digits));
  return shift >= 0 ? Math.round(x * power) / power : Math.round(x / power) * power;
}

// The double with the fewest decimal digits that is still this float32: 0.1 for 0.10000000149011612.
export function shorten(x: number): number {
  if (!Number.isFinite(x) || x === 0) return x;
  const exponent = Math.floor(Math.log10(Math.abs(x)));
  let digits = kDigits;
  let result = rounded(x, digits, exponent);
  if (Math.fround(result) !== x) { // more, until it is right
    while (Math.fround(result) !== x && digits < kMaximumDigits) result = rounded(x, ++digits, exponent);
    return Math.fround(result) === x ? result : x; // x: not a float32
  }
  while (digits > 1) { // fewer, as long as it is right
    const shorter = rounded(x, --digits, exponent);
    if (Math.fround(shorter) !== x) break;
    result = shorter;
  }
  return result;
}

// The shortest text that is read back as this float32; "NaN" and "Infinity" where it is none.
export function shortest(x: number): string {
  return Object.is(x, -0) ? '-0' : String(shorten(x));
}

// The same for JSON, which has no text for what is not finite.
export function shortestJson(x: number): string {
  return Number.isFinite(x) ? shortest(x) : 'null';
}

// Of any bytes, for JSON.
export function base64(bytes: Uint8Array): string {
  let text = '';
  for (let at = 0; at < bytes.length; at += kPieceBytes) {
    text += String.fromCharCode(...bytes.subarray(at, at + kPieceBytes));
  }
  return btoa(text);
}

// Names that are columns or keys: a second "a" becomes "a_2", and none is one of `taken`.
export function unique(names: readonly string[], taken: readonly string[]): string[] {
  const used = new Set(taken);
  return names.map((name) => {
    let result = name;
    for (let n = 2; used.has(result); ++n) result = `${name}_${n}`;
    used.add(result);
    return result;
  });
}

const kPieceLength = 1 << 18;
const kRowsAtOnce = 64; // between two looks at the clock
const kTime = 'time_s'; // since the start of the range
const kMonotonic = 't_monotonic_s';

function field(text: string): string {
  return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}

// A recording as CSV (RFC 4180): one row per sample, "time_s, channels ..., t_monotonic_s". Made in pieces of a quarter
// megabyte that are handed to the browser at once, so that a long one neither blocks the page nor fills its memory.
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

const kWork_ms = 10;

// Lets the page draw and answer while a file is being made: after 10 ms of work it gives way once. By a message to
// itself, not by a timer: the timers of a hidden tab fire only once a second.
export class Pace {
  private since_ms = performance.now();

  async rest(): Promise<void> {
    if (performance.now() - this.since_ms < kWork_ms) return;
    await new Promise<void>((resolve) => {
      const { port1, port2 } = new MessageChannel();
      port1.onmessage = () => {
        port1.close();
        resolve();
      };
      port2.postMessage(null);
    });
    this.since_ms = performance.now();
  }
}
