// node naive.mjs [TIMES [VIEW]]: a visitor who knows nothing of Omni opens omni try, presses on the picture, drags straight
// down and waits; on clay he then drags up again. Judged by the twin's own record of the truth. Ten times each: half an
// hour. Figures are simulated.
import { createReadStream, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { createInterface } from 'node:readline';
import { launch, Program, Visitor } from './support/trial.mjs';

const kScenes = { extrusion: 'clay', dragon: 'dragon' };
const kViews = process.argv[3] ? [process.argv[3]] : ['default', 'Front'];
const kDown_px = [45, 60, 110];
const kWindow = { width: 1280, height: 800 };
const kUp_px = 150; // above where he began: the face comes along
const kDrag_ms = 700; // of a calm hand
const kWait_ms = 2200;
const kFelt_N = 0.5;
const kPulled_m = 1e-3;
const kBlock_m = 0.045; // the clay's top, as it comes

const times = Number(process.argv[2] ?? 10);
const record = join(tmpdir(), `omni-naive-${process.pid}.csv`);
const now_s = () => Number(process.hrtime.bigint()) * 1e-9; // CLOCK_MONOTONIC, as the record has it

// A pointer that moves as a hand does, and not in one leap.
async function drag(visitor, dy_px, duration_ms) {
  const from = visitor.pointer.y;
  const begin_s = now_s();
  for (let share = 0; share < 1;) {
    share = Math.min(1, (1e3 * (now_s() - begin_s)) / duration_ms); // in real time, however slowly the page draws
    await visitor.page.mouse.move(visitor.pointer.x, from + dy_px * share * share * (3 - 2 * share));
    await visitor.page.waitForTimeout(15);
  }
  visitor.pointer.y = from + dy_px;
}

async function visit(visitor, scene, view, down_px) {
  const { page } = visitor;
  await page.getByTestId(`scene-${scene}`).click();
  await visitor.until('scene-state', (text) => text.includes(scene) && /ready/.test(text), `${scene} is ready`, 120);
  if (view !== 'default') await page.getByRole('button', { name: view, exact: true }).click();
  await visitor.canvas.focus();
  await page.keyboard.press('Delete'); // as if no one had been here before
  await visitor.until('tracked', (text) => /No pen/.test(text), 'the pen is taken away');
  await page.waitForTimeout(300);
  await visitor.press();
  await page.waitForTimeout(1200); // looks
  visitor.highest = kBlock_m;
  const from_s = now_s();
  await drag(visitor, down_px, kDrag_ms);
  await page.waitForTimeout(kWait_ms);
  const to_s = now_s();
  if (scene === 'extrusion') await drag(visitor, -down_px - kUp_px, kDrag_ms);
  for (let i = 0; i < 30 && !(visitor.highest - kBlock_m > kPulled_m); ++i) await page.waitForTimeout(100); // drawn late
  const pulled_m = visitor.highest - kBlock_m;
  await visitor.release();
  return { scene, view, down_px, from_s, to_s, pulled_m };
}

// Seconds of each visit with a force that is felt, and the largest.
async function judge(visits) {
  let names = null; // a row a millisecond: too long to hold
  let last_s = NaN;
  let [t, x] = [0, 0];
  for await (const row of createInterface({ input: createReadStream(record) })) {
    if (names === null) {
      names = row.split(',');
      [t, x] = [names.indexOf('t_ns'), names.indexOf('coil_force_x_N')];
      continue;
    }
    const values = row.split(',').map(Number);
    const t_s = 1e-9 * values[t];
    const force_N = Math.hypot(...values.slice(x, x + 3));
    for (const visit of visits) {
      if (t_s < visit.from_s || t_s > visit.to_s) continue;
      visit.most_N = Math.max(visit.most_N ?? 0, force_N);
      if (force_N >= kFelt_N) visit.felt_s = (visit.felt_s ?? 0) + Math.min(t_s - last_s, 0.01);
    }
    last_s = t_s;
  }
}

const program = await Program.start(['try', 'extrusion', '--twin-record', record]);
const browser = await launch();
const visits = [];
for (const view of kViews) {
  for (const scene of Object.keys(kScenes)) {
    const visitor = await Visitor.open(browser, program.address, { viewport: kWindow }); // the view as it comes
    await visitor.until('connection', (text) => text.includes('Connected'), 'the page connects');
    for (const down_px of kDown_px) {
      for (let i = 0; i < times; ++i) visits.push(await visit(visitor, scene, view, down_px));
    }
    await visitor.close();
  }
}
await browser.close();
await program.stop();
await judge(visits);
rmSync(record);
console.log(`| scene | view | down, px | felt ${kFelt_N} N for 1 s | median of the largest, N | pulled |`);
console.log('|---|---|---|---|---|---|');
for (const view of kViews) {
  for (const [scene, name] of Object.entries(kScenes)) {
    for (const down_px of kDown_px) {
      const these = visits.filter((v) => v.scene === scene && v.view === view && v.down_px === down_px);
      const felt = these.filter((v) => (v.felt_s ?? 0) >= 1).length;
      const most = these.map((v) => v.most_N ?? 0).sort((a, b) => a - b)[Math.floor(these.length / 2)];
      const pulled = scene === 'extrusion' ? these.filter((v) => v.pulled_m > kPulled_m).length : '-';
      console.log(`| ${name} | ${view} | ${down_px} | ${felt} of ${these.length} | ${most.toFixed(2)} | ${pulled} |`);
    }
  }
}
