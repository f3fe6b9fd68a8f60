// The colours of the view, light and dark. Blue and orange, violet and yellow stay apart for colour-blind people.
import { Color } from 'three';

export interface Palette {
  skyTop: Color; // behind everything
  skyBottom: Color;
  desk: Color;
  gridFine: Color;
  gridCoarse: Color;
  label: Color; // on the desk and in the caption
  text: Color;
  shadow: number; // opacity on the desk
  glass: Color; // the base's plastic
  glassRim: Color;
  iron: Color;
  copper: Color; // a winding without current
  negative: Color; // current
  positive: Color;
  sensor: Color;
  penBody: Color;
  penLost: Color; // not tracked
  accent: Color; // what is measured of the pen: its ring, trail and uncertainty
  hand: Color; // what the hand wants: ghost and spring
  force: Color;
  proxy: Color;
  sky: Color; // light from above ...
  ground: Color; // ... and from below
  environment: number; // strength of reflections
}

function colours(of: Record<Exclude<keyof Palette, 'shadow' | 'environment'>, string>) {
  const out: Partial<Record<keyof Palette, Color>> = {};
  for (const [name, text] of Object.entries(of)) out[name as keyof Palette] = new Color(text);
  return out as Record<keyof typeof of, Color>;
}

export const kLight: Palette = {
  ...colours({
    skyTop: '#f6f8fb',
    skyBottom: '#dbe3ec',
    desk: '#f3f6f9',
    gridFine: '#cdd6e0',
    gridCoarse: '#a7b5c4',
    label: '#566577',
    text: '#17212b',
    glass: '#9db1c6',
    glassRim: '#4f6a86',
    iron: '#6a717b',
    copper: '#a9a39b',
    negative: '#1769e0',
    positive: '#f07d00',
    sensor: '#0b8f82',
    penBody: '#525d6b',
    penLost: '#9aa3ad',
    accent: '#0b9d8f',
    hand: '#6d4aff',
    force: '#d81e5b',
    proxy: '#f5b800',
    sky: '#ffffff',
    ground: '#b9c2cd',
  }),
  shadow: 0.2,
  environment: 0.55,
};

export const kDark: Palette = {
  ...colours({
    skyTop: '#0e1218',
    skyBottom: '#1b232e',
    desk: '#1c242f',
    gridFine: '#2b3643',
    gridCoarse: '#43525f',
    label: '#9aa9b9',
    text: '#e7ecf2',
    glass: '#5b7894',
    glassRim: '#b5d0ea',
    iron: '#7b8490',
    copper: '#7f7a74',
    negative: '#3f8cff',
    positive: '#ff9326',
    sensor: '#35e0cc',
    penBody: '#dfe5ec',
    penLost: '#5c6672',
    accent: '#2ad7c3',
    hand: '#a18bff',
    force: '#ff4d83',
    proxy: '#ffd23f',
    sky: '#dfe9f5',
    ground: '#2a323c',
  }),
  shadow: 0.5,
  environment: 0.4,
};
