// node pictures.mjs FOLDER: pictures of omni try for the documents. What is shown is a run of the real service on the
// digital twin; only the pointer is a script. Takes two minutes.
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { root } from './support/setup.mjs';
import { middleLine } from './support/track.mjs';
import { launch, Program, Visitor } from './support/trial.mjs';

const folder = process.argv[2];
const kBlock_m = 0.045; // the clay's top, as it comes
const kFinger_m = 0.007; // the last step goes further
const kWide = { width: 1280, height: 800 };

const program = await Program.start(['try', 'extrusion']);
const browser = await launch();
const visitor = await Visitor.open(browser, program.address, { viewport: kWide });
const { page } = visitor;
const shot = async (name) => {
  // By script: the pointer stays where it is, on the pen.
  const detail = () => page.getByRole('button', { name: 'Full detail' }).evaluate((button) => button.click());
  await detail();
  await visitor.drawn();
  await page.waitForTimeout(500);
  writeFileSync(join(folder, name), await page.screenshot());
  await detail();
  log(name);
};

const began_ms = Date.now();
const log = (what) => console.log(`${((Date.now() - began_ms) / 1000).toFixed(0)} s: ${what}`);

const ready = (name) => visitor.until('scene-state', (text) => text.includes(name) && /ready/.test(text), `${name} is ready`, 120);

async function show(name) {
  await page.getByTestId(`scene-${name}`).click();
  await ready(name);
}

// Draws the clay's highest point out to `height_m` over its top.
async function pullOut(height_m) {
  for (let i = 0; i < 200 && !(visitor.highest - kBlock_m > height_m); ++i) {
    await visitor.lower(-1.6);
    await page.waitForTimeout(50);
  }
}

async function touchDragon() {
  await visitor.bringPen('Front');
  for (let i = 0; i < 8; ++i) {
    await visitor.lower(4);
    await page.waitForTimeout(150);
  }
}

await visitor.until('connection', (text) => text.includes('Connected'), 'the page connects');
await ready('extrusion');

await show('extrusion');
await visitor.pressOn('block', { held: true });
await pullOut(kFinger_m);
await shot('try.png');
await visitor.release();

await show('dragon');
await touchDragon();
await shot('try-dragon.png');
await visitor.release();

await show('racetrack');
await visitor.drive(middleLine(join(root, 'scenes/racetrack.glb')), 14, () => false);
await shot('try-race.png');
await visitor.release();

await page.emulateMedia({ colorScheme: 'dark' });
await show('dragon');
await touchDragon();
await shot('try-dark.png');
await visitor.release();
await page.setViewportSize({ width: 360, height: 780 });
await page.waitForTimeout(800);
await shot('try-phone.png');

await visitor.close();
await browser.close();
await program.stop();
