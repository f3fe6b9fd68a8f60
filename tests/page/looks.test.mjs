// What the page looks like to everybody: sizes, themes, screen readers; and what it says when something is wrong.
import assert from 'node:assert/strict';
import { spawn, spawnSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { build, fromTests } from './support/setup.mjs';
import { launch, Program, Visitor } from './support/trial.mjs';

let program, browser;

before(async () => {
  program = await Program.start(['try', 'extrusion']);
  browser = await launch();
});

after(async () => {
  await browser?.close();
  await program?.stop();
});

async function connected(options) {
  const visitor = await Visitor.open(browser, program.address, options);
  await visitor.until('connection', (text) => text.includes('Connected'), 'the page connects');
  await visitor.until('scene-state', (text) => /ready/.test(text), 'the scene is ready');
  return visitor;
}

for (const colorScheme of ['light', 'dark']) {
  test(`no serious finding of axe, ${colorScheme}; nothing is wider than its window`, async () => {
    const visitor = await connected({ colorScheme });
    await visitor.page.evaluate(readFileSync(fromTests.resolve('axe-core/axe.min.js'), 'utf8'));
    for (const width of [360, 800, 1440, 3840]) {
      await visitor.page.setViewportSize({ width, height: 600 });
      const [content, window] = await visitor.page.evaluate(() => [
        document.documentElement.scrollWidth, document.documentElement.clientWidth,
      ]);
      assert.ok(content <= window, `${content} > ${window}`);
      if (width !== 360 && width !== 1440) continue;
      const { violations } = await visitor.page.evaluate(() => globalThis.axe.run());
      const serious = violations.filter(({ impact }) => impact === 'serious' || impact === 'critical');
      assert.deepEqual(serious.map(({ id, nodes }) => `${width} px, ${id}: ${nodes[0].html}`), []);
    }
    await visitor.close();
  });
}

test('a page with a wrong token says what to do', async () => {
  const visitor = await Visitor.open(browser, program.address.replace(/token=./, (first) => (first === 'token=0' ? 'token=1' : 'token=0')));
  await visitor.until('banner', (text) => /open the address that it printed/.test(text), 'it says so');
  await visitor.close();
});

// The address bar, and so bookmarks and pictures of the screen, do not have the token; a reload works nevertheless.
test('the token leaves the address bar', async () => {
  const visitor = await connected({});
  assert.ok(!visitor.page.url().includes('token'));
  await visitor.page.reload();
  await visitor.until('connection', (text) => text.includes('Connected'), 'a reload connects');
  await visitor.close();
});

test('a page of omni monitor only looks, and stops', async () => {
  const socket = program.log.match(/OMNI_SOCKET=(\S+)/)[1];
  const monitor = await Program.start(['monitor'], { OMNI_SOCKET: socket });
  const visitor = await Visitor.open(browser, monitor.address);
  await visitor.until('connection', (text) => text.includes('Connected'), 'the page connects');
  await visitor.until('owner', (text) => /omni try/.test(text), 'it shows who has the pen');
  assert.equal(await visitor.page.getByTestId('scene-dragon').count(), 0, 'it offers no scenes');
  await visitor.page.getByTestId('stop').click();
  await visitor.until('problems', (text) => /emergency stop/i.test(text), 'the stop works');
  const omni = (words) => spawnSync(join(build, 'bin/omni'), words, { env: { ...process.env, OMNI_SOCKET: socket } });
  assert.equal(omni(['stop', '--release']).status, 0);
  await visitor.until('problems', (text) => !/emergency stop/i.test(text), 'it is released');
  await visitor.close();
  assert.equal(await monitor.stop(), 0);
});

test('a page of omni monitor shows the steps of omni setup', async () => {
  const environment = { OMNI_SOCKET: program.log.match(/OMNI_SOCKET=(\S+)/)[1] };
  const monitor = await Program.start(['monitor'], environment);
  const visitor = await Visitor.open(browser, monitor.address);
  await visitor.until('card-setup', (text) => /\d of 6 done/.test(text), 'it counts those that are done');
  await visitor.page.getByTestId('card-setup').evaluate((card) => { card.open = true; });
  await visitor.until('setup-steps', (text) => /omnid has the device .*, a simulation/.test(text), 'omnid has a device');
  const listed = spawnSync(join(build, 'bin/omni'), ['setup', '--json'], { env: { ...process.env, ...environment } });
  const titles = JSON.parse(listed.stdout).map(({ title }) => title);
  assert.deepEqual(await visitor.page.locator('.setup-title').allTextContents(), titles);
  assert.equal(titles.length, 8);
  await visitor.close();
  assert.equal(await monitor.stop(), 0);
});

test('a service that goes is named, and its page says so', async () => {
  const monitor = await Program.start(['monitor'], { OMNI_SOCKET: '/nowhere/omnid.sock' });
  const visitor = await Visitor.open(browser, monitor.address);
  await visitor.until('connection', (text) => !text.includes('Connected'), 'there is no service');
  await visitor.until('banner', (text) => /omnid/.test(text), 'it says what to do');
  await monitor.stop();
  await visitor.until('banner', (text) => /omni has ended|no connection/i.test(text), 'omni has ended');
  await visitor.close();
});

test('an omnid that is killed is named, and its next start is shown without a reload', async () => {
  const folder = mkdtempSync(join(tmpdir(), 'omni-page-'));
  const socket = join(folder, 'omnid.sock');
  const start = () => {
    const omnid = spawn(join(build, 'bin/omnid'), ['--device', 'twin', '--socket', socket], { stdio: 'ignore' });
    omnid.over = new Promise((resolve) => omnid.once('exit', resolve));
    return omnid;
  };
  const first = start();
  const monitor = await Program.start(['monitor', '--socket', socket]);
  const visitor = await Visitor.open(browser, monitor.address);
  await visitor.until('connection', (text) => text.includes('Connected'), 'the page connects');
  first.kill('SIGKILL');
  await visitor.until('banner', (text) => /omnid/.test(text), 'it says what is missing');
  await visitor.page.getByTestId('stop').click();
  await visitor.page.getByText(/NOT STOPPED/).first().waitFor({ timeout: 10_000 });
  const second = start();
  await visitor.until('connection', (text) => text.includes('Connected'), 'the page shows the next one');
  await visitor.close();
  await monitor.stop();
  second.kill('SIGTERM');
  assert.equal(await second.over, 0);
  rmSync(folder, { recursive: true });
});

test('omni try ends with its omnid, and its page says so', async () => {
  const trial = await Program.start(['try', 'extrusion']);
  const visitor = await Visitor.open(browser, trial.address);
  await visitor.until('connection', (text) => text.includes('Connected'), 'the page connects');
  const { pid } = trial.process;
  process.kill(Number(readFileSync(`/proc/${pid}/task/${pid}/children`, 'utf8').trim()), 'SIGKILL');
  assert.equal(await trial.ended, 1);
  assert.match(trial.log, /omnid was ended by signal 9/);
  await visitor.until('banner', (text) => /omni has ended|no connection/i.test(text), 'the page says so');
  await visitor.close();
  await trial.stop();
});

test('a taken port is named', () => {
  const port = new URL(program.address).port;
  const taken = spawnSync(join(build, 'bin/omni'), ['monitor', '--port', port, '--no-open'], { encoding: 'utf8' });
  assert.equal(taken.status, 1);
  assert.match(taken.stderr, new RegExp(`port ${port} of 127.0.0.1`));
});
