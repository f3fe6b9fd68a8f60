// Numbers for people: mm, N, °C, µT instead of the SI units of the messages.

// How a unit of the messages is shown: factor and name.
const kShown: Record<string, { factor: number; unit: string; decimals: number }> = {
  m: { factor: 1e3, unit: 'mm', decimals: 2 },
  'm²': { factor: 1e6, unit: 'mm²', decimals: 4 },
  m2: { factor: 1e6, unit: 'mm²', decimals: 4 },
  'm^2': { factor: 1e6, unit: 'mm²', decimals: 4 },
  'm/s': { factor: 1e3, unit: 'mm/s', decimals: 1 },
  'm/s^2': { factor: 1, unit: 'm/s²', decimals: 2 },
  'm/s2': { factor: 1, unit: 'm/s²', decimals: 2 },
  N: { factor: 1, unit: 'N', decimals: 3 },
  Nm: { factor: 1e3, unit: 'mN·m', decimals: 2 },
  'N*m': { factor: 1e3, unit: 'mN·m', decimals: 2 },
  'N/m': { factor: 1, unit: 'N/m', decimals: 0 },
  'N*s/m': { factor: 1, unit: 'N·s/m', decimals: 2 },
  A: { factor: 1, unit: 'A', decimals: 2 },
  V: { factor: 1, unit: 'V', decimals: 2 },
  W: { factor: 1, unit: 'W', decimals: 1 },
  '°C': { factor: 1, unit: '°C', decimals: 1 },
  C: { factor: 1, unit: '°C', decimals: 1 },
  degC: { factor: 1, unit: '°C', decimals: 1 },
  K: { factor: 1, unit: 'K', decimals: 1 },
  T: { factor: 1e6, unit: 'µT', decimals: 1 },
  uT: { factor: 1, unit: 'µT', decimals: 1 },
  s: { factor: 1, unit: 's', decimals: 3 },
  ms: { factor: 1, unit: 'ms', decimals: 2 },
  'µs': { factor: 1, unit: 'µs', decimals: 1 },
  us: { factor: 1, unit: 'µs', decimals: 1 },
  ns: { factor: 1e-3, unit: 'µs', decimals: 1 },
  rad: { factor: 180 / Math.PI, unit: '°', decimals: 1 },
  'rad/s': { factor: 180 / Math.PI, unit: '°/s', decimals: 1 },
  Hz: { factor: 1, unit: 'Hz', decimals: 0 },
  Pa: { factor: 1, unit: 'Pa', decimals: 0 },
  '1': { factor: 1, unit: '', decimals: 2 },
  '': { factor: 1, unit: '', decimals: 2 },
};

export interface Shown {
  factor: number; // shown value = factor x value of the message
  unit: string;
  decimals: number;
}

export function shownUnit(unit: string): Shown {
  return kShown[unit] ?? { factor: 1, unit, decimals: 2 };
}

// "-" where there is no number; never "-0.0".
export function fixed(value: number, decimals: number): string {
  if (!Number.isFinite(value)) return '-';
  const text = value.toFixed(decimals);
  return Number(text) === 0 ? (0).toFixed(decimals) : text;
}

export function withUnit(value: number, unit: string, decimals?: number): string {
  const shown = shownUnit(unit);
  const number = fixed(value * shown.factor, decimals ?? shown.decimals);
  return shown.unit === '' || number === '-' ? number : `${number} ${shown.unit}`;
}

export function mm(metres: number, decimals = 1): string {
  return withUnit(metres, 'm', decimals);
}

// "1:05.3", "0:07"
export function clock(seconds: number, decimals = 0): string {
  if (!Number.isFinite(seconds)) return '-';
  const ticks = 10 ** decimals;
  const whole = Math.round(Math.max(0, seconds) * ticks) / ticks;
  const rest = (whole % 60).toFixed(decimals).padStart(decimals > 0 ? 3 + decimals : 2, '0');
  return `${Math.floor(whole / 60)}:${rest}`;
}

// "3.4 MB"
export function size(bytes: number): string {
  if (bytes < 1e3) return `${bytes} B`;
  if (bytes < 1e6) return `${(bytes / 1e3).toFixed(0)} kB`;
  return `${(bytes / 1e6).toFixed(bytes < 1e7 ? 1 : 0)} MB`;
}

export function plural(count: number, one: string, many = `${one}s`): string {
  return `${count} ${count === 1 ? one : many}`;
}
