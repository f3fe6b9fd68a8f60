// Where around the base the pen has been tracked, and how well the calibration explains the readings there: the upper
// half sphere in fields of about the same area.
import type { Vec3 } from '../types';

export const kRings = 9; // of 10 degrees of elevation
const kRing = Math.PI / 2 / kRings;
const kMost = 36; // fields of the lowest ring
const kRatioMax = 100; // one wild fit does not outweigh all others
const kForget = 400; // samples over which a field's mean is taken: newer ones count more

export interface Field {
  ring: number; // 0: at the horizon
  index: number; // in its ring, from +x over +y
  of: number; // fields in its ring
  area: number; // share of the half sphere
  samples: number;
  residual: number; // mean chi2 per degree of freedom; about 1 is good
}

export interface Summary {
  covered: number; // share of the half sphere
  mean: number; // residual by area; NaN: nothing yet
  worst: Field | null;
}

export class CoverageMap {
  readonly fields: Field[] = [];
  private readonly first: number[] = []; // field of each ring

  constructor() {
    for (let ring = 0; ring < kRings; ++ring) {
      const of = Math.max(1, Math.round(kMost * Math.cos((ring + 0.5) * kRing)));
      const area = (Math.sin((ring + 1) * kRing) - Math.sin(ring * kRing)) / of;
      this.first.push(this.fields.length);
      for (let index = 0; index < of; ++index) this.fields.push({ ring, index, of, area, samples: 0, residual: NaN });
    }
  }

  // null: below the horizon, where no pen goes.
  at(place: Vec3): Field | null {
    const distance = Math.hypot(...place);
    const elevation = Math.asin(place[2] / distance);
    if (!(elevation >= 0)) return null;
    const ring = Math.min(kRings - 1, Math.floor(elevation / kRing));
    const first = this.first[ring] ?? 0;
    const of = this.fields[first]?.of ?? 1;
    const turn = Math.atan2(place[1], place[0]) / (2 * Math.PI);
    const index = Math.min(of - 1, Math.floor((turn - Math.floor(turn)) * of));
    return this.fields[first + index] ?? null;
  }

  // residual NaN: tracked, but the service does not say how well.
  add(place: Vec3, residual: number): void {
    const field = this.at(place);
    if (field === null) return;
    field.samples = Math.min(field.samples + 1, kForget);
    if (!Number.isFinite(residual)) return;
    const value = Math.min(residual, kRatioMax);
    if (Number.isNaN(field.residual)) field.residual = value;
    else field.residual += (value - field.residual) / field.samples;
  }

  clear(): void {
    for (const field of this.fields) {
      field.samples = 0;
      field.residual = NaN;
    }
  }

  summary(): Summary {
    let covered = 0;
    let known = 0;
    let sum = 0;
    let worst: Field | null = null;
    for (const field of this.fields) {
      if (field.samples === 0) continue;
      covered += field.area;
      if (Number.isNaN(field.residual)) continue;
      known += field.area;
      sum += field.area * field.residual;
      if (worst === null || field.residual > worst.residual) worst = field;
    }
    return { covered, mean: known > 0 ? sum / known : NaN, worst };
  }
}

// "on the right, 35° up"
export function placeWords(field: Field): string {
  const up = Math.round(((field.ring + 0.5) * kRing * 180) / Math.PI);
  if (up > 75) return 'on top';
  const eighth = Math.round((((field.index + 0.5) / field.of) * 8) % 8) % 8;
  const sides = ['on the right', 'behind on the right', 'behind', 'behind on the left'];
  sides.push('on the left', 'in front on the left', 'in front', 'in front on the right');
  return `${sides[eighth] ?? ''}, ${up}° up`;
}
