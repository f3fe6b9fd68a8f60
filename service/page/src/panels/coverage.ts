// Coverage: how well the calibration explains the readings, and where around the base that has been seen.
import { Card } from '../ui/card';
import { Drawing, fontOf, viridis, type Theme } from '../ui/theme';
import { CoverageMap, kRings, placeWords } from './coveragemap';
import type { Field } from './coveragemap';
import { make, makeButton, setText } from '../ui/dom';
import { fixed } from '../ui/format';
import type { PageState, Panel } from './state';
import type { Live } from '../types';

const kEvery = 3; // updates
const kLeast = 0.5; // residuals of the colours' two ends
const kMost = 8;
const kLabels = [0.5, 1, 2, 4, 8];

function shareOf(residual: number): number {
  return Math.log(residual / kLeast) / Math.log(kMost / kLeast);
}

export class CoveragePanel implements Panel {
  readonly root: HTMLElement;
  readonly card = new Card({ id: 'coverage', title: 'Coverage', open: 'roomy' });
  private readonly map = new CoverageMap();
  private readonly drawing = new Drawing('coverage-map');
  private readonly scale = new Drawing('coverage-scale');
  private readonly text = make('p', { 'data-testid': 'coverage' });
  private updates = 0;

  constructor(private readonly theme: Theme) {
    this.root = this.card.root;
    this.drawing.root.classList.add('sphere');
    this.scale.root.classList.add('colour-scale');
    this.scale.describe('Colours: from dark for a residual of a half and less, to yellow for eight and more.');
    const words = 'From above. Colour: how far readings are from the calibration; 1 is what noise alone makes.';
    const about = make('p', { class: 'muted' }, words);
    const reset = makeButton('Start again', () => {
      this.map.clear();
      this.updates = 0;
    });
    this.card.body.append(about, this.drawing.root, this.scale.root, this.text);
    this.card.body.append(make('div', { class: 'buttons' }, reset));
    theme.listen(() => {
      this.updates = 0;
    });
  }

  // Every tracked sample; of what is live, never of a replay.
  add(live: Live, state: PageState): void {
    if (state.signals.flag(live, 'tracked') === false) return;
    const hasDof = state.signals.index('fit_dof') >= 0;
    for (let i = 0; i < live.count; ++i) {
      const tip = state.signals.tip(live, i);
      const chi2 = state.signals.at(live, 'fit_chi2', i);
      const dof = hasDof ? state.signals.at(live, 'fit_dof', i) : 1; // without it, the service has divided already
      if (Number.isFinite(tip[0])) this.map.add(tip, dof > 0 ? chi2 / dof : NaN);
    }
  }

  update(state: PageState): void {
    if (this.updates++ % kEvery !== 0) return;
    const { covered, mean, worst } = this.map.summary();
    const percent = Math.round(100 * covered);
    this.card.setNote(`${percent} %`);
    if (!this.card.open) return;
    let words = `${percent} % of the upper half sphere has been reached.`;
    if (worst !== null) {
      words += ` Mean residual ${fixed(mean, 2)}; largest ${fixed(worst.residual, 2)}, ${placeWords(worst)}.`;
    }
    setText(this.text, words);
    this.drawing.describe(`Map of the half sphere around the base, from above. ${words}`);
    const tip = state.live === null ? null : this.map.at(state.signals.tip(state.live));
    this.drawing.draw((context, width, height) => this.paint(context, width, height, tip));
    this.scale.draw((context, width, height) => this.paintScale(context, width, height));
  }

  private paint(context: CanvasRenderingContext2D, width: number, height: number, here: Field | null): void {
    const text = 0.6875 * parseFloat(getComputedStyle(document.documentElement).fontSize);
    const radius = Math.min(width / 2, height / 2) - 1.6 * text;
    // Equal areas stay equal (Lambert): the radius of an elevation is sqrt(1 - sin).
    const radiusOf = (ring: number): number => radius * Math.sqrt(1 - Math.sin((ring / kRings) * (Math.PI / 2)));
    const outline = (field: Field): void => {
      const [from, to] = [field.index, field.index + 1].map((i) => (-i / field.of) * 2 * Math.PI); // canvas: y down
      context.beginPath();
      context.arc(width / 2, height / 2, radiusOf(field.ring), from ?? 0, to ?? 0, true);
      context.arc(width / 2, height / 2, radiusOf(field.ring + 1), to ?? 0, from ?? 0, false);
      context.closePath();
    };
    context.lineWidth = 1;
    for (const field of this.map.fields) {
      outline(field);
      if (field.samples > 0) {
        const known = !Number.isNaN(field.residual);
        context.fillStyle = known ? viridis(shareOf(field.residual)) : this.theme.colour('muted');
        context.fill();
      }
      context.strokeStyle = this.theme.colour(field.samples > 0 ? 'panel' : 'grid');
      context.stroke();
    }
    if (here !== null) {
      outline(here);
      context.lineWidth = 2.5;
      context.strokeStyle = this.theme.colour('text');
      context.stroke();
    }
    this.paintSides(context, width, height, radius + 0.8 * text);
  }

  private paintSides(context: CanvasRenderingContext2D, width: number, height: number, at: number): void {
    context.fillStyle = this.theme.colour('muted');
    context.font = fontOf(0.6875);
    context.textAlign = 'center';
    context.textBaseline = 'middle';
    context.fillText('back', width / 2, height / 2 - at);
    context.fillText('you', width / 2, height / 2 + at);
    context.textAlign = 'right';
    context.fillText('left', width / 2 - at + 4, height / 2);
    context.textAlign = 'left';
    context.fillText('right', width / 2 + at - 4, height / 2);
  }

  private paintScale(context: CanvasRenderingContext2D, width: number, height: number): void {
    const bar = height * 0.4;
    for (let x = 0; x < width; ++x) {
      context.fillStyle = viridis(x / (width - 1));
      context.fillRect(x, 0, 1, bar);
    }
    context.fillStyle = this.theme.colour('muted');
    context.font = fontOf(0.6875);
    context.textBaseline = 'bottom';
    for (const label of kLabels) {
      const share = shareOf(label);
      context.textAlign = share <= 0 ? 'left' : share >= 1 ? 'right' : 'center';
      context.fillText(share >= 1 ? `${label} and more` : `${label}`, share * width, height);
    }
  }
}
