// The steps that set a base up, as `omni setup` goes through them, and which are done.
import { Card } from '../ui/card';
import { KeyedList, copyText, make, makeButton, setAttribute, setHidden, setText } from '../ui/dom';
import type { Actions, PageState, Panel } from './state';
import type { SetupStep } from '../types';

const kStates = { done: 'Done', open: 'To do', unknown: 'Not recorded' };

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
