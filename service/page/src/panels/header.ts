// The top of the page: what this is, whether it is a simulation, which scene, whether there is a connection, and the
// emergency stop.
import { make, setAttribute, setHidden, setText } from '../ui/dom';
import { clock, plural } from '../ui/format';
import { StopButton } from './stop';
import { statusOf } from './state';
import type { Actions, PageState } from './state';
import type { Theme } from '../ui/theme';

const kSilent_s = 1; // without a message: said

interface Connection {
  state: 'live' | 'wait' | 'lost';
  text: string;
  more: string; // what is wrong and what to do
}

// In words. The service may be there while omnid is not.
export function connectionOf(state: PageState): Connection {
  const link = state.link;
  switch (link.kind) {
    case 'connecting':
      return { state: 'wait', text: 'Connecting …', more: '' };
    case 'lost': {
      const since = clock((performance.now() - link.since_ms) / 1e3);
      return { state: 'lost', text: `No connection for ${since}`, more: link.text };
    }
    case 'refused':
      return { state: 'lost', text: 'Refused', more: link.text };
    case 'old':
      return { state: 'lost', text: 'Old page', more: link.text };
    case 'open':
      if (state.status?.connected === false) {
        return { state: 'wait', text: 'omnid is not there', more: state.status.why };
      }
      if (state.silent_s > kSilent_s) {
        const seconds = Number.isFinite(state.silent_s) ? ` for ${plural(Math.floor(state.silent_s), 'second')}` : '';
        return { state: 'wait', text: `No measurements${seconds}`, more: '' };
      }
      return { state: 'live', text: 'Connected', more: '' };
  }
}

export class Header {
  readonly root: HTMLElement;
  private readonly version = make('span', { class: 'version' });
  private readonly simulation = make('strong', { class: 'badge simulation', hidden: true }, 'Simulation');
  private readonly role = make('span', { class: 'badge', 'data-testid': 'role' }, 'Only watching');
  private readonly scene = make('span', { class: 'scene-name', 'data-testid': 'scene-name' });
  private readonly connection = make('span', { class: 'connection', 'data-testid': 'connection' });
  private readonly stop: StopButton;

  constructor(theme: Theme, actions: Actions) {
    this.stop = new StopButton(actions);
    const brand = make('h1', { class: 'brand' }, make('span', { class: 'logo', 'aria-hidden': 'true' }), 'Omni');
    this.root = make(
      'header',
      { class: 'header' },
      make('div', { class: 'brand-box' }, brand, this.version),
      make('div', { class: 'state-box' }, this.simulation, this.role, this.scene, this.connection),
      theme.button,
      this.stop.root,
    );
    this.simulation.dataset['testid'] = 'simulation';
    this.role.hidden = true;
  }

  update(state: PageState): void {
    const status = statusOf(state);
    setText(this.version, state.hello.version);
    // Without a status the last one counts: what is shown is of then.
    if (status !== null) setHidden(this.simulation, status.SIMULATION === undefined);
    if (status?.SIMULATION !== undefined) setAttribute(this.simulation, 'title', status.SIMULATION);
    setHidden(this.role, state.hello.version === '' || state.hello.control);
    setText(this.scene, sceneText(state));
    const connection = connectionOf(state);
    setText(this.connection, connection.text);
    setAttribute(this.connection, 'data-state', connection.state);
    this.stop.update(state);
  }
}

function sceneText(state: PageState): string {
  const name = state.scene?.name || statusOf(state)?.scene?.name || '';
  if (name === '') return 'No scene';
  return state.scene?.state === 'loading' ? `${name}, loading` : name;
}
