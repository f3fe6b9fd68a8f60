// Now: what is going on, in plain words and a few numbers.
import { Card } from '../ui/card';
import { make, setAttribute, setHidden, setText } from '../ui/dom';
import { fixed, mm, plural } from '../ui/format';
import { length } from '../signals';
import type { PageState, Panel } from './state';
import { forceNote, owner, race, softBodies, touching, tracking } from './words';

// One line: what it is, its value, and a remark.
class Row {
  readonly root: HTMLElement;
  private readonly value: HTMLElement;
  private readonly note = make('span', { class: 'row-note' });

  constructor(name: string, testId: string, extra?: HTMLElement) {
    this.value = make('span', { class: 'row-value', 'data-testid': testId });
    this.root = make('div', { class: 'row' }, make('dt', {}, name), make('dd', {}, this.value, this.note, extra));
  }

  // null: nothing to be said, the row goes.
  set(value: string | null, note = ''): void {
    setHidden(this.root, value === null);
    if (value !== null) setText(this.value, value);
    setText(this.note, note);
  }
}

export class NowPanel implements Panel {
  readonly root: HTMLElement;
  private readonly card = new Card({ id: 'now', title: 'Now', important: true });
  private readonly line = make('p', { class: 'now-line', 'data-testid': 'tracked' });
  private readonly forceBar = make('span', { class: 'meter-fill' });
  private readonly softBar = make('progress', { max: 1, 'aria-label': 'soft body being computed' });
  private readonly touching = new Row('Touching', 'touching');
  private readonly force: Row;
  private readonly gap = new Row('Gap', 'gap');
  private readonly position = new Row('Tip at', 'position');
  private readonly sigma = new Row('Known to', 'sigma');
  private readonly owner = new Row('Used by', 'owner');
  private readonly soft: Row;
  private readonly dent = new Row('Dent', 'dent');
  private readonly strokes = new Row('Sculpted', 'strokes');
  private readonly laps = new Row('Laps', 'laps');
  private readonly speed = new Row('Car', 'speed');
  private readonly lapTimes = new Row('Lap times', 'lap-times');

  constructor() {
    this.root = this.card.root;
    this.force = new Row('Force', 'force', make('span', { class: 'meter', 'aria-hidden': 'true' }, this.forceBar));
    this.soft = new Row('Soft body', 'soft-body', this.softBar);
    const rows = [this.touching, this.force, this.gap, this.position, this.sigma, this.owner, this.soft, this.dent];
    rows.push(this.strokes, this.laps, this.speed, this.lapTimes);
    this.card.body.append(this.line, make('dl', { class: 'rows' }, ...rows.map((row) => row.root)));
  }

  update(state: PageState): void {
    const known = tracking(state);
    this.card.setNote(state.replay ? 'replay' : known.state);
    if (!this.card.open) return;
    setText(this.line, known.text);
    setAttribute(this.line, 'data-state', known.state);
    this.writePen(state);
    this.owner.set(state.replay ? null : owner(state));
    this.writeScene(state);
    this.writeRace(state);
  }

  private writePen(state: PageState): void {
    const { live, signals } = state;
    this.touching.set(touching(state));
    if (live === null) {
      for (const row of [this.force, this.gap, this.position, this.sigma]) row.set('-');
      return;
    }
    const force = length(signals.force(live));
    this.force.set(`${fixed(force, 2)} N`, forceNote(state));
    const share = Math.min(1, Math.max(0, force / state.hello.base.force_max_N || 0));
    this.forceBar.style.transform = `scaleX(${share.toFixed(3)})`;
    this.gap.set(mm(signals.newest(live, 'gap_m')));
    const [x, y, z] = signals.tip(live).map((value) => fixed(value * 1e3, 1));
    this.position.set(`x ${x}  y ${y}  z ${z} mm`);
    const sigma = signals.sigma(live);
    this.sigma.set(Number.isNaN(sigma) ? null : `± ${mm(sigma, 2)}`);
  }

  // In a replay, what is not recorded is left out.
  private writeScene(state: PageState): void {
    const soft = state.replay ? null : softBodies(state);
    this.soft.set(soft === null ? null : soft.text);
    setHidden(this.softBar, soft === null || soft.done >= 1);
    if (soft !== null) this.softBar.value = soft.done;
    this.dent.set(Number.isNaN(state.dent_m) ? null : mm(state.dent_m, 2));
    const strokes = state.replay ? -1 : (state.status?.strokes ?? -1);
    this.strokes.set(strokes < 0 ? null : plural(strokes, 'stroke'));
  }

  private writeRace(state: PageState): void {
    const car = race(state);
    this.laps.set(car === null ? null : String(car.laps), car === null ? '' : plural(car.hits, 'hit'));
    this.speed.set(car === null ? null : car.speed);
    this.lapTimes.set(car === null ? null : car.laps_s);
  }
}
