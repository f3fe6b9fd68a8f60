// node measure.mjs: how soon the page shows what the pointer does, what it costs to be watched. Figures are of the digital
// twin; those of the browser depend on how it draws (here a processor may). Prints lines; OMNI_BUILD: build tree.
import { spawnSync } from 'node:child_process';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { build } from './support/setup.mjs';
import { Reader } from './support/reader.mjs';
import { launch, Program, Visitor } from './support/trial.mjs';

const quantile = (values, q) => [...values].sort((a, b) => a - b)[Math.min(values.length - 1, Math.floor(q * values.length))];
const sleep = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

// Pointer event -> first live message with the new aim, and with the pen 1 mm further; in the page's own time.
async function latency() {
  const browser = await launch();
  const visitor = await Visitor.open(browser, 'about:blank');
  const { page } = visitor;
  await page.addInitScript(() => {
    const Real = WebSocket;
    globalThis.seen = [];
    globalThis.WebSocket = class extends Real {
      constructor(...words) {
        super(...words);
        this.addEventListener('message', ({ data }) => {
          if (typeof data === 'string') return;
          const view = new DataView(data);
          if (view.getUint16(4, true) !== 1) return;
          const count = view.getUint32(8, true);
          const channels = view.getUint32(12, true);
          const last = 496 + 8 * count + 4 * channels * (count - 1);
          globalThis.seen.push({
            t_ms: performance.now(),
            bytes: data.byteLength,
            aim_x: view.getFloat32(468, true),
            tip_x: count > 0 ? view.getFloat32(last, true) : NaN,
          });
        });
      }
    };
    addEventListener('pointermove', () => (globalThis.moved_ms = performance.now()), true);
  });
  const begin = Date.now();
  const program = await Program.start(['try', 'extrusion']);
  await page.goto(program.address);
  await visitor.until('tracked', (text) => /tracked|No pen/.test(text), 'the page shows the first frame');
  const first_ms = await page.evaluate(() => globalThis.seen[0].t_ms + performance.timeOrigin);
  console.log(`omni try: ${((first_ms - begin) / 1000).toFixed(2)} s from the command to the first live message, in a browser that runs`);
  await page.getByRole('button', { name: 'Top', exact: true }).click();
  await visitor.press();
  await visitor.until('tracked', (text) => /is tracked/.test(text), 'the pen is there');
  await sleep(1500);
  const aims = [];
  const pens = [];
  for (let i = 0; i < 60; ++i) {
    const before = await page.evaluate(() => globalThis.seen.at(-1));
    await visitor.drag(i % 2 === 0 ? 12 : -12, 0, 1);
    await sleep(400);
    const { moved_ms, seen } = await page.evaluate(() => ({ moved_ms: globalThis.moved_ms, seen: globalThis.seen.slice(-60) }));
    const later = seen.filter(({ t_ms }) => t_ms > moved_ms);
    const aim = later.find(({ aim_x }) => Math.abs(aim_x - before.aim_x) > 1e-4);
    const pen = later.find(({ tip_x }) => Math.abs(tip_x - before.tip_x) > 1e-3);
    if (aim) aims.push(aim.t_ms - moved_ms);
    if (pen) pens.push(pen.t_ms - moved_ms);
  }
  console.log(`pointer event to live message with the new aim: p50 ${quantile(aims, 0.5).toFixed(1)} ms, p99 ${quantile(aims, 0.99).toFixed(1)} ms (${aims.length})`);
  console.log(`... with the pen 1 mm further (arm and spring included): p50 ${quantile(pens, 0.5).toFixed(1)} ms, p99 ${quantile(pens, 0.99).toFixed(1)} ms (${pens.length})`);
  const window = await page.evaluate(async () => {
    const from = globalThis.seen.length;
    let frames = 0;
    const end = performance.now() + 5000;
    await new Promise((resolve) => {
      const frame = () => {
        ++frames;
        if (performance.now() < end) requestAnimationFrame(frame);
        else resolve();
      };
      requestAnimationFrame(frame);
    });
    const seen = globalThis.seen.slice(from);
    return { messages: seen.length / 5, bytes: seen.reduce((sum, { bytes }) => sum + bytes, 0) / 5, frames: frames / 5 };
  });
  console.log(`live messages ${window.messages.toFixed(1)}/s, ${(window.bytes / 1000).toFixed(0)} kB/s; frames drawn ${window.frames.toFixed(1)}/s`);
  await visitor.close();
  await browser.close();
  await program.stop();
}

// Tick times of omnid by its own histogram, over one run each.
async function ticks(readers, aims_Hz = 0) {
  const folder = mkdtempSync(join(tmpdir(), 'omni-measure-'));
  const program = await Program.start(['try', 'dragon'], { XDG_RUNTIME_DIR: folder });
  const open = Array.from({ length: readers }, () => Reader.open(program.address));
  const socket = program.log.match(/OMNI_SOCKET=(\S+)/)[1];
  await sleep(2000);
  const first = open[0];
  const end = Date.now() + 20_000;
  for (let i = 0; Date.now() < end; ++i) {
    if (aims_Hz === 0 || first === undefined) {
      await sleep(200);
      continue;
    }
    for (let k = 0; k < aims_Hz / 100; ++k) {
      const x = 0.01 * Math.sin(0.02 * (i * (aims_Hz / 100) + k));
      first.send(JSON.stringify({ type: 'aim', tip: [x, 0, 0.06], axis: [0, 0, -1] }));
    }
    await sleep(10);
  }
  const status = JSON.parse(
    spawnSync(join(build, 'bin/omni'), ['status', '--json'], { env: { ...process.env, OMNI_SOCKET: socket }, encoding: 'utf8' }).stdout,
  );
  const bytes = open.reduce((sum, reader) => sum + reader.bytes, 0);
  for (const reader of open) reader.close();
  await program.stop();
  rmSync(folder, { recursive: true, force: true });
  return { ...status.tick, bytes };
}

await latency();
for (let round = 0; round < 3; ++round) {
  for (const [readers, aims_Hz] of [[0, 0], [5, 0], [1, 1000]]) {
    const tick = await ticks(readers, aims_Hz);
    console.log(
      `${readers} readers${aims_Hz ? `, ${aims_Hz} aims/s` : ''}: tick median ${tick.us_median.toFixed(1)} us, p99 ${tick.us_p99.toFixed(1)} us, ` +
        `late ${tick.late} of ${tick.count}, ${(tick.bytes / 20_000).toFixed(0)} kB/s`,
    );
  }
}
