// node measure.mjs: how soon the page shows what the pointer does, and what it costs to be watched. Prints lines; takes nine
// minutes. Figures are of the digital twin; those of the browser depend on how it draws (here a processor may).
import { spawn } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
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

// The tick with and without something else, in turns of a few seconds in one run of omnid: columns tick_us and t_monotonic_s
// of `omni monitor --csv`. `begin` starts it and returns what ends it; the first half second after a change is left out.
async function compare(name, scene, begin, turns = 24, turn_ms = 4000) {
  const folder = mkdtempSync(join(tmpdir(), 'omni-measure-'));
  const program = await Program.start(['try', scene], { XDG_RUNTIME_DIR: folder });
  const socket = program.log.match(/OMNI_SOCKET=(\S+)/)[1];
  await sleep(6000);
  const file = join(folder, 'ticks.csv');
  const log = spawn(join(build, 'bin/omni'), ['monitor', '--csv', file, '--socket', socket], { stdio: 'ignore' });
  const ended = new Promise((resolve) => log.once('exit', resolve));
  await sleep(500);
  const spans = [];
  for (let i = 0; i < turns; ++i) {
    const on = i % 4 === 1 || i % 4 === 2; // off on on off: a drift falls on both alike
    const end = on ? await begin({ program, socket }) : () => {};
    await sleep(500);
    const from_s = Number(process.hrtime.bigint()) * 1e-9; // CLOCK_MONOTONIC
    await sleep(turn_ms);
    spans.push({ on, from_s, to_s: Number(process.hrtime.bigint()) * 1e-9, ticks: [] });
    await end();
  }
  log.kill('SIGINT');
  await ended;
  const [header, ...rows] = readFileSync(file, 'utf8').trim().split('\n');
  const names = header.split(',');
  const [time, tick] = [names.indexOf('t_monotonic_s'), names.indexOf('tick_us')];
  let span = 0;
  for (const row of rows) {
    const values = row.split(',');
    const t_s = Number(values[time]);
    while (span < spans.length && t_s > spans[span].to_s) ++span;
    if (span < spans.length && t_s > spans[span].from_s) spans[span].ticks.push(Number(values[tick]));
  }
  await program.stop();
  rmSync(folder, { recursive: true, force: true });
  // Of each turn its quantile, then the median over turns; +-: standard error of the mean ratio of neighbours.
  const said = [0.5, 0.99].map((q) => {
    const of = spans.map(({ on, ticks }) => ({ on, value: quantile(ticks, q) }));
    const ratios = [];
    for (let i = 0; i + 1 < of.length; i += 2) {
      const [a, b] = of[i].on ? [of[i + 1], of[i]] : [of[i], of[i + 1]];
      ratios.push(Math.log(b.value / a.value));
    }
    const mean = ratios.reduce((sum, r) => sum + r, 0) / ratios.length;
    const error = Math.sqrt(ratios.reduce((sum, r) => sum + (r - mean) ** 2, 0) / (ratios.length - 1) / ratios.length);
    const middle = (on) => quantile(of.filter((turn) => turn.on === on).map(({ value }) => value), 0.5);
    return (
      `${q === 0.5 ? 'median' : 'p99'} ${middle(false).toFixed(1)} us without, ${middle(true).toFixed(1)} us with, ` +
      `ratio ${Math.exp(mean).toFixed(3)} +- ${error.toFixed(3)}`
    );
  });
  const ticks = spans.reduce((sum, turn) => sum + turn.ticks.length, 0);
  console.log(`${name}: ${said.join('; ')} (${turns} turns, ${ticks} ticks)`);
}

function readers(count) {
  return async ({ program }) => {
    const open = Array.from({ length: count }, () => Reader.open(program.address));
    return () => open.forEach((reader) => reader.close());
  };
}

// One page that sends 1000 aims a second.
async function aims({ program }) {
  const reader = Reader.open(program.address);
  let sent = 0;
  const timer = setInterval(() => {
    for (let k = 0; k < 10; ++k) {
      const x = 0.01 * Math.sin(0.002 * ++sent);
      reader.send(JSON.stringify({ type: 'aim', tip: [x, 0, 0.06], axis: [0, 0, -1] }));
    }
  }, 10);
  return () => {
    clearInterval(timer);
    reader.close();
  };
}

// A client that draws the surfaces, without a page.
async function surfaces({ socket }) {
  const drawing = spawn(join(build, 'bin/omni'), ['surfaces', '--socket', socket], { stdio: 'ignore' });
  const ended = new Promise((resolve) => drawing.once('exit', resolve));
  return () => {
    drawing.kill('SIGINT');
    return ended;
  };
}

await latency();
await compare('nothing (the spread of equal turns)', 'dragon', async () => () => {});
await compare('5 readers', 'dragon', readers(5));
await compare('20 readers', 'dragon', readers(20));
await compare('surfaces published', 'dragon', surfaces);
await compare('1000 aims/s', 'dragon', aims);
