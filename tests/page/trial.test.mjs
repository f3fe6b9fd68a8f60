// omni try as a visitor has it: the real service, the digital twin in its room, a browser. Figures are simulated.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { root } from './support/setup.mjs';
import { middleLine } from './support/track.mjs';
import { launch, Program, Visitor } from './support/trial.mjs';

let program, browser, visitor;

before(async () => {
  program = await Program.start(['try', 'extrusion']);
  browser = await launch();
  visitor = await Visitor.open(browser, program.address);
  await visitor.until('connection', (text) => text.includes('Connected'), 'the page connects');
});

after(async () => {
  await visitor?.close();
  await browser?.close();
  assert.equal(await program?.stop(), 0, 'Ctrl-C ends it');
});

// A hand in real time, on a machine that draws with its processor: what slips is tried again, as a person does.
function scenario(name, run) {
  test(name, async (t) => {
    for (let attempt = 1; ; ++attempt) {
      try {
        await run();
        return;
      } catch (error) {
        if (attempt === 3) throw error;
        t.diagnostic(`attempt ${attempt}: ${error.message}`);
      } finally {
        await visitor.release();
      }
    }
  });
}

scenario('clay is pressed, taken hold of and pulled', async () => {
  await visitor.page.getByTestId('scene-extrusion').click();
  await visitor.until('scene-state', (text) => /extrusion.*ready/.test(text), 'the scene is ready');
  await visitor.until('strokes', (text) => text === '0 strokes', 'the clay is as it came');
  visitor.highest = 0.045;
  await visitor.pressOn('block', { held: true });
  for (let i = 0; i < 5; ++i) {
    await visitor.lower(-6);
    await visitor.page.waitForTimeout(30);
  }
  await visitor.release();
  for (let i = 0; i < 20 && !(visitor.highest > 0.046); ++i) await visitor.page.waitForTimeout(100);
  const top_mm = 1e3 * visitor.highest;
  assert.ok(top_mm > 46, `the face came along: its highest point is at ${top_mm.toFixed(1)} mm, was at 45`);
  await visitor.until('strokes', (text) => parseInt(text, 10) >= 1, 'a stroke is made');
});

scenario('the dragon is dented', async () => {
  await visitor.page.getByTestId('scene-dragon').click();
  await visitor.until('scene-state', (text) => /dragon.*ready/.test(text), 'the scene is ready');
  await visitor.until('soft-body', (text) => !/comput/.test(text), 'its soft body is ready', 120);
  await visitor.pressOn('dragon', { force_N: 0.35 }); // a slow loop offers a softer dragon
  await visitor.untilNumber('dent', (dent) => dent > 0.3, 'the dragon gives way', 5);
  await visitor.release();
});

scenario('a lap is driven', async () => {
  await visitor.page.getByTestId('scene-racetrack').click();
  await visitor.until('scene-state', (text) => /racetrack.*ready/.test(text), 'the scene is ready');
  const line = middleLine(join(root, 'scenes/racetrack.glb'));
  await visitor.drive(line, 60, async () => (await visitor.number('laps')) >= 1);
  assert.ok((await visitor.number('laps')) >= 1, 'a lap is finished');
  await visitor.release();
});

test('a foreign model is dropped and touched', async () => {
  const bytes = [...readFileSync(join(root, 'scenes/dragon.glb'))];
  const transfer = await visitor.page.evaluateHandle((content) => {
    const data = new DataTransfer();
    data.items.add(new File([new Uint8Array(content)], 'my model.glb'));
    return data;
  }, bytes);
  await visitor.page.dispatchEvent('body', 'drop', { dataTransfer: transfer });
  await visitor.until('scene-state', (text) => /my model\.glb.*ready/.test(text), 'the model is ready');
});

test('a file that is no model is named', async () => {
  const transfer = await visitor.page.evaluateHandle(() => {
    const data = new DataTransfer();
    data.items.add(new File(['no model'], 'picture.glb'));
    return data;
  });
  await visitor.page.dispatchEvent('body', 'drop', { dataTransfer: transfer });
  await visitor.until('notices', (text) => /picture\.glb/.test(text), 'the page says what is wrong');
});

scenario('by keyboard alone: clay is touched, and the stop stops', async () => {
  if (/emergency stop/i.test(await visitor.text('problems'))) await visitor.page.getByTestId('stop').click();
  await visitor.page.getByTestId('scene-extrusion').focus();
  await visitor.page.keyboard.press('Enter');
  await visitor.until('scene-state', (text) => /extrusion.*ready/.test(text), 'the scene is ready');
  await visitor.canvas.focus();
  await visitor.page.keyboard.press('Home');
  for (let i = 0; i < 200 && !/block/.test(await visitor.text('touching')); ++i) {
    await visitor.page.keyboard.press('PageDown');
    await visitor.page.waitForTimeout(60);
  }
  await visitor.until('touching', (text) => /block/.test(text), 'the block is touched');
  for (let i = 0; i < 60 && !((await visitor.number('force')) > 0.5); ++i) {
    await visitor.page.keyboard.press('PageDown');
    await visitor.page.waitForTimeout(100);
  }
  await visitor.untilNumber('force', (force) => force > 0.3, 'the surface pushes back');
  await visitor.page.keyboard.press('F9');
  await visitor.untilNumber('force', (force) => force === 0, 'no force after the emergency stop');
  await visitor.until('problems', (text) => /emergency stop/i.test(text), 'the page says so');
  await visitor.page.waitForTimeout(1600); // a press in panic does not release it at once
  await visitor.page.getByTestId('stop').focus();
  await visitor.page.keyboard.press('Enter');
  await visitor.untilNumber('force', (force) => force > 0.03, 'it pushes again after the release');
});

test('a slider changes the material, and a copy of the scene keeps it', async () => {
  await visitor.page.getByTestId('card-feel').evaluate((card) => (card.open = true)); // closed where there is little room
  const number = visitor.page.getByTestId('number-stiffness');
  await number.fill('210');
  await number.press('Enter');
  await visitor.page.waitForTimeout(300);
  const waiting = visitor.page.waitForEvent('download');
  await visitor.page.locator('#save').click();
  const download = await waiting;
  const bytes = readFileSync(await download.path());
  const json = JSON.parse(bytes.subarray(20, 20 + bytes.readUInt32LE(12)).toString('utf8'));
  const saved = json.materials.map(({ extensions }) => extensions?.OMNI_haptic_material?.stiffness);
  assert.ok(saved.includes(210), JSON.stringify(json.materials));
  assert.match(download.suggestedFilename(), /\.glb$/);
});

test('nothing was complained of', () => assert.deepEqual(visitor.complaints, []));
