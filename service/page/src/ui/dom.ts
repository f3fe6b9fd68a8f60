// Elements without a framework: made once, and written to only where something has changed, so that sixty messages a
// second cost no layout. Text is always a text node: names come from foreign files.

export interface Attributes {
  [name: string]: string | number | boolean | undefined;
}

type Child = Node | string | null | undefined;

// An element with attributes and children. false and undefined leave an attribute out, true makes it empty.
export function make<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  attributes: Attributes = {},
  ...children: Child[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value !== undefined && value !== false) element.setAttribute(name, value === true ? '' : String(value));
  }
  for (const child of children) if (child !== null && child !== undefined) element.append(child);
  return element;
}

export interface ButtonOptions {
  class?: string;
  title?: string;
  id?: string;
  pressed?: boolean; // makes it a toggle
}

export function makeButton(text: string, press: () => void, options: ButtonOptions = {}): HTMLButtonElement {
  const button = make(
    'button',
    {
      type: 'button',
      class: options.class ?? 'button',
      title: options.title,
      id: options.id,
      'aria-pressed': options.pressed === undefined ? undefined : String(options.pressed),
    },
    text,
  );
  button.addEventListener('click', press);
  return button;
}

// The element's whole text. The text node stays, so that a selection survives.
export function setText(element: Element, text: string): void {
  const first = element.firstChild;
  if (first instanceof Text && first.nextSibling === null) {
    if (first.data !== text) first.data = text;
  } else {
    element.textContent = text;
  }
}

export function setAttribute(element: Element, name: string, value: string): void {
  if (element.getAttribute(name) !== value) element.setAttribute(name, value);
}

export function setHidden(element: HTMLElement, hidden: boolean): void {
  if (element.hidden !== hidden) element.hidden = hidden;
}

export function setPressed(button: HTMLButtonElement, pressed: boolean): void {
  setAttribute(button, 'aria-pressed', String(pressed));
}

// A list whose elements live as long as their key: rows neither flicker nor are read out twice.
export class KeyedList<Item> {
  private readonly rows = new Map<string, HTMLElement>();
  constructor(
    readonly root: HTMLElement,
    private readonly create: (item: Item) => HTMLElement,
    private readonly write: (element: HTMLElement, item: Item) => void,
  ) {}

  update(items: Item[], keyOf: (item: Item) => string): void {
    const wanted = new Set(items.map(keyOf));
    for (const [key, row] of this.rows) {
      if (wanted.has(key)) continue;
      row.remove();
      this.rows.delete(key);
    }
    let before: Element | null = this.root.firstElementChild;
    for (const item of items) {
      const key = keyOf(item);
      let row = this.rows.get(key);
      if (row === undefined) {
        row = this.create(item);
        this.rows.set(key, row);
      }
      this.write(row, item);
      if (row === before) before = before.nextElementSibling;
      else this.root.insertBefore(row, before);
    }
  }
}

// Copies an element's text, else selects it. Returns what the person is to read.
export async function copyText(element: Element): Promise<string> {
  try {
    await navigator.clipboard.writeText(`${element.textContent ?? ''}\n`);
    return 'Copied.';
  } catch {
    getSelection()?.selectAllChildren(element);
    return 'The browser does not allow it; the text is selected: press Ctrl+C.';
  }
}

// A file that the person wants, without a server: through a blob URL.
export function download(name: string, blob: Blob): void {
  const url = URL.createObjectURL(blob);
  const link = make('a', { href: url, download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(url), 60_000);
}

const kPrefix = 'omni.';

// What the page remembers until next time. Browsers may refuse storage: then it forgets, and works all the same.
export function recall(key: string): string | null {
  try {
    return localStorage.getItem(kPrefix + key);
  } catch {
    return null;
  }
}

export function remember(key: string, value: string): void {
  try {
    localStorage.setItem(kPrefix + key, value);
  } catch {
    // refused or full
  }
}
