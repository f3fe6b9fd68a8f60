// The view in words, for people who do not see it.
import type { Vec3 } from '../types';
import type { Picture } from './picture';

const kForceLeast = 0.02; // N that are worth a word
const kAimLeast = 0.002; // m

// `name`: of a touched object.
export function describe(picture: Picture, name: (object: number) => string): string {
  if (!picture.valid) return 'There is no pen.';
  if (!picture.tracked) return `The pen is lost. It was last seen ${place(picture.tip)}.`;
  const newton = Math.hypot(...picture.force);
  const touched = picture.contacts.map((contact) => name(contact.object) || 'the scene');
  const sentence = [`The pen's tip is ${place(picture.tip)}`];
  const tilt = Math.round((Math.acos(Math.min(1, Math.max(-1, -picture.axis[2]))) * 180) / Math.PI);
  if (tilt >= 10) sentence.push(`, tilted by ${tilt}°`);
  if (touched.length > 0) {
    const pressed = picture.contacts.reduce((most, contact) => Math.max(most, contact.normal_N), 0);
    sentence.push(`; it touches ${[...new Set(touched)].join(' and ')} with ${pressed.toFixed(2)} N`);
  } else {
    sentence.push('; it touches nothing');
  }
  if (newton >= kForceLeast) {
    sentence.push(`; the base pushes it with ${newton.toFixed(2)} N ${towards(picture.force)}`);
  }
  if (picture.aim.present) {
    const pull: Vec3 = [0, 1, 2].map((i) => picture.aim.tip[i]! - picture.tip[i]!) as Vec3;
    const away = Math.hypot(...pull);
    if (away >= kAimLeast) sentence.push(`; the hand pulls ${(1000 * away).toFixed(0)} mm ${towards(pull)}`);
  }
  return `${sentence.join('')}.`;
}

const kDirections: [string, string][] = [['left', 'right'], ['towards you', 'away from you'], ['down', 'up']];

// Where it points most.
function towards(v: Vec3): string {
  const size = v.map(Math.abs);
  const axis = size.indexOf(Math.max(...size)) as 0 | 1 | 2;
  return kDirections[axis]![v[axis] < 0 ? 0 : 1];
}

function place(p: Vec3): string {
  const mm = p.map((value) => Math.round(1000 * value)) as Vec3;
  const words = [
    mm[0] === 0 ? '' : `${Math.abs(mm[0])} mm to the ${mm[0] < 0 ? 'left' : 'right'}`,
    mm[1] === 0 ? '' : `${Math.abs(mm[1])} mm ${mm[1] < 0 ? 'towards' : 'away from'} you`,
    mm[2] === 0 ? '' : `${Math.abs(mm[2])} mm ${mm[2] < 0 ? 'down' : 'up'}`,
  ].filter((word) => word !== '');
  if (words.length === 0) return "at the core's centre";
  const last = words.pop()!;
  return `${words.length > 0 ? `${words.join(', ')} and ${last}` : last} from the core's centre`;
}
