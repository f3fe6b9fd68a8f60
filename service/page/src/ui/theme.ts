// Colours of the page, and canvases that are drawn in them: CSS cannot reach those.
import { make, makeButton, recall, remember, setAttribute } from './dom';

type Choice = 'auto' | 'light' | 'dark';

const kNext: Record<Choice, Choice> = { auto: 'light', light: 'dark', dark: 'auto' };
const kWords: Record<Choice, string> = { auto: 'Auto', light: 'Light', dark: 'Dark' };

// Light or dark: as the system says, until the person chooses.
export class Theme {
  readonly button: HTMLButtonElement;
  private choice: Choice;
  private readonly system = matchMedia('(prefers-color-scheme: dark)');
  private readonly listeners: ((dark: boolean) => void)[] = [];

  constructor() {
    const kept = recall('theme');
    this.choice = kept === 'light' || kept === 'dark' ? kept : 'auto';
    this.button = makeButton('', () => this.next(), { class: 'button quiet theme' });
    this.system.addEventListener('change', () => this.apply());
    this.apply();
  }

  get dark(): boolean {
    return this.choice === 'auto' ? this.system.matches : this.choice === 'dark';
  }

  // Called now and at every change.
  listen(listener: (dark: boolean) => void): void {
    this.listeners.push(listener);
    listener(this.dark);
  }

  // A colour of style.css by its name: "muted" for --muted.
  colour(name: string): string {
    return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
  }

  private next(): void {
    this.choice = kNext[this.choice];
    remember('theme', this.choice);
    this.apply();
  }

  private apply(): void {
    document.documentElement.dataset['theme'] = this.dark ? 'dark' : 'light';
    this.button.textContent = kWords[this.choice];
    this.button.setAttribute('aria-label', `Colours: ${kWords[this.choice]}. Press for ${kWords[kNext[this.choice]]}.`);
    this.button.title = `Colours: ${kWords[this.choice].toLowerCase()}`;
    for (const listener of this.listeners) listener(this.dark);
  }
}

// A small drawing that fits its element, sharp on every screen.
export class Drawing {
  readonly root: HTMLElement;
  private readonly canvas = make('canvas');
  private readonly context = this.canvas.getContext('2d');

  constructor(testId: string) {
    this.root = make('div', { class: 'drawing', role: 'img', 'data-testid': testId }, this.canvas);
  }

  // What it shows, for those who do not see it.
  describe(text: string): void {
    setAttribute(this.root, 'aria-label', text);
  }

  // Calls `paint` with a cleared context in CSS pixels; not while it has no size.
  draw(paint: (context: CanvasRenderingContext2D, width: number, height: number) => void): void {
    const { clientWidth, clientHeight } = this.root;
    if (this.context === null || clientWidth === 0 || clientHeight === 0) return;
    const ratio = devicePixelRatio || 1;
    const width = Math.round(clientWidth * ratio);
    const height = Math.round(clientHeight * ratio);
    if (this.canvas.width !== width) this.canvas.width = width;
    if (this.canvas.height !== height) this.canvas.height = height;
    this.context.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.context.clearRect(0, 0, clientWidth, clientHeight);
    paint(this.context, clientWidth, clientHeight);
  }
}

// The page's text size times `size`, for text in drawings.
export function fontOf(size: number): string {
  const px = parseFloat(getComputedStyle(document.documentElement).fontSize) * size;
  return `${px.toFixed(1)}px system-ui, sans-serif`;
}

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

// Viridis, as a few points of it: even in brightness, and clear with every kind of colour vision.
// share: 0 ... 1
export function viridis(share: number): string {
  const at = Math.min(1, Math.max(0, share)) * (kViridis.length - 1);
  const low = Math.min(kViridis.length - 2, Math.floor(at));
  const [a, b] = [kViridis[low], kViridis[low + 1]];
  if (a === undefined || b === undefined) return 'rgb(0, 0, 0)';
  const mix = a.map((from, i) => Math.round(from + ((b[i] ?? from) - from) * (at - low)));
  return `rgb(${mix.join(', ')})`;
}
