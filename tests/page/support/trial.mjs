// Runs `omni try` or `omni monitor`, opens their page in headless Chromium (WebGL2 in software), and looks at it as a
// person does: pointer, keys, text.
import { spawn } from 'node:child_process';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { build, chromiumPath, fromTests, load } from './setup.mjs';
import { steer } from './track.mjs';

const kViewHeight = 334; // pixels
const kStick_m = 0.013; // from the middle to full deflection, nearly

// A program that prints "open ADDRESS". `cache`: a folder that may be shared, for soft bodies that take long to compute.
export class Program {
  static async start(words, environment = {}) {
    const program = new Program();
    program.folder = mkdtempSync(join(tmpdir(), 'omni-page-'));
    program.log = '';
    program.process = spawn(join(build, 'bin/omni'), [...words, '--no-open'], {
      env: { ...process.env, XDG_CONFIG_HOME: program.folder, XDG_STATE_HOME: program.folder, XDG_CACHE_HOME: join(build, 'tests/page/cache'), ...environment },
      stdio: ['ignore', 'pipe', 'pipe'],
    });
    program.ended = new Promise((resolve) => program.process.once('exit', (code) => resolve(code)));
    program.address = await new Promise((resolve, reject) => {
      const read = (data) => {
        program.log += data;
        const found = program.log.match(/open\s+(\S+)/);
        if (found) resolve(found[1]);
      };
      program.process.stdout.on('data', read);
      program.process.stderr.on('data', read);
      program.ended.then((code) => reject(new Error(`ended with ${code}: ${program.log}`)));
    });
    return program;
  }

  async stop() {
    this.process.kill('SIGINT');
    const code = await this.ended;
    rmSync(this.folder, { recursive: true, force: true });
    return code;
  }
}

export async function launch() {
  const { chromium } = fromTests('playwright-core');
  return chromium.launch({
    executablePath: chromiumPath(),
    args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
  });
}

// One page of a program. Its live messages are decoded beside it, for what no text says (where the car is, the aim).
export class Visitor {
  static async open(browser, address, options = {}) {
    const visitor = new Visitor();
    const { decode } = await load('decode.ts');
    visitor.context = await browser.newContext({ viewport: { width: 640, height: 560 }, ...options });
    visitor.page = await visitor.context.newPage();
    visitor.page.setDefaultTimeout(180_000); // a picture that a busy processor draws
    visitor.complaints = [];
    visitor.page.on('console', (message) => {
      if (message.type() === 'error') visitor.complaints.push(message.text());
    });
    visitor.page.on('pageerror', (error) => visitor.complaints.push(String(error)));
    visitor.page.on('websocket', (socket) => {
      socket.on('framereceived', ({ payload }) => {
        if (typeof payload === 'string') {
          const message = JSON.parse(payload);
          if (message.type === 'hello') visitor.hello = message;
          return;
        }
        const bytes = new Uint8Array(payload); // a copy: aligned
        const message = decode(bytes.buffer);
        if (message.kind === 'live') visitor.live = message.live;
        if (message.kind === 'surface' && message.surface.positions) {
          const { positions } = message.surface;
          visitor.highest = positions.reduce((most, value, i) => (i % 3 === 2 ? Math.max(most, value) : most), -1);
        }
      });
    });
    await visitor.page.goto(address);
    return visitor;
  }

  text(id) {
    return this.page.locator(`[data-testid="${id}"]`).first().textContent();
  }

  // The number in a text: "1.94 N" -> 1.94; NaN: there is none.
  async number(id) {
    return parseFloat(((await this.text(id)) ?? '').match(/-?\d+(\.\d+)?/)?.[0] ?? 'NaN');
  }

  // Waits until the text of an element holds.
  async until(id, holds, why, seconds = 30) {
    const end = Date.now() + 1000 * seconds;
    let text = '';
    while (Date.now() < end) {
      text = (await this.text(id)) ?? '';
      if (holds(text)) return text;
      await this.page.waitForTimeout(50);
    }
    throw new Error(`${why}: after ${seconds} s, "${id}" reads "${text}"`);
  }

  untilNumber(id, holds, why, seconds = 30) {
    return this.until(id, (text) => holds(parseFloat(text.match(/-?\d+(\.\d+)?/)?.[0] ?? 'NaN')), why, seconds);
  }

  // Drags on the 3-D view; the pointer stays down. Pixels from the middle of the view.
  async press(dx = 0, dy = 0) {
    await this.canvas.evaluate((element) => element.scrollIntoView({ block: 'center' }));
    const box = await this.canvas.boundingBox();
    this.pointer = { x: box.x + box.width / 2 + dx, y: box.y + box.height / 2 + dy };
    await this.page.mouse.move(this.pointer.x, this.pointer.y);
    await this.page.mouse.down();
  }
  async drag(dx, dy, steps = 8) {
    this.pointer = { x: this.pointer.x + dx, y: this.pointer.y + dy };
    await this.page.mouse.move(this.pointer.x, this.pointer.y, { steps });
  }
  release() {
    return this.page.mouse.up();
  }

  get canvas() {
    return this.page.locator('#view canvas').first();
  }

  // Takes the pen away and brings it again, by a press in the middle of the view. The pointer stays down.
  async bringPen(camera) {
    await this.page.getByRole('button', { name: camera, exact: true }).click();
    await this.canvas.focus();
    await this.page.keyboard.press('Delete');
    await this.until('tracked', (text) => /No pen/.test(text), 'the pen is taken away');
    await this.press();
    await this.until('tracked', (text) => /is tracked/.test(text), 'the pen is there');
  }

  // Straight down; a step is a pixel of a view of kViewHeight.
  async lower(steps) {
    const { height } = await this.canvas.boundingBox();
    await this.drag(0, (steps * height) / kViewHeight, 1);
  }

  // Waits until the page has drawn twice, however slowly it draws: its texts are of now.
  drawn() {
    return this.page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  }

  // Brings the pen and lowers it until it presses on something, or holds it. `seen`: called after each step.
  async pressOn(name, { force_N = Infinity, held = false, seen = async () => {} }) {
    await this.bringPen('Front');
    for (let i = 0; i < 60; ++i) {
      const touching = await this.text('touching');
      const touched = touching.includes(name);
      if (touched && (await this.number('force')) > force_N) return;
      if (held && /held/.test(touching)) return;
      // What is taken hold of moves in when it is pressed on: with enough force the hand waits.
      const waits = held && touched && (await this.number('force')) > 0.53;
      if (!waits) await this.lower(touched ? 2 : 4);
      await this.page.waitForTimeout(100);
      await this.drawn();
      await seen();
    }
    throw new Error(`${name} is not pressed: "${await this.text('touching')}", force ${await this.text('force')}`);
  }

  // Leads the pen as a stick that steers the car along a line, until `done`.
  async drive(line, seconds, done) {
    await this.bringPen('Top');
    // How far the aim moves for a pixel.
    await this.page.waitForTimeout(500);
    const first = this.live.aim.tip;
    await this.drag(40, 0, 4);
    await this.page.waitForTimeout(500);
    const scale = (this.live.aim.tip[0] - first[0]) / 40;
    if (!(scale > 0)) throw new Error('the aim does not follow the pointer to the right');
    const end = Date.now() + 1000 * seconds;
    while (Date.now() < end && !(await done())) {
      if (!this.live.vehicle) throw new Error('there is no car');
      const stick = steer(line, this.live.vehicle);
      const [x, y] = this.live.aim.tip;
      await this.drag((stick.x * kStick_m - x) / scale, -(stick.y * kStick_m - y) / scale, 1);
      await this.page.waitForTimeout(30);
    }
  }

  close() {
    return this.context.close();
  }
}
