// Small panels: keys of the hand, what makes an application use the pen, the pen's inputs, the steps of a set-up.
import type { SetupStep } from '../types';
import { Card } from '../ui/card';
import { copyText, KeyedList, make, makeButton, setAttribute, setHidden, setText } from '../ui/dom';
import { fixed } from '../ui/format';
import type { Actions, PageState, Panel } from './state';
import { kStopKey } from './stop';

const kFirstKeys = 4; // that are always shown

// How the hand is led, and a button that takes the pen away.
export class HandPanel implements Panel {
  readonly root: HTMLElement;
  private readonly card = new Card({ id: 'hand', title: 'Lead the pen' });
  private readonly lift: HTMLButtonElement;

  constructor(help: { keys: string; does: string }[], lift: () => void) {
    this.root = this.card.root;
    this.lift = makeButton('Take the pen away', lift, { id: 'lift' });
    const more = make('details', { class: 'more' }, make('summary', {}, 'All keys and gestures'));
    more.append(keyList([...help.slice(kFirstKeys), { keys: kStopKey, does: 'emergency stop' }]));
    this.card.body.append(keyList(help.slice(0, kFirstKeys)), more, make('div', { class: 'buttons' }, this.lift));
  }

  update(state: PageState): void {
    setHidden(this.root, !state.hello.hand);
    this.lift.disabled = state.replay || state.link.kind !== 'open';
  }
}

function keyList(help: { keys: string; does: string }[]): HTMLElement {
  const rows = help.map(({ keys, does }) =>
    make('div', { class: 'key-row' }, make('dt', {}, make('kbd', {}, keys)), make('dd', {}, does)),
  );
  return make('dl', { class: 'keys' }, ...rows);
}

// The shell lines that give an OpenXR application the pen.
export class EnvironmentPanel implements Panel {
  readonly root: HTMLElement;
  readonly card = new Card({ id: 'environment', title: 'Use it with an application', open: 'roomy' });
  private readonly lines = make('pre', { class: 'environment', tabindex: 0, role: 'region' });
  private readonly copy: HTMLButtonElement;

  constructor(actions: Actions) {
    this.root = this.card.root;
    this.lines.setAttribute('aria-label', 'Lines for a shell');
    this.lines.dataset['testid'] = 'environment';
    this.copy = makeButton('Copy', () => void copyText(this.lines).then((text) => actions.notify('info', text)));
    const about = make('p', {}, 'Paste this into a terminal, and start your OpenXR application there:');
    this.card.body.append(about, this.lines, make('div', { class: 'buttons' }, this.copy));
  }

  update(state: PageState): void {
    const lines = state.hello.environment;
    setHidden(this.root, lines.length === 0);
    setText(this.lines, lines.join('\n'));
  }
}

const kInputs = ['tip force', 'select', 'secondary', 'menu', 'squeeze', 'stick x', 'stick y', 'stick click', 'docked'];

// The pen's nine inputs, as applications see them.
export class InputsPanel implements Panel {
  readonly root: HTMLElement;
  readonly card = new Card({ id: 'inputs', title: 'Inputs', open: 'roomy' });
  private readonly rows: { bar: HTMLElement; value: HTMLElement; presses: HTMLElement }[] = [];

  constructor() {
    this.root = this.card.root;
    const head = make(
      'tr',
      {},
      make('th', { scope: 'col' }, 'Input'),
      make('th', { scope: 'col', colspan: 2 }, 'Value'),
      make('th', { scope: 'col', class: 'number' }, 'Presses'),
    );
    const caption = make('caption', { class: 'unseen' }, 'The nine inputs of the pen');
    const body = make('tbody');
    for (const name of kInputs) {
      const bar = make('span', { class: 'meter-fill' });
      const value = make('td', { class: 'number', 'data-testid': `input-${name.replace(' ', '-')}` });
      const presses = make('td', { class: 'number' });
      const meter = make('td', { 'aria-hidden': 'true' }, make('span', { class: 'meter signed' }, bar));
      body.append(make('tr', {}, make('th', { scope: 'row' }, name), value, meter, presses));
      this.rows.push({ bar, value, presses });
    }
    this.card.body.append(make('table', { class: 'inputs' }, caption, make('thead', {}, head), body));
  }

  update(state: PageState): void {
    if (!this.card.open) return;
    this.rows.forEach((row, index) => {
      const input = state.live?.inputs[index];
      const value = input?.value ?? NaN;
      setText(row.value, fixed(value, 2));
      setText(row.presses, input === undefined ? '-' : String(input.presses));
      const shown = Number.isFinite(value) ? Math.min(1, Math.max(-1, value)) : 0;
      row.bar.style.transform = `scaleX(${shown.toFixed(3)})`; // from the middle, to both sides
    });
  }
}

const kStates = { done: 'Done', open: 'To do', unknown: 'Not recorded' };

// The steps that set a base up, as `omni setup` goes through them, and which are done.
export class SetupPanel implements Panel {
  readonly root: HTMLElement;
  readonly card = new Card({ id: 'setup', title: 'Set up a base', open: 'roomy' });
  private readonly list: KeyedList<SetupStep>;

  constructor(private readonly actions: Actions) {
    this.root = this.card.root;
    const about = make(
      'p',
      {},
      make('code', {}, 'omni setup'),
      ' in a terminal goes through all steps; with ',
      make('code', {}, '--rehearse'),
      ' it needs no base.',
    );
    const items = make('ol', { class: 'setup-steps', 'data-testid': 'setup-steps' });
    this.list = new KeyedList<SetupStep>(items, (step) => this.makeRow(step), writeRow);
    this.card.body.append(about, items);
  }

  update(state: PageState): void {
    const steps = state.setup?.steps ?? [];
    setHidden(this.root, steps.length === 0);
    const known = steps.filter((step) => step.state !== 'unknown');
    const done = known.filter((step) => step.state === 'done').length;
    this.card.setNote(steps.length === 0 ? '' : `${done} of ${known.length} done`);
    if (this.card.open) this.list.update(steps, (step) => step.name);
  }

  private makeRow(step: SetupStep): HTMLElement {
    const head = make('span', { class: 'setup-head' }, make('span', { class: 'setup-title' }, step.title));
    head.append(make('span', { class: 'setup-state' }));
    const code = make('code', {}, step.command);
    const copy = makeButton('Copy', () => void copyText(code).then((text) => this.actions.notify('info', text)));
    copy.setAttribute('aria-label', `Copy ${step.command}`);
    const command = make('span', { class: 'setup-command' }, code, copy);
    const about = make('span', { class: 'setup-about' }, `${step.about} It takes ${step.takes}.`);
    return make('li', { class: 'setup-step' }, head, about, make('span', { class: 'setup-text' }), command);
  }
}

function writeRow(row: HTMLElement, step: SetupStep): void {
  setAttribute(row, 'data-state', step.state);
  const [state, text] = ['.setup-state', '.setup-text'].map((name) => row.querySelector(name));
  if (state) setText(state, kStates[step.state]);
  if (text) setText(text, step.text);
}
