// node pictures.mjs FOLDER: pictures of omni try for the documents, and the animation of the README. What is shown is a
// run of the real service on the digital twin; only the pointer is a script.
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { root } from './support/setup.mjs';
import { animate } from './support/apng.mjs';
import { middleLine } from './support/track.mjs';
import { launch, Program, Visitor } from './support/trial.mjs';

const folder = process.argv[2];
const kWidth = 1280;
const kHeight = 800;

const program = await Program.start(['try', 'extrusion']);
const browser = await launch();
const visitor = await Visitor.open(browser, program.address, { viewport: { width: kWidth, height: kHeight } });
const { page } = visitor;
const ready = (name) => visitor.until('scene-state', (text) => text.includes(name) && /ready/.test(text), `${name} is ready`, 120);

const shot = async (name) => writeFileSync(join(folder, name), await page.screenshot());

await visitor.until('connection', (text) => text.includes('Connected'), 'the page connects');
await ready('extrusion');
await page.getByRole('button', { name: 'Full detail' }).click();
const frames = [];
const frame = async () => frames.push(await page.locator('#view').screenshot());
await visitor.pressOn('block', 0.5);
for (let i = 0; i < 14; ++i) {
  await visitor.lower(-3);
  await frame();
}
await visitor.release();
await page.waitForTimeout(800);
await shot('try-clay.png');

await page.getByTestId('scene-dragon').click();
await ready('dragon');
await visitor.until('soft-body', (text) => /ready/.test(text), 'its soft body is ready', 120);
await visitor.bringPen('Front');
for (let i = 0; i < 26; ++i) {
  await visitor.lower(3);
  if (i > 4) await frame();
}
await shot('try-dragon.png');
for (let i = 0; i < 8; ++i) {
  await visitor.lower(-6);
  await frame();
}
await visitor.release();

await page.getByTestId('scene-racetrack').click();
await ready('racetrack');
await visitor.drive(middleLine(join(root, 'scenes/racetrack.glb')), 14, () => false);
await shot('try-race.png');
await visitor.release();

await page.emulateMedia({ colorScheme: 'dark' });
await page.getByTestId('scene-dragon').click();
await ready('dragon');
await visitor.pressOn('dragon', 0.4);
await page.waitForTimeout(600);
await shot('try-dark.png');
await visitor.release();
await page.setViewportSize({ width: 360, height: 780 });
await page.waitForTimeout(800);
await shot('try-phone.png');

writeFileSync(join(folder, 'try.png'), animate(frames, 120));
console.log(`${frames.length} frames, ${frames.reduce((sum, { length }) => sum + length, 0)} bytes`);
await visitor.close();
await browser.close();
await program.stop();
