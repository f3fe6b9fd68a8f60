// What the page knows now. main.ts writes it, the panels read it.
import type { LinkState } from '../link';
import type { SurfacesThen } from '../record/surface_record';
import type { Hello, Live, Request, SceneMessage, SetupMessage, Status, StatusMessage } from '../types';
import type { Signals } from '../signals';

export interface PageState {
  hello: Hello;
  signals: Signals;
  link: LinkState;
  status: StatusMessage | null;
  setup: SetupMessage | null;
  scene: SceneMessage | null;
  live: Live | null; // what is shown: the newest, or that of the replayed time
  replay: boolean;
  silent_s: number; // since the last message with samples
  dent_m: number; // largest displacement of the surfaces that are shown; NaN: none
  then: SurfacesThen | null; // what is replayed; null: nothing is, or no scene is known of that time
  lost: number; // samples that never came, as this page was too slow
  undecodable: { count: number; text: string }; // messages that were not understood
}

// What panels ask for.
export interface Actions {
  send(request: Request): boolean; // false: there is no connection
  drop(name: string, bytes: ArrayBuffer): boolean;
  notify(level: 'info' | 'warning' | 'error', text: string): void; // a notice that is seen and read out
}

export interface Panel {
  readonly root: HTMLElement;
  update(state: PageState): void; // ten times a second
}

export function statusOf(state: PageState): Status | null {
  return state.status?.connected === true ? state.status.status : null;
}

// Whether the base is simulated, as far as is known.
export function isSimulated(status: Status | null): boolean {
  return status?.SIMULATION !== undefined;
}

// May this page change something now?
export function canControl(state: PageState): boolean {
  return state.hello.control && state.link.kind === 'open';
}
