// What the marks mean, in a corner over the picture, in words and with a sample of each colour.
import type { Color } from 'three';
import { kArrowPerNewton } from './forces';
import type { Palette } from './palette';
import { kSigmas, kUncertaintyScale } from './uncertainty';

const kNarrow = 480; // pixels

export class Caption {
  readonly element = document.createElement('div');
  private readonly uncertainty: HTMLElement;
  private readonly samples: { dot: HTMLElement; colour: (palette: Palette) => Color }[] = [];

  constructor() {
    const style = this.element.style;
    style.position = 'absolute';
    style.right = '10px';
    style.bottom = '10px';
    style.maxWidth = 'calc(100% - 110px)'; // leaves the other corner to others
    style.boxSizing = 'border-box';
    style.padding = '3px 10px';
    style.borderRadius = '9px';
    style.display = 'flex';
    style.flexWrap = 'wrap';
    style.justifyContent = 'flex-end';
    style.gap = '1px 14px';
    style.font = '500 11px/1.5 system-ui, -apple-system, "Segoe UI", sans-serif';
    style.pointerEvents = 'none';
    style.userSelect = 'none';
    style.visibility = 'hidden';
    this.add(`force, ${1000 * kArrowPerNewton} mm per N`, (palette) => palette.force);
    this.uncertainty = this.add(`uncertainty, ${kSigmas}σ, ×${kUncertaintyScale}`, (palette) => palette.accent);
    this.add("the hand's aim", (palette) => palette.hand).hidden = true;
  }

  // For a visitor: only force and hand.
  setVisitor(on: boolean): void {
    this.uncertainty.hidden = on;
  }

  // Without a pen there is nothing to explain.
  show(pen: boolean, hand: boolean): void {
    this.element.style.visibility = pen ? 'visible' : 'hidden';
    (this.element.lastElementChild as HTMLElement).hidden = !hand;
  }

  // One below the other where there is little room.
  setWidth(width: number): void {
    this.element.style.flexDirection = width < kNarrow ? 'column' : 'row';
  }

  setPalette(palette: Palette): void {
    this.element.style.color = `#${palette.label.getHexString()}`;
    this.element.style.backgroundColor = `#${palette.desk.getHexString()}c0`; // readable over anything
    for (const { dot, colour } of this.samples) dot.style.background = `#${colour(palette).getHexString()}`;
  }

  private add(text: string, colour: (palette: Palette) => Color): HTMLElement {
    const item = document.createElement('span');
    const dot = document.createElement('span');
    dot.style.display = 'inline-block';
    dot.style.width = '8px';
    dot.style.height = '8px';
    dot.style.borderRadius = '50%';
    dot.style.marginRight = '6px';
    item.append(dot, text);
    this.samples.push({ dot, colour });
    this.element.append(item);
    return item;
  }
}
