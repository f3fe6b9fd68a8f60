// Numbers and names as they are written into files.

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
