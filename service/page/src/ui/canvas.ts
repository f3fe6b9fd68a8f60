// A small drawing that fits its element, sharp on every screen.
import { make, setAttribute } from './dom';

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
