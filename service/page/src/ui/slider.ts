// One number of a material: a slider and the same as a number to type, with unit and a way back.
import { make, makeButton, setHidden } from './dom';
import { shownUnit } from './format';
import type { MaterialField } from '../types';

const kSteps = 1000; // of the slider
const kLogRatio = 500; // a range over more than this is divided by factors

export class FieldSlider {
  readonly root: HTMLElement;
  private readonly range: HTMLInputElement;
  private readonly number: HTMLInputElement;
  private readonly back: HTMLButtonElement;
  private readonly factor: number;
  private value = 0; // SI, like all below
  private first = 0; // as the scene has it

  constructor(
    private readonly field: MaterialField,
    private readonly change: (value: number) => void,
  ) {
    const shown = shownUnit(field.unit);
    this.factor = shown.factor;
    const id = `field-${field.key.replace(/[^a-zA-Z0-9]/g, '-')}`;
    const about = field.about.replace(/`/g, '');
    this.range = make('input', { type: 'range', id, min: 0, max: kSteps, step: 1 });
    this.range.dataset['testid'] = `slider-${field.key}`;
    this.number = make('input', {
      type: 'number',
      'aria-label': `${field.label}${shown.unit === '' ? '' : `, ${shown.unit}`}`,
      min: tidy(field.minimum * this.factor),
      max: tidy(field.maximum * this.factor),
      step: 'any',
      'data-testid': `number-${field.key}`,
    });
    this.back = makeButton('↺', () => this.enter(this.first), { class: 'button quiet reset' });
    this.back.title = `${field.label}: back to the scene’s value`;
    this.back.setAttribute('aria-label', this.back.title);
    const head = make('div', { class: 'field-head' }, make('label', { for: id }, field.label));
    head.append(this.number, make('span', { class: 'field-unit' }, shown.unit), this.back);
    this.root = make('div', { class: 'field' }, head, this.range);
    if (about !== '') {
      this.range.setAttribute('aria-describedby', `${id}-about`);
      this.root.append(make('p', { class: 'field-about', id: `${id}-about` }, about));
    }
    this.range.addEventListener('input', () => this.enter(this.fromStep(Number(this.range.value))));
    this.number.addEventListener('change', () => {
      const typed = this.number.valueAsNumber / this.factor;
      if (Number.isFinite(typed)) this.enter(typed);
      else this.write(this.value);
    });
  }

  // From the service: what the material has now, and had when it was loaded.
  set(value: number, first: number): void {
    this.first = first;
    if (document.activeElement !== this.number || value !== this.value) this.write(value);
  }

  private enter(value: number): void {
    this.write(Math.min(this.field.maximum, Math.max(this.field.minimum, value)));
    this.change(this.value);
  }

  private write(value: number): void {
    this.value = value;
    const step = String(this.toStep(value));
    if (this.range.value !== step) this.range.value = step;
    const text = tidy(value * this.factor);
    if (this.number.value !== text) this.number.value = text;
    const spoken = `${text} ${shownUnit(this.field.unit).unit}`.trim();
    if (this.range.getAttribute('aria-valuetext') !== spoken) this.range.setAttribute('aria-valuetext', spoken);
    setHidden(this.back, Math.abs(value - this.first) <= 1e-6 * Math.abs(this.first));
  }

  private get logarithmic(): boolean {
    return this.field.minimum > 0 && this.field.maximum / this.field.minimum > kLogRatio;
  }

  private toStep(value: number): number {
    const { minimum, maximum } = this.field;
    const share = this.logarithmic
      ? Math.log(value / minimum) / Math.log(maximum / minimum)
      : (value - minimum) / (maximum - minimum);
    return Math.round(kSteps * Math.min(1, Math.max(0, share)));
  }

  private fromStep(step: number): number {
    const { minimum, maximum } = this.field;
    const share = step / kSteps;
    const value = this.logarithmic ? minimum * (maximum / minimum) ** share : minimum + (maximum - minimum) * share;
    return Number(value.toPrecision(4));
  }
}

// Four digits, without the zeros behind them.
function tidy(value: number): string {
  return String(Number(value.toPrecision(4)));
}
