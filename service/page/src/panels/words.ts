// What is going on, in plain words.
import { clock, fixed, mm, plural } from '../ui/format';
import { length } from '../signals';
import { statusOf } from './state';
import type { FlagName } from '../contract';
import type { PageState } from './state';
import type { Contact } from '../types';

export interface Tracking {
  state: 'tracked' | 'lost' | 'absent';
  text: string;
}

export function tracking(state: PageState): Tracking {
  const { live, signals } = state;
  if (!state.replay) {
    if (state.link.kind !== 'open') return { state: 'absent', text: 'There is no connection.' };
    if (state.status?.connected === false) return { state: 'absent', text: 'omnid is not there.' };
    const device = statusOf(state)?.device;
    if (device !== undefined && device.name === null) {
      return { state: 'absent', text: `There is no base${device.absent ? `: ${device.absent}` : ''}.` };
    }
  }
  if (live === null) return { state: 'absent', text: 'Waiting for the first measurement.' };
  if (signals.flag(live, 'tracked') === true) return { state: 'tracked', text: 'The pen is tracked.' };
  if (signals.frozen(live)) return { state: 'lost', text: 'Every sensor repeats itself: nothing is measured.' };
  if (signals.contradicted(live)) {
    return { state: 'lost', text: 'A magnet is near, but no pose fits: see the problems.' };
  }
  if (signals.flag(live, 'pose_valid') === true) {
    return { state: 'lost', text: 'The pen is lost: its last place is shown. Bring it nearer to the base.' };
  }
  const bring = state.hello.hand ? 'press on the view to bring it.' : 'bring it within 100 mm of the base.';
  return { state: 'absent', text: `No pen is near: ${bring}` };
}

// "dragon with 0.32 N, lid with 0.10 N", "clay with 0.40 N, held: pull it out, or push it in"
export function touching(state: PageState): string {
  const { live, signals } = state;
  const contacts = live?.contacts ?? [];
  const held = live !== null && signals.flag(live, 'holding') === true ? 'held: pull it out, or push it in' : '';
  if (contacts.length === 0) return held || 'nothing';
  const force = (contact: Contact): string => fixed(length(contact.force), 2);
  const touched = contacts.map((contact) => `${objectName(state, contact)} with ${force(contact)} N`).join(', ');
  return held === '' ? touched : `${touched}, ${held}`;
}

function objectName(state: PageState, contact: Contact): string {
  if (isOfOtherScene(state)) return `object ${contact.object}`;
  const part = state.scene?.parts.find((candidate) => candidate.object === contact.object);
  const material = state.scene?.materials.find((candidate) => candidate.index === contact.material)?.name ?? '';
  const name = part?.name || `object ${contact.object}`;
  return material === '' || material === name ? name : `${name} (${material})`;
}

// What is replayed is of a scene that is not loaded now.
function isOfOtherScene({ then, scene }: PageState): boolean {
  return then !== null && then.scene !== scene?.number;
}

// What of the replayed scene cannot be shown as it was; "": all is.
export function replayNote(state: PageState): string {
  const { then, scene } = state;
  if (then === null) return '';
  if (isOfOtherScene(state)) {
    if (then.name === '') return 'No scene was loaded at this time.';
    if (then.name === scene?.name) {
      return `${then.name} was loaded again after this time: what it was like before is not drawn.`;
    }
    return `${then.name} was loaded at this time. It is not loaded now, so only the pen is drawn.`;
  }
  if (then.late_s > 0) {
    return `Surfaces of this time are no longer kept: they are drawn as they were ${clock(then.late_s, 1)} later.`;
  }
  return then.complete ? '' : 'A surface was too large to be kept: it is drawn as it was loaded.';
}

// Why the force is not what it should be, the weightiest first; '': that flag is no reason.
const kForceNotes: Record<FlagName, string> = {
  device_fault: 'no force: the base reports a fault',
  out_of_reach: 'no force can be made here',
  waits: 'no force: the pen is inside; it is felt once it was outside',
  saturated: 'cut by what the base can do',
  softened: 'softer for a while: it made the hand swing; rest for half a second',
  stiffness_limited: 'softer than asked for, to stay stable',
  warm: 'the coils are warm: less force than when cold',
  pushed: 'an application pushes',
  pose_valid: '',
  tracked: '',
  contact: '',
  joystick: '',
  aligned: '',
  holding: '',
};

// "": it is.
export function forceNote({ live, signals }: PageState): string {
  if (live === null) return '';
  const names = Object.keys(kForceNotes) as FlagName[];
  const reason = names.find((name) => kForceNotes[name] !== '' && signals.flag(live, name) === true);
  return reason === undefined ? '' : kForceNotes[reason];
}

export function owner(state: PageState): string {
  const status = statusOf(state);
  if (status === null) return '-';
  const client = status.clients?.find((candidate) => candidate.owner);
  if (client === undefined) return 'no application has the pen';
  return client.application || `process ${client.pid}`;
}

// null: the scene has no soft body.
export function softBodies(state: PageState): { text: string; done: number } | null {
  const soft = statusOf(state)?.scene?.soft_bodies;
  if (soft === undefined || soft === null) return null;
  const failed = soft.failed > 0 ? `, ${soft.failed} failed` : '';
  if (soft.ready + soft.failed >= soft.objects) {
    return { text: `${plural(soft.ready, 'soft body ready', 'soft bodies ready')}${failed}`, done: 1 };
  }
  const percent = Math.floor(100 * Math.min(1, Math.max(0, soft.done)));
  return { text: `being computed: ${percent} %${failed}; until then it gives way in layers`, done: soft.done };
}

export interface Race {
  laps: number;
  hits: number;
  speed: string;
  laps_s: string; // their times
}

// The car's newest figures; null: there is none.
export function race(state: PageState): Race | null {
  const car = state.live?.vehicle;
  if (car === null || car === undefined) return null;
  const seconds = (value: number): string => (value > 0 ? fixed(value, 2) : '-');
  return {
    laps: car.laps,
    hits: car.hits,
    speed: `${mm(car.speed_m_s, 0)}/s${car.sliding ? ', sliding' : ''}`,
    laps_s: `now ${seconds(car.lap_s)}, last ${seconds(car.last_lap_s)}, best ${seconds(car.best_lap_s)} s`,
  };
}
