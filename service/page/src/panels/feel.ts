// Feel: what the materials of the person's own scene are like, changed while they are touched; undo and redo of what
// was sculpted; and a copy of it all as a file.
import { Card } from '../ui/card';
import { make, makeButton, setHidden, setText } from '../ui/dom';
import { FieldSlider } from '../ui/slider';
import { canControl, statusOf } from './state';
import type { Actions, PageState, Panel } from './state';
import type { AnswerMessage, FileBytes, Hello, SceneMessage } from '../types';

const kOwn_ms = 700; // what was just entered here outlives older values that are still on their way
const kLoadFirst = 'Load a scene here to change how it feels.';

type Material = SceneMessage['materials'][number];

export class FeelPanel implements Panel {
  readonly root: HTMLElement;
  readonly card = new Card({ id: 'feel', title: 'Feel' });
  private readonly select = make('select', { id: 'material', 'data-testid': 'material' });
  private readonly touched = make('p', { class: 'muted' });
  private readonly fields = make('fieldset', { class: 'fields', 'aria-label': 'Values of the material' });
  private readonly note = make('p', { class: 'muted' }, kLoadFirst);
  private readonly sliders = new Map<string, FieldSlider>();
  private readonly undo: HTMLButtonElement;
  private readonly redo: HTMLButtonElement;
  private readonly release: HTMLButtonElement;
  private readonly save: HTMLButtonElement;
  private readonly chooser: HTMLElement;
  private readonly strokes: HTMLElement;
  private hello: Hello | null = null;
  private scene: SceneMessage | null = null;
  private first = new Map<string, number>(); // "index key" -> value as loaded
  private firstOf = -1; // number of that scene
  private pending = new Map<number, Record<string, number>>(); // not yet sent, by material
  private entered = new Map<string, { value: number; at_ms: number }>(); // here, lately, by "index key"
  private frame = 0;
  private settle = 0; // timer
  private saves = 0;
  private saving = 0; // number of the request that is not answered yet; 0: none

  constructor(private readonly actions: Actions) {
    this.root = this.card.root;
    this.undo = makeButton('Undo', () => this.actions.send({ type: 'undo' }), { id: 'undo' });
    this.redo = makeButton('Redo', () => this.actions.send({ type: 'redo' }), { id: 'redo' });
    this.release = makeButton('Let go', () => this.actions.send({ type: 'release' }), {
      id: 'release',
      title: 'Let go of the clay that the pen holds',
    });
    this.save = makeButton('Save a copy as .glb', () => this.requestFile(), { id: 'save' });
    this.select.addEventListener('change', () => this.showMaterial());
    this.chooser = make('div', { class: 'chooser' }, make('label', { for: 'material' }, 'Material'), this.select);
    this.strokes = make('div', { class: 'buttons' }, this.undo, this.redo, this.release);
    this.card.body.append(this.note, this.chooser, this.touched, this.fields, this.strokes);
    this.card.body.append(make('div', { class: 'buttons' }, this.save));
  }

  setScene(hello: Hello, scene: SceneMessage): void {
    const before = this.scene;
    this.hello = hello;
    this.scene = scene;
    if (scene.number !== this.firstOf) {
      this.firstOf = scene.number;
      this.first.clear();
      this.pending.clear();
      this.entered.clear();
    }
    for (const material of scene.materials) {
      for (const [key, value] of Object.entries(material.values)) {
        const name = `${material.index} ${key}`;
        if (!this.first.has(name)) this.first.set(name, value);
      }
    }
    const same = before?.number === scene.number && before.materials.length === scene.materials.length;
    if (!same) this.fillSelect();
    this.showMaterial();
  }

  update(state: PageState): void {
    const { hello, scene } = state;
    setHidden(this.root, !hello.control || hello.material_fields.length === 0);
    if (this.root.hidden) return;
    const own = scene?.own === true && scene.state === 'ready';
    const any = own && scene.materials.length > 0;
    setHidden(this.note, any);
    setText(this.note, own ? 'This scene has no material that can be changed.' : kLoadFirst);
    setHidden(this.chooser, !any);
    setHidden(this.fields, !any);
    setHidden(this.strokes, !(own && (statusOf(state)?.scene?.sculpted ?? 0) > 0));
    setHidden(this.save, !own);
    for (const button of [this.undo, this.redo, this.release]) button.disabled = !canControl(state);
    this.fields.disabled = !canControl(state);
    this.save.disabled = !canControl(state) || this.saving !== 0;
    if (!canControl(state)) this.saving = 0; // no answer will come
    setText(this.save, this.saving !== 0 ? 'Saving …' : 'Save a copy as .glb');
    this.writeTouched(state);
  }

  // Done or not; the file itself follows.
  answer(message: AnswerMessage): void {
    if (message.number !== this.saving) return;
    if (!message.done) this.saving = 0;
    if (!message.done) this.actions.notify('error', `Not saved: ${message.text}`);
  }

  // Whether it is the one that was requested here.
  takes(file: FileBytes): boolean {
    if (file.number !== this.saving) return false;
    this.saving = 0;
    return true;
  }

  private requestFile(): void {
    const number = ++this.saves;
    if (this.actions.send({ type: 'save', number })) this.saving = number;
    else this.actions.notify('error', 'Not saved: there is no connection.');
  }

  private get material(): Material | undefined {
    return this.scene?.materials.find((material) => String(material.index) === this.select.value);
  }

  private fillSelect(): void {
    const chosen = this.select.value;
    const materials = this.scene?.materials ?? [];
    this.select.replaceChildren(
      ...materials.map((material) => {
        const name = material.name || `material ${material.index}`;
        return make('option', { value: material.index }, name);
      }),
    );
    if (materials.some((material) => String(material.index) === chosen)) this.select.value = chosen;
    this.sliders.clear();
    this.fields.replaceChildren();
  }

  // The sliders of the chosen material; they stay while they are the same fields.
  private showMaterial(): void {
    const material = this.material;
    if (material === undefined || this.hello === null) return;
    const fields = this.hello.material_fields.filter((field) => field.key in material.values);
    const same = fields.length === this.sliders.size && fields.every((field) => this.sliders.has(field.key));
    if (!same) {
      this.sliders.clear();
      for (const field of fields) {
        this.sliders.set(field.key, new FieldSlider(field, (value) => this.change(field.key, value)));
      }
      this.fields.replaceChildren(...[...this.sliders.values()].map((slider) => slider.root));
    }
    for (const [key, slider] of this.sliders) {
      const name = `${material.index} ${key}`;
      const own = this.entered.get(name);
      const reported = material.values[key] ?? 0;
      const value = own !== undefined && performance.now() - own.at_ms < kOwn_ms ? own.value : reported;
      slider.set(value, this.first.get(name) ?? reported);
    }
  }

  // Sent once a frame at most, however fast the slider is moved.
  private change(key: string, value: number): void {
    const material = this.material;
    if (material === undefined) return;
    material.values[key] = value;
    this.entered.set(`${material.index} ${key}`, { value, at_ms: performance.now() });
    this.pending.set(material.index, { ...this.pending.get(material.index), [key]: value });
    clearTimeout(this.settle);
    this.settle = window.setTimeout(() => this.showMaterial(), kOwn_ms + 1); // then what the service made of it
    if (this.frame !== 0) return;
    this.frame = requestAnimationFrame(() => {
      this.frame = 0;
      for (const [index, values] of this.pending) this.actions.send({ type: 'material', index, values });
      this.pending.clear();
    });
  }

  private writeTouched(state: PageState): void {
    const index = state.live?.contacts[0]?.material;
    const name = this.scene?.materials.find((material) => material.index === index)?.name;
    setHidden(this.touched, name === undefined || this.chooser.hidden !== false);
    setText(this.touched, name === undefined ? '' : `Touched now: ${name}`);
  }
}
