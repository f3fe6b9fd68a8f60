// node pictures.mjs FOLDER: pictures of omni try for the documents, and the animation of the README. What is shown is a
// run of the real service on the digital twin; only the pointer is a script. Takes two minutes.
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { root } from './support/setup.mjs';
import { animate } from './support/apng.mjs';
import { middleLine } from './support/track.mjs';
import { launch, Program, Visitor } from './support/trial.mjs';

const folder = process.argv[2];
const kWide = { width: 1280, height: 800 };
const kAnimated = { width: 640, height: 720 };
const kFrame = { width: 400, height: 320 }; // of the picture, around its middle
const kFrame_ms = 110;

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
const frames = [];

const began_ms = Date.now();
const log = (what) => console.log(`${((Date.now() - began_ms) / 1000).toFixed(0)} s: ${what}`);

const ready = (name) => visitor.until('scene-state', (text) => text.includes(name) && /ready/.test(text), `${name} is ready`, 120);

async function show(name) {
  await page.getByTestId(`scene-${name}`).click();
  await ready(name);
}

// Frames of what `motion` does, from the page's own replay: pictures take longer than the hand.
async function film(motion, count) {
  const timeline = page.getByTestId('timeline');
  const now = () => timeline.evaluate((slider) => Number(slider.max));
  const from = await now();
  await motion();
  const to = await now();
  log(`filmed ${(to - from).toFixed(1)} s`);
  await page.getByRole('button', { name: 'Measurements' }).click();
  await page.getByRole('button', { name: 'Replay', exact: true }).click();
  await page.getByRole('button', { name: 'Full detail' }).click();
  for (let i = 0; i < count; ++i) {
    await timeline.evaluate((slider, value) => {
      slider.value = String(value);
      slider.dispatchEvent(new Event('input'));
    }, from + ((to - from) * i) / (count - 1));
    await visitor.drawn();
    const { x, y, width, height } = await page.locator('#view').boundingBox();
    const clip = { x: x + (width - kFrame.width) / 2, y: y + 0.45 * (height - kFrame.height), ...kFrame };
    frames.push(await page.screenshot({ clip }));
  }
  await page.getByRole('button', { name: 'Full detail' }).click();
  await page.getByRole('button', { name: 'Live', exact: true }).click();
  await page.getByRole('button', { name: 'Measurements' }).click();
}

async function lift(steps, by) {
  for (let i = 0; i < steps; ++i) await visitor.lower(-by);
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
await visitor.pressOn('block', { force_N: 0.4 });
await shot('try-clay.png');
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

await page.emulateMedia({ colorScheme: 'light' });
await page.setViewportSize(kAnimated);
await show('extrusion');

// The animation: clay is taken and pulled out, the dragon gives way.
await film(async () => {
  await visitor.pressOn('block', { held: true });
  await lift(12, 2);
  await page.waitForTimeout(300);
  await lift(6, 5);
}, 18);
await visitor.release();
await show('dragon');
await visitor.until('soft-body', (text) => /ready/.test(text), 'its soft body is ready', 120);
await film(async () => {
  await touchDragon();
  await lift(8, 4);
}, 14);
await visitor.release();
writeFileSync(join(folder, 'try.png'), animate(frames, kFrame_ms));
log(`try.png, ${frames.length} frames`);

await visitor.close();
await browser.close();
await program.stop();
