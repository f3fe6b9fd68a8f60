// The page of omni monitor and omni try: what arrives goes to the view, the recorder, the strips and the panels.
import { Hand } from './hand/hand';
import { Link } from './link';
import type { LinkState } from './link';
import { download } from './ui/dom';
import { Notices } from './panels/notices';
import { Page } from './panels/page';
import { Signals } from './signals';
import type { Actions, PageState } from './panels/state';
import { Theme } from './ui/theme';
import { Recorder } from './record/recorder';
import { History } from './strips/history';
import './style.css';
import type {
  AnswerMessage, BinaryMessage, Hello, Live, NoticeMessage, SceneMessage, Surface, TextMessage,
} from './types';
import { View } from './view/view';

const kText_ms = 100; // between two updates of the panels

// Before the first message.
const kNoHello: Hello = {
  type: 'hello',
  protocol: 0,
  version: '',
  control: false,
  hand: false,
  channels: [],
  flags: [],
  faults: [],
  device_faults: [],
  scenes: [],
  material_fields: [],
  max_file_bytes: 0,
  environment: [],
  base: {
    hull_radius_m: 0,
    core_radius_m: 0,
    coils: [],
    sensors: [],
    current_max_A: 0,
    force_max_N: 0,
    magnet: { radius_m: 0, half_height_m: 0, tip_offset_m: 0 },
  },
};

// What depends on the service's first message.
interface Session {
  layout: string; // of the samples: another one needs another session
  history: History;
  recorder: Recorder;
}

class App {
  private readonly theme = new Theme();
  private readonly notices = new Notices();
  private readonly link: Link;
  private readonly page: Page;
  private readonly view: View;
  private readonly hand: Hand;
  private readonly dents = new Map<number, number>(); // by object
  private session: Session | null = null;
  private newest: Live | null = null;
  private heard_ms = -Infinity; // when the last samples came
  private frame_ms = NaN;
  private shown_s = NaN; // replayed time that the view shows
  private readonly state: PageState = {
    hello: kNoHello,
    signals: new Signals(kNoHello),
    link: { kind: 'connecting', text: '' },
    status: null,
    setup: null,
    scene: null,
    live: null,
    replay: false,
    silent_s: Infinity,
    dent_m: NaN,
    then: null,
    lost: 0,
    undecodable: { count: 0, text: '' },
  };

  constructor() {
    this.link = new Link({
      state: (state) => this.takeState(state),
      text: (message) => this.takeText(message),
      binary: (message) => this.takeBinary(message),
      garbled: (why) => this.takeGarbled(why),
    });
    const actions: Actions = {
      send: (request) => this.link.send(request),
      drop: (name, bytes) => this.link.drop(name, bytes),
      notify: (level, text) => this.notices.notify(level, text),
    };
    this.page = new Page(this.theme, actions, this.notices, {
      lift: () => this.hand.lift(),
      modeChanged: () => this.changeMode(),
      window: () => ({ history: this.session?.history ?? null, to_s: this.end_s() }),
    });
    this.view = new View(this.page.stage.host);
    this.hand = new Hand(this.view, (request) => this.link.send(request), (text) => this.page.announce(text));
    this.page.stage.setView(this.view);
    this.page.setHand(this.hand.help());
    this.hand.setEnabled(false);
    this.theme.listen((dark) => this.view.setTheme(dark));
  }

  start(): void {
    this.link.start();
    const frame = (now_ms: number): void => {
      this.drawFrame(now_ms);
      requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
    // Not by frames: a hidden page has none, a slow one few, and the words must be right there, too.
    setInterval(() => this.writeTexts(), kText_ms);
  }

  private takeState(state: LinkState): void {
    this.state.link = state;
    if (state.kind !== 'open') this.state.status = null;
    this.enableHand();
  }

  private takeText(message: TextMessage): void {
    switch (message.type) {
      case 'hello':
        return this.takeHello(message);
      case 'status':
        this.state.status = message;
        return;
      case 'setup':
        this.state.setup = message;
        return;
      case 'scene':
        return this.takeScene(message);
      case 'notice':
        return this.takeNotice(message);
      case 'answer':
        return this.takeAnswer(message);
    }
  }

  private takeHello(hello: Hello): void {
    const layout = JSON.stringify([hello.channels, hello.flags]);
    if (this.session !== null && this.session.layout !== layout) {
      // Old samples would be taken for something else; they can still be saved.
      this.page.mustReload('The service is another one now. Save what you recorded, then reload this page.');
      this.session.recorder.stop();
      return;
    }
    this.state.hello = hello;
    this.state.signals = new Signals(hello);
    this.view.setHello(hello);
    if (this.session === null) {
      this.session = { layout, history: new History(hello.channels.length), recorder: new Recorder(hello) };
      this.page.replay.setRecorder(this.session.recorder);
      this.page.strips.setHello(hello);
    }
    this.enableHand();
  }

  private takeScene(scene: SceneMessage): void {
    if (scene.number !== this.state.scene?.number) {
      this.dents.clear();
      if (this.state.scene !== null) this.hand.taken();
      if (!this.state.replay) this.state.dent_m = NaN;
    }
    this.state.scene = scene;
    this.session?.recorder.surfaces.setScene(scene);
    this.view.setScene(scene);
    this.page.feel.setScene(this.state.hello, scene);
  }

  private takeNotice(notice: NoticeMessage): void {
    this.notices.notify(notice.level, notice.text);
  }

  private takeAnswer(answer: AnswerMessage): void {
    this.page.feel.answer(answer);
  }

  private takeBinary(message: BinaryMessage): void {
    switch (message.kind) {
      case 'live':
        return this.takeLive(message.live);
      case 'shape':
        return this.view.addShape(message.shape);
      case 'surface':
        return this.takeSurface(message.surface);
      case 'file':
        if (this.page.feel.takes(message.file)) {
          const bytes = new Uint8Array(message.file.bytes); // a copy: the message is let go
          download(message.file.name, new Blob([bytes], { type: 'model/gltf-binary' }));
          this.notices.notify('info', `${message.file.name} is saved where your browser puts downloads.`);
        }
        return;
    }
  }

  private takeSurface(surface: Surface): void {
    if (surface.scene === this.state.scene?.number) {
      this.dents.set(surface.object, surface.largest_displacement_m);
      if (!this.state.replay) this.state.dent_m = deepest(this.dents.values());
    }
    this.session?.recorder.surfaces.add(surface);
    this.view.setSurface(surface);
  }

  private takeLive(live: Live): void {
    const session = this.session;
    if (session === null || live.samples.length !== live.count * session.history.channels) return;
    session.recorder.add(live);
    session.history.add(live);
    this.heard_ms = performance.now();
    this.state.lost += live.lost;
    // Without samples, those before it still hold.
    const before = this.newest;
    this.newest = live.count > 0 || before === null ? live : { ...live, ...pick(before) };
    this.page.problems.add(live, this.state);
    this.page.coverage.add(live, this.state);
    if (this.state.replay) return;
    this.state.live = this.newest;
    this.view.setLive(live);
    this.hand.setLive(live, this.state.signals.flag(live, 'holding') === true);
  }

  private takeGarbled(why: string): void {
    const count = this.state.undecodable.count + 1;
    this.state.undecodable = { count, text: why };
  }

  private changeMode(): void {
    const replay = !Number.isNaN(this.page.replay.shown_s);
    this.state.replay = replay;
    this.shown_s = NaN;
    if (!replay) {
      this.state.live = this.newest;
      this.state.then = null;
      this.state.dent_m = deepest(this.dents.values());
      this.session?.recorder.surfaces.rest();
      this.view.setReplay(null);
      if (this.newest !== null) this.view.setLive(this.newest);
    }
    this.enableHand();
  }

  private enableHand(): void {
    this.hand.setEnabled(this.state.hello.hand && this.state.link.kind === 'open' && !this.state.replay);
  }

  // End of the window of the strips.
  private end_s(): number {
    const shown_s = this.page.replay.shown_s;
    return Number.isNaN(shown_s) ? (this.session?.history.newest_s ?? NaN) : shown_s;
  }

  private drawFrame(now_ms: number): void {
    const elapsed_s = Number.isNaN(this.frame_ms) ? 0 : Math.min(0.1, (now_ms - this.frame_ms) / 1e3);
    this.frame_ms = now_ms;
    this.page.replay.advance(elapsed_s);
    const shown_s = this.page.replay.shown_s;
    if (!Number.isNaN(shown_s) && shown_s !== this.shown_s) {
      this.shown_s = shown_s;
      this.showThen(shown_s);
    }
    if (this.session !== null) this.page.strips.draw(this.session.history, this.end_s());
  }

  // The samples and surfaces of a recorded time.
  private showThen(t_s: number): void {
    const live = this.session?.recorder.at(t_s) ?? null;
    const then = this.session?.recorder.surfaces.at(t_s) ?? null;
    this.state.live = live;
    this.state.then = then;
    this.state.dent_m = deepest((then?.surfaces ?? []).map((surface) => surface.largest_displacement_m));
    if (then !== null) this.view.setReplay(then);
    if (live !== null) this.view.setLive(live);
  }

  private writeTexts(): void {
    this.state.silent_s = (performance.now() - this.heard_ms) / 1e3;
    this.page.update(this.state);
    const scene = this.state.scene?.name ?? '';
    const title = [this.state.replay ? 'Replay' : '', scene, 'Omni'].filter((text) => text !== '').join(' - ');
    if (document.title !== title) document.title = title;
  }
}

// NaN: there are none.
function deepest(dents_m: Iterable<number>): number {
  const most = Math.max(...dents_m);
  return most >= 0 ? most : NaN;
}

function pick(live: Live): Pick<Live, 'count' | 'times_s' | 'samples'> {
  return { count: live.count, times_s: live.times_s, samples: live.samples };
}

new App().start();
