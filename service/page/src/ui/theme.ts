// Light or dark: as the system says, until the person chooses. Canvases ask for colours here, as CSS cannot reach them.
import { makeButton } from './dom';
import { recall, remember } from './memory';

type Choice = 'auto' | 'light' | 'dark';

const kNext: Record<Choice, Choice> = { auto: 'light', light: 'dark', dark: 'auto' };
const kWords: Record<Choice, string> = { auto: 'Auto', light: 'Light', dark: 'Dark' };

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
