// Record and replay: the bar below the view. The newest minutes are always kept; what is shown is either live or, with
// a badge that cannot be missed, a replay.
import type { Recorder } from '../record/recorder';
import { download, make, makeButton, setAttribute, setHidden, setPressed, setText } from '../ui/dom';
import { clock, size } from '../ui/format';
import { stamp } from './stage';
import type { Actions } from './state';

const kSpeeds = [0.25, 1];
const kSure_ms = 4000;

interface Span {
  from_s: number;
  to_s: number;
}

export class ReplayBar {
  readonly root: HTMLElement;
  private readonly record: HTMLButtonElement;
  private readonly recorded = make('span', { class: 'record-size', 'data-testid': 'recorded' });
  private readonly live: HTMLButtonElement;
  private readonly replay: HTMLButtonElement;
  private readonly play: HTMLButtonElement;
  private readonly speed = make('select', { id: 'speed', 'aria-label': 'Speed of the replay' });
  private readonly timeline: Timeline;
  private readonly time = make('span', { class: 'replay-time', 'data-testid': 'replay-time' });
  private readonly range = make('span', { class: 'replay-range', 'data-testid': 'replay-range' });
  private readonly surfaces = make('span', {
    class: 'replay-range',
    'data-testid': 'surfaces-kept',
    title: 'How far back soft, sculpted and moved surfaces are kept: older ones have made room for newer ones',
  });
  private readonly csv: HTMLButtonElement;
  private readonly mcap: HTMLButtonElement;
  private readonly whole: HTMLButtonElement;
  private readonly forget: HTMLButtonElement;
  private readonly playing: HTMLElement;
  private recorder: Recorder | null = null;
  private t_s = NaN; // that is replayed; NaN: live
  private end_s = NaN; // of the time line while it is replayed: it rests
  private runs = false;
  private chosen: Partial<Span> = {}; // by the person, for export
  private sure_ms = -Infinity; // until then a second press on "Clear" means it
  private shown = ''; // why a recording stopped itself, as shown last

  constructor(
    private readonly actions: Actions,
    private readonly changed: () => void, // live or replay
  ) {
    this.record = makeButton('Record', () => this.toggleRecording(), { class: 'button record', pressed: false });
    this.record.dataset['testid'] = 'record';
    this.live = makeButton('Live', () => this.goLive(), { pressed: true });
    this.replay = makeButton('Replay', () => this.enter(), { pressed: false });
    this.play = makeButton('Play', () => this.togglePlaying(), { class: 'button play', pressed: false });
    this.timeline = new Timeline((t_s) => this.scrub(t_s));
    this.csv = makeButton('CSV', () => void this.save('csv'), { title: 'Save the range as a table' });
    this.mcap = makeButton('MCAP', () => void this.save('mcap'), { title: 'Save the range for Foxglove and ROS' });
    this.forget = makeButton('Clear', () => this.clear(), { title: 'Forget everything that is kept' });
    const from = makeButton('Begin here', () => this.choose({ from_s: this.t_s }), { title: 'Save from here on' });
    const to = makeButton('End here', () => this.choose({ to_s: this.t_s }), { title: 'Save up to here' });
    this.whole = makeButton('Reset range', () => this.choose(null));
    this.speed.append(...kSpeeds.map((speed) => make('option', { value: speed }, `${speed} ×`)));
    this.speed.value = '1';
    const mode = make('span', { class: 'joined', role: 'group', 'aria-label': 'What is shown' });
    mode.append(this.live, this.replay);
    this.playing = make('span', { class: 'buttons', hidden: true }, this.play, this.speed, from, to);
    const files = make('span', { class: 'buttons files' }, this.range, this.surfaces, this.whole);
    files.append(this.csv, this.mcap, this.forget);
    const recording = make('span', { class: 'buttons' }, this.record, this.recorded);
    const line = make('span', { class: 'timeline-box' }, this.timeline.root, this.time);
    this.root = make('section', { class: 'replay-bar', 'aria-label': 'Record and replay' });
    this.root.append(recording, mode, line, this.playing, files);
  }

  setRecorder(recorder: Recorder): void {
    this.recorder = recorder;
    this.goLive();
  }

  // The time that is replayed; NaN: what is live.
  get shown_s(): number {
    return this.t_s;
  }

  // Once a frame.
  advance(elapsed_s: number): void {
    if (!this.runs || Number.isNaN(this.t_s)) return;
    this.t_s = Math.min(this.end_s, this.t_s + elapsed_s * Number(this.speed.value));
    if (this.t_s >= this.end_s) this.runs = false;
  }

  // Ten times a second.
  update(): void {
    const recorder = this.recorder;
    if (recorder === null) return;
    const replays = !Number.isNaN(this.t_s);
    // What is oldest goes while something is replayed.
    if (replays && !(this.t_s >= recorder.begin_s)) this.t_s = Math.min(this.end_s, recorder.begin_s);
    const end_s = replays ? this.end_s : recorder.end_s;
    const t_s = replays ? this.t_s : end_s;
    const span = this.span(recorder);
    this.timeline.update(recorder.begin_s, end_s, t_s, this.marks(recorder) ? span : null);
    setText(this.time, replays ? ago(end_s - t_s) : Number.isFinite(end_s) ? 'live' : '-');
    this.writeSurfaces(recorder, end_s);
    this.writeRecording(recorder);
    this.writeRange(recorder, span);
    setPressed(this.live, !replays);
    setPressed(this.replay, replays);
    setHidden(this.playing, !replays);
    setText(this.play, this.runs ? 'Pause' : 'Play');
    setPressed(this.play, this.runs);
    setText(this.forget, performance.now() < this.sure_ms ? 'Really clear?' : 'Clear');
    const empty = !(recorder.samples > 0);
    for (const button of [this.csv, this.mcap, this.replay]) if (button.disabled !== empty) button.disabled = empty;
  }

  // Only where they do not reach as far back as the samples.
  private writeSurfaces({ begin_s, surfaces }: Recorder, end_s: number): void {
    const { from_s } = surfaces;
    const shorter = from_s > begin_s;
    setHidden(this.surfaces, !shorter);
    if (shorter) setText(this.surfaces, from_s < end_s ? `Surfaces: last ${clock(end_s - from_s)}` : 'Surfaces: none');
  }

  private writeRecording(recorder: Recorder): void {
    const kept = recorder.kept;
    const length_s = kept === null ? 0 : kept.to_s - kept.from_s;
    const share = recorder.length_s > 0 ? Math.min(1, length_s / recorder.length_s) : 0;
    setText(this.record, recorder.recording ? 'Stop recording' : 'Record');
    setPressed(this.record, recorder.recording);
    setAttribute(this.root, 'data-recording', String(recorder.recording));
    setText(this.recorded, kept === null ? '' : `${clock(length_s)}, ${size(Math.round(recorder.bytes * share))}`);
    if (recorder.stopped_why !== '' && recorder.stopped_why !== this.shown) {
      this.actions.notify('warning', recorder.stopped_why);
    }
    this.shown = recorder.stopped_why;
  }

  private writeRange(recorder: Recorder, span: Span): void {
    const chosen = this.hasChosen;
    const name = chosen ? 'Chosen' : recorder.kept !== null ? 'Recorded' : 'Kept';
    const length_s = Math.max(0, span.to_s - span.from_s);
    setText(this.range, Number.isFinite(length_s) ? `${name}: ${clock(length_s, 1)}` : 'Nothing kept yet');
    setHidden(this.whole, !chosen);
  }

  private get hasChosen(): boolean {
    return this.chosen.from_s !== undefined || this.chosen.to_s !== undefined;
  }

  private marks(recorder: Recorder): boolean {
    return this.hasChosen || recorder.kept !== null;
  }

  // What would be saved: the person's choice, else the recording, else everything.
  private span(recorder: Recorder): Span {
    const kept = recorder.kept ?? { from_s: recorder.begin_s, to_s: recorder.end_s };
    return { ...kept, ...this.chosen };
  }

  private toggleRecording(): void {
    if (this.recorder?.recording === true) {
      this.recorder.stop();
    } else {
      this.chosen = {};
      this.recorder?.start();
    }
    this.update();
  }

  private enter(): void {
    const recorder = this.recorder;
    if (recorder === null || !Number.isNaN(this.t_s) || !Number.isFinite(recorder.end_s)) return;
    this.end_s = recorder.end_s;
    this.t_s = this.end_s;
    this.changed();
    this.update();
  }

  private goLive(): void {
    const was = this.t_s;
    this.t_s = this.end_s = NaN;
    this.runs = false;
    if (!Number.isNaN(was)) this.changed();
    this.update();
  }

  private scrub(t_s: number): void {
    this.enter();
    if (Number.isNaN(this.t_s)) return;
    this.t_s = Math.min(this.end_s, t_s);
    this.runs = false;
    this.update();
  }

  private togglePlaying(): void {
    this.runs = !this.runs;
    if (this.runs && this.t_s >= this.end_s && this.recorder !== null) this.t_s = this.span(this.recorder).from_s;
    this.update();
  }

  private choose(part: Partial<Span> | null): void {
    const next = part === null ? {} : { ...this.chosen, ...part };
    // The newer end counts if both are crossed.
    if (next.from_s !== undefined && next.to_s !== undefined && next.from_s > next.to_s) {
      if (part?.from_s !== undefined) delete next.to_s;
      else delete next.from_s;
    }
    this.chosen = next;
    this.update();
  }

  // Asks first: what was recorded cannot be had back.
  private clear(): void {
    const now_ms = performance.now();
    if (now_ms > this.sure_ms) {
      this.sure_ms = now_ms + kSure_ms;
      this.update();
      return;
    }
    this.sure_ms = -Infinity;
    this.chosen = {};
    this.recorder?.stop();
    this.recorder?.clear();
    this.goLive();
  }

  private async save(format: 'csv' | 'mcap'): Promise<void> {
    const recorder = this.recorder;
    if (recorder === null) return;
    const { from_s, to_s } = this.span(recorder);
    const button = format === 'csv' ? this.csv : this.mcap;
    setAttribute(button, 'aria-busy', 'true');
    try {
      const blob = await (format === 'csv' ? recorder.csv(from_s, to_s) : recorder.mcap(from_s, to_s));
      download(`omni-${stamp()}.${format}`, blob);
      this.actions.notify('info', `${clock(to_s - from_s, 1)} saved as ${format.toUpperCase()}, ${size(blob.size)}.`);
    } catch (error) {
      this.actions.notify('error', `Not saved: ${error instanceof Error ? error.message : String(error)}`);
    } finally {
      button.removeAttribute('aria-busy');
    }
  }
}

// "-0:12.3"; "0:00.0" at the end
function ago(seconds: number): string {
  return `${seconds < 0.05 ? '' : '-'}${clock(seconds, 1)}`;
}

// The time line: a slider over the kept minutes, with the range that would be exported marked in it.
class Timeline {
  readonly root: HTMLElement;
  private readonly range: HTMLInputElement;
  private readonly marked = make('span', { class: 'timeline-marked' });
  private begin_s = 0;
  private end_s = 0;

  constructor(scrub: (t_s: number) => void) {
    this.range = make('input', { type: 'range', min: 0, max: 0, step: 0.01, 'aria-label': 'Time that is shown' });
    this.range.dataset['testid'] = 'timeline';
    this.range.addEventListener('input', () => scrub(this.begin_s + this.range.valueAsNumber));
    this.root = make('span', { class: 'timeline' }, this.marked, this.range);
  }

  // `mark`: what would be exported is less than everything.
  update(begin_s: number, end_s: number, t_s: number, mark: { from_s: number; to_s: number } | null): void {
    const length_s = end_s - begin_s;
    const disabled = !(length_s > 0);
    if (this.range.disabled !== disabled) this.range.disabled = disabled;
    if (disabled) return;
    this.begin_s = begin_s;
    this.end_s = end_s;
    setAttribute(this.range, 'max', length_s.toFixed(2));
    const value = (t_s - begin_s).toFixed(2);
    if (this.range.value !== value) this.range.value = value;
    const before = this.end_s - t_s;
    setAttribute(this.range, 'aria-valuetext', before < 0.01 ? 'newest' : `${clock(before, 1)} before the newest`);
    const percent = (time_s: number): string =>
      `${Math.min(100, Math.max(0, (100 * (time_s - begin_s)) / length_s)).toFixed(2)}%`;
    setHidden(this.marked, mark === null);
    if (mark === null) return;
    this.marked.style.setProperty('--from', percent(mark.from_s));
    this.marked.style.setProperty('--to', percent(mark.to_s));
  }
}
