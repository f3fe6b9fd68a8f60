// What there is to touch: scenes to choose from, and the person's own models.
import { Card } from '../ui/card';
import { make, makeButton, setAttribute, setHidden, setText } from '../ui/dom';
import type { DropTarget } from './drop';
import { size } from '../ui/format';
import { canControl } from './state';
import type { Actions, PageState, Panel } from './state';
import type { SceneChoice } from '../types';

const kStates = { none: 'no scene', loading: 'loading', ready: 'ready', failed: 'failed' };

export class ScenesPanel implements Panel {
  readonly root: HTMLElement;
  private readonly card = new Card({ id: 'scenes', title: 'Scenes', important: true });
  private readonly state = make('span', { 'data-testid': 'scene-state' }, kStates.none);
  private readonly text = make('p', { class: 'scene-text' });
  private readonly choices = make('div', { class: 'scene-choices' });
  private readonly file = make('input', { type: 'file', accept: '.glb,model/gltf-binary', hidden: true });
  private readonly open: HTMLButtonElement;
  private readonly limit = make('span', { class: 'muted' });
  private readonly own: HTMLElement;
  private readonly buttons = new Map<string, HTMLButtonElement>();
  private shown = ''; // the choices that have buttons

  constructor(
    private readonly actions: Actions,
    drop: DropTarget,
  ) {
    this.root = this.card.root;
    this.open = makeButton('Open a file …', () => this.file.click());
    this.file.addEventListener('change', () => {
      void drop.load([...(this.file.files ?? [])]);
      this.file.value = ''; // the same file can be chosen again
    });
    const words = make('p', {}, 'Drop a .glb anywhere on the page, or');
    this.own = make('div', { class: 'drop-zone' }, words, this.open, this.limit, this.file);
    const line = make('p', { class: 'scene-line', role: 'status' }, 'Now: ', this.state);
    this.card.body.append(line, this.text, this.choices, this.own);
  }

  update(state: PageState): void {
    const { hello, scene } = state;
    setHidden(this.root, hello.scenes.length === 0 && scene === null);
    const name = scene?.name ?? '';
    const words = scene === null ? kStates.none : kStates[scene.state];
    setText(this.state, name === '' || scene?.state === 'none' ? words : `${name}, ${words}`);
    setAttribute(this.state, 'data-state', scene?.state ?? 'none');
    this.card.setNote(scene?.state === 'ready' ? name : words);
    setText(this.text, scene?.text ?? '');
    setHidden(this.text, (scene?.text ?? '') === '');
    setHidden(this.own, !hello.hand);
    setText(this.limit, `at most ${size(hello.max_file_bytes)}`);
    this.writeChoices(hello.scenes, stem(name), scene?.state === 'loading');
    const disabled = !canControl(state) || !hello.hand;
    for (const button of [...this.buttons.values(), this.open]) {
      if (button.disabled !== disabled) button.disabled = disabled;
    }
  }

  private writeChoices(scenes: SceneChoice[], current: string, loading: boolean): void {
    const key = scenes.map((choice) => choice.name).join('\n');
    if (key !== this.shown) {
      this.shown = key;
      this.buttons.clear();
      this.choices.replaceChildren(...scenes.map((choice) => this.makeChoice(choice)));
    }
    for (const [name, button] of this.buttons) {
      setAttribute(button, 'aria-pressed', String(name === current));
      setAttribute(button, 'data-loading', String(name === current && loading));
    }
  }

  private makeChoice(choice: SceneChoice): HTMLElement {
    const press = (): void => {
      if (!this.actions.send({ type: 'scene', name: choice.name })) {
        this.actions.notify('error', `${choice.title} was not loaded: there is no connection.`);
      }
    };
    const button = makeButton('', press, { class: 'scene-choice', pressed: false });
    button.dataset['testid'] = `scene-${choice.name}`;
    const about = make('span', { class: 'scene-about' }, choice.about);
    button.append(make('strong', {}, choice.title), about);
    this.buttons.set(choice.name, button);
    return button;
  }
}

function stem(name: string): string {
  return name.replace(/^.*\//, '').replace(/\.glb$/i, '');
}
