// Colours of the lines, different for most people with a colour deficiency, too (Okabe and Ito, darker or lighter so
// that each has a contrast of at least 3 to the background of its theme).
const kLight = ['#0072b2', '#c2410c', '#00805e', '#a8467a', '#8a6100', '#4a4fc4', '#0e7490', '#6b7280'];
const kDark = ['#56b4e9', '#ff8b4d', '#2bd4a0', '#e48fc0', '#f0c541', '#a5a9ff', '#5ad6e8', '#a9b1bd'];

export function lineColour(index: number, dark: boolean): string {
  const colours = dark ? kDark : kLight;
  return colours[index % colours.length] ?? '#888888';
}

// The same colours again are dashed.
export function lineDash(index: number): number[] {
  return index < kLight.length ? [] : index < 2 * kLight.length ? [6, 3] : [2, 3];
}
