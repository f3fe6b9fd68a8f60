// The page's parts and where they stand. Knows no messages: main.ts brings them.
import { StripBoard } from '../strips/board';
import type { History } from '../strips/history';
import { CoveragePanel } from './coverage';
import { Splitter, type Card } from '../ui/card';
import { make, makeButton, recall, remember, setAttribute, setHidden } from '../ui/dom';
import { DropTarget } from './drop';
import { FeelPanel } from './feel';
import { Header, connectionOf } from './header';
import { Banner, Notices } from './notices';
import { NowPanel } from './now';
import { ProblemsPanel } from './problems';
import { ReplayBar } from './replay';
import { ScenesPanel } from './scenes';
import { EnvironmentPanel, HandPanel, InputsPanel, SetupPanel } from './simple';
import { Stage } from './stage';
import type { Actions, PageState, Panel } from './state';
import type { Theme } from '../ui/theme';
import { TickPanel } from './tick';

export interface PageEvents {
  lift(): void; // the pen is to be taken away
  modeChanged(): void; // live or replay
  window(): { history: History | null; to_s: number }; // what the strips show
}

export class Page {
  readonly stage: Stage;
  readonly replay: ReplayBar;
  readonly strips: StripBoard;
  readonly problems = new ProblemsPanel();
  readonly coverage: CoveragePanel;
  readonly feel: FeelPanel;
  private readonly header: Header;
  private readonly banner = new Banner();
  private readonly spoken = make('p', { class: 'unseen', 'aria-live': 'polite' });
  private readonly drop: DropTarget;
  private readonly handPlace = make('div', { class: 'contents' });
  private readonly panels: Panel[];
  private readonly experts: { card: Card }[];
  private hand: HandPanel | null = null;
  private readonly measure: HTMLButtonElement;
  private visitor: boolean | null = null; // null: not known yet

  constructor(
    theme: Theme,
    actions: Actions,
    notices: Notices,
    private readonly events: PageEvents,
  ) {
    this.header = new Header(theme, actions);
    this.stage = new Stage(actions);
    this.replay = new ReplayBar(actions, () => events.modeChanged());
    this.strips = new StripBoard(theme);
    this.coverage = new CoveragePanel(theme);
    this.feel = new FeelPanel(actions);
    this.drop = new DropTarget(actions);
    const now = new NowPanel();
    const scenes = new ScenesPanel(actions, this.drop);
    const environment = new EnvironmentPanel(actions);
    const setup = new SetupPanel(actions);
    const tick = new TickPanel(theme, () => events.window());
    const inputs = new InputsPanel();
    this.measure = makeButton('Measurements', () => this.setMeasuring(this.measure.ariaExpanded !== 'true', true), {
      class: 'button measure',
      title: 'Strips of every tick, recording and replay',
    });
    this.measure.dataset['testid'] = 'measure';
    this.measure.hidden = true;
    const columns: [Panel[], (Panel & { card: Card })[]] = [
      [now, this.problems, scenes],
      [this.feel, environment, setup, this.coverage, tick, inputs],
    ];
    this.panels = columns.flat();
    this.experts = columns[1];
    const doing = make('div', { class: 'panel-column' }, ...columns[0].map((panel) => panel.root));
    const knowing = make('div', { class: 'panel-column' }, this.handPlace, ...columns[1].map((panel) => panel.root));
    const panels = make('section', { class: 'panels', 'aria-label': 'Panels' }, doing, knowing);
    const main = make('main', { class: 'layout' });
    const splitter = new Splitter(main);
    this.stage.root.append(this.measure);
    main.append(this.stage.root, this.replay.root, panels, splitter.root, this.strips.root);
    const skip = make('a', { class: 'skip', href: '#card-now' }, 'Skip to the panels');
    skip.addEventListener('click', (event) => {
      event.preventDefault(); // the hash is for the key
      now.root.querySelector('summary')?.focus();
    });
    document.body.append(skip, this.header.root, this.banner.root, main);
    document.body.append(notices.root, this.drop.veil, this.spoken);
  }

  setHand(help: { keys: string; does: string }[]): void {
    this.hand = new HandPanel(help, () => this.events.lift());
    this.handPlace.replaceChildren(this.hand.root);
  }

  // What the hand says: read out, not shown.
  announce(text: string): void {
    this.spoken.textContent = text;
  }

  mustReload(why: string): void {
    this.banner.mustReload(why);
  }

  // omni try begins with the picture; what measures is folded until it is asked for.
  private setVisitor(on: boolean): void {
    this.visitor = on;
    setAttribute(document.body, 'data-visitor', String(on));
    setHidden(this.measure, !on);
    this.setMeasuring(!on || recall('measure') === 'open', false);
    if (on) for (const panel of this.experts) panel.card.fold();
  }

  private setMeasuring(on: boolean, chosen: boolean): void {
    if (chosen) remember('measure', on ? 'open' : 'closed');
    this.measure.setAttribute('aria-expanded', String(on));
    setAttribute(document.body, 'data-measure', on ? 'open' : 'closed');
    this.strips.setShown(on);
  }

  // Ten times a second.
  update(state: PageState): void {
    if (state.hello.version !== '' && this.visitor !== state.hello.hand) this.setVisitor(state.hello.hand);
    this.header.update(state);
    this.banner.update(state);
    this.stage.update(state);
    this.replay.update();
    this.drop.update(state);
    for (const panel of this.panels) panel.update(state);
    this.hand?.update(state);
    this.strips.update(state);
    const fresh = connectionOf(state).state === 'live';
    setAttribute(document.body, 'data-mode', state.replay ? 'replay' : fresh ? 'live' : 'stale');
  }
}
