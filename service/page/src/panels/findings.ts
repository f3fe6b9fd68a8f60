// Everything that is not as it should be, and what to do about it: from status, faults and the page's own watch.
import { kTickFault } from '../contract';
import type { DeviceFaultName } from '../contract';
import { plural } from '../ui/format';
import { isSimulated, statusOf } from './state';
import type { PageState } from './state';
import type { Status } from '../types';

export type Severity = 'error' | 'warning' | 'hint';

export interface Finding {
  key: string; // the same while it is the same problem
  severity: Severity;
  what: string;
  fix: string; // what to do; "": `what` says it
}

// What the page has counted itself.
export interface Watched {
  deviceFaults: number; // bits seen since the last look
  tickFaults: number;
  late: number; // ticks that were late in the last seconds, and of how many
  ticks: number;
}

// The tick's own faults: what to do. Tracking is no problem but a state, and "Now" says it; a device fault has its
// own line with its own remedy.
const kTickAdvice: [number, string][] = [
  [kTickFault.time, 'If it comes back, unplug the base and plug it in again.'],
  [kTickFault.not_finite, 'Please report it with the output of omni status --json.'],
  [kTickFault.commands_stale, 'Close what keeps the processor busy, and allow real-time scheduling: docs/howto/realtime.md.'],
];
const kTickSilent = kTickFault.tracking | kTickFault.device;
const kLateShare = 0.01; // of the ticks: fewer are not felt
const kSimulatedFix = 'This base is a simulation: nothing has to be done.';
const kNotArmed: DeviceFaultName = 'not armed';
const kOfLateHost: readonly string[] = [kNotArmed, 'host silent'] satisfies DeviceFaultName[]; // of a simulated base: the host was late, which has its own line

export function findings(state: PageState, watched: Watched): Finding[] {
  const status = statusOf(state);
  return [
    ...ofConnection(state),
    ...ofScene(state),
    ...(status === null ? [] : ofStop(status, state)),
    ...ofDevice(state, status, watched.deviceFaults),
    ...ofTickFaults(state, status, watched.tickFaults),
    ...(status === null ? [] : [...ofRoom(status), ...ofCalibration(status), ...ofTiming(status, watched)]),
    ...(status === null ? [] : ofService(status)),
    ...ofPage(state),
  ];
}

function ofConnection(state: PageState): Finding[] {
  if (state.link.kind === 'lost') {
    return [{ key: 'link', severity: 'error', what: 'No connection to omni.', fix: state.link.text }];
  }
  if (state.link.kind === 'refused' || state.link.kind === 'old') {
    return [{ key: 'link', severity: 'error', what: 'This page is not connected.', fix: state.link.text }];
  }
  if (state.link.kind === 'open' && state.status?.connected === false) {
    return [{ key: 'omnid', severity: 'error', what: 'omnid is not there.', fix: state.status.why }];
  }
  return [];
}

function ofScene(state: PageState): Finding[] {
  if (state.scene?.state !== 'failed') return [];
  const what = `${state.scene.name || 'The scene'} could not be loaded.`;
  return [{ key: `scene.${state.scene.number}`, severity: 'error', what, fix: sentence(state.scene.text) }];
}

function ofStop(status: Status, state: PageState): Finding[] {
  if (typeof status.stopped !== 'string') return [];
  const by = status.stopped === '' ? '' : ` (${status.stopped})`;
  const since = typeof status.stop?.at === 'string' ? ` since ${status.stop.at}` : '';
  const fix = state.hello.control
    ? 'When it is safe, press “Release the stop” at the top.'
    : 'A page of omni monitor --control or omni try can release it.';
  const problem = status.stop?.problem;
  const ends = typeof problem === 'string' ? ` It is forgotten when omnid ends: ${sentence(problem)}` : '';
  return [{ key: 'stopped', severity: 'error', what: `The emergency stop is on${by}${since}: no force.${ends}`, fix }];
}

function ofDevice(state: PageState, status: Status | null, bits: number): Finding[] {
  const found: Finding[] = [];
  const device = status?.device;
  if (device !== undefined && device.name === null) {
    found.push({ key: 'no-base', severity: 'error', what: 'There is no base.', fix: device.absent ?? '' });
    return found;
  }
  const simulated = isSimulated(status);
  const named = new Set(device?.faults ?? []);
  for (const fault of state.hello.device_faults) {
    if (((bits >>> fault.bit) & 1) === 0 && !named.delete(fault.name)) continue;
    named.delete(fault.name);
    if (simulated && kOfLateHost.includes(fault.name)) continue;
    const armed = fault.name !== kNotArmed; // else only the state of a base that has just started
    const what = `Base: ${fault.name}${fault.text === '' ? '' : ` (${fault.text})`}.`;
    const fix = simulated ? kSimulatedFix : fault.remedy;
    found.push({ key: `device.${fault.bit}`, severity: armed && !simulated ? 'error' : 'hint', what, fix });
  }
  for (const name of named) found.push({ key: `device.${name}`, severity: 'error', what: `Base: ${name}.`, fix: '' });
  if (device?.waits_for_person === true) {
    const fix = 'Run omni device selftest: it shows what is wrong, and switches the coils on again.';
    found.push({ key: 'waits', severity: 'error', what: 'The base waits for you with its coils off.', fix });
  }
  return found;
}

function ofTickFaults(state: PageState, status: Status | null, bits: number): Finding[] {
  const simulated = isSimulated(status);
  return state.hello.faults
    .filter((fault) => ((bits & ~kTickSilent) >>> fault.bit & 1) === 1)
    .map((fault) => ({
      key: `tick.${fault.bit}`,
      severity: simulated ? ('hint' as const) : ('warning' as const),
      what: `In the last ticks, ${fault.name}.`,
      fix: simulated ? kSimulatedFix : (kTickAdvice.find(([mask]) => mask === 1 << fault.bit)?.[1] ?? ''),
    }));
}

function ofRoom(status: Status): Finding[] {
  return (status.room ?? []).map((finding) => ({
    key: `room.${finding.kind}.${finding.sensors.join('.')}`,
    severity: 'warning' as const,
    what: sentence(finding.what),
    fix: sentence(finding.fix),
  }));
}

function ofCalibration(status: Status): Finding[] {
  const found: Finding[] = [];
  const again = 'Run omni calibrate.';
  if (status.calibration_refused) {
    found.push({ key: 'refused', severity: 'warning', what: sentence(status.calibration_refused), fix: again });
  } else if (status.calibration === null) {
    const what = 'Never calibrated: the pen is tracked less well, with less force.';
    found.push({ key: 'uncalibrated', severity: 'hint', what, fix: again });
  }
  if (status.calibration_misfit) {
    found.push({ key: 'misfit', severity: 'warning', what: sentence(status.calibration_misfit), fix: '' });
  }
  return found;
}

function ofTiming(status: Status, watched: Watched): Finding[] {
  const found: Finding[] = [];
  const tick = status.tick;
  if (tick === undefined) return found;
  const starved = watched.late > kLateShare * watched.ticks;
  if (starved) {
    const what = `${watched.late} of the last ${watched.ticks} ticks were late.`;
    const fix = tick.realtime ? 'Close what keeps the processor busy.' : 'Allow real-time scheduling (see below).';
    found.push({ key: 'late', severity: 'warning', what, fix });
  }
  if (!tick.realtime) {
    const what = `Ticks run without real-time scheduling${tick.realtime_reason ? `: ${tick.realtime_reason}` : ''}.`;
    const fix = 'How to allow it: docs/howto/realtime.md.';
    found.push({ key: 'realtime', severity: starved ? 'warning' : 'hint', what, fix });
  }
  return found;
}

// omnid's own list has room, calibration and host once more, as text.
function ofService(status: Status): Finding[] {
  return (status.problems ?? [])
    .filter((text) => !/^(room|calibration|host): /.test(text))
    .map((text) => ({ key: `problem.${text}`, severity: 'warning' as const, what: sentence(text), fix: '' }));
}

function ofPage(state: PageState): Finding[] {
  const found: Finding[] = [];
  const { count, text } = state.undecodable;
  if (count > 0) {
    const what = `${plural(count, 'message')} could not be understood (${text}).`;
    found.push({ key: 'garbled', severity: 'warning', what, fix: 'Reload the page; if it stays, report it.' });
  }
  if (state.lost > 0) {
    const what = `${plural(state.lost, 'sample')} never came: this page was too slow for them.`;
    found.push({ key: 'lost', severity: 'hint', what, fix: 'Close some strips, or other tabs.' });
  }
  return found;
}

function sentence(text: string): string {
  const trimmed = text.trim();
  if (trimmed === '') return '';
  const first = trimmed.charAt(0).toUpperCase() + trimmed.slice(1);
  return /[.!?]$/.test(first) ? first : `${first}.`;
}
