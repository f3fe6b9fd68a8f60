// Viridis, as a few points of it: even in brightness, and clear with every kind of colour vision.
const kViridis: [number, number, number][] = [
  [68, 1, 84],
  [72, 40, 120],
  [62, 74, 137],
  [49, 104, 142],
  [38, 130, 142],
  [31, 158, 137],
  [53, 183, 121],
  [109, 205, 89],
  [180, 222, 44],
  [253, 231, 37],
];

// share: 0 ... 1
export function viridis(share: number): string {
  const at = Math.min(1, Math.max(0, share)) * (kViridis.length - 1);
  const low = Math.min(kViridis.length - 2, Math.floor(at));
  const [a, b] = [kViridis[low], kViridis[low + 1]];
  if (a === undefined || b === undefined) return 'rgb(0, 0, 0)';
  const mix = a.map((from, i) => Math.round(from + ((b[i] ?? from) - from) * (at - low)));
  return `rgb(${mix.join(', ')})`;
}
