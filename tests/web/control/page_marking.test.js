// Marking a control point by keyboard, in Chromium without a map: what is saved, and what is not. And points taken back.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { until } from '../support/browser.js';
import { allAsked, assertAccessible, options, usePages } from '../support/pages.js';

const { setUpFlight, setUpReady } = usePages();
const expected = { x: 30, y: 40 };

/** The dialog over a photo of 256 x 256 pixels, and what the server is sent. */
async function openDialog() {
  const { page, flight } = await setUpFlight('Meadow');
  await page.clock.install();
  /** @type {any[]} */
  const sent = [];
  await page.route('**/control', async (route) => {
    const is_read = route.request().method() === 'GET';
    if (!is_read) sent.push(route.request().postDataJSON().points[0].marks);
    const point = { name: 'P1', x: 7, y: 46, height: null, marks: is_read ? [] : sent[sent.length - 1] };
    await route.fulfill({ json: { reference_system: 'EPSG:4326', points: [point] }, headers: { ETag: `"${sent.length}"` } });
  });
  await page.evaluate(async ({ id, pixel }) => {
    document.head.append(/** @type {HTMLTemplateElement} */ (document.getElementById('open-parts')).content.cloneNode(true));
    const load = (/** @type {string} */ path) => import(new URL(`src/${path}`, location.href).href);
    await (await load('shared/flight_strings.js')).loadFlightStrings();
    const [{ ControlDocument }, { openMarking }] = await Promise.all([load('control/control_document.js'), load('control/marking_dialog.js')]);
    const control = new ControlDocument(id);
    await control.load();
    const photo = { record: { name: 'DJI_0001.JPG' }, url: `/api/v1/flights/${id}/files/DJI_0001.JPG`, pixel, off_vertical_deg: 3 };
    openMarking(control, 'P1', [photo], { residual_of: () => '', on_close: () => undefined });
  }, { id: flight.id, pixel: expected });
  await page.waitForSelector('#marking .viewer-image:not([hidden])');
  const marks = async () => {
    await page.clock.runFor(700);  // it is sent half a second after the last change
    await allAsked(page);
    return sent.length === 0 ? [] : sent[sent.length - 1];
  };
  const facts = () => page.textContent('#marking-facts');
  return { page, marks, facts, sent };
}

test('arrow keys move a cross and save nothing; Enter marks, Escape leaves', options, async () => {
  const { page, marks, facts, sent } = await openDialog();
  for (const key of ['ArrowRight', 'Shift+ArrowDown', 'Control+ArrowLeft']) await page.keyboard.press(key);
  assert.deepEqual(await marks(), [], 'a key alone says nothing of where the point is');
  assert.match((await facts()) ?? '', /pixel 30\.9, 50\.0: Enter/);
  const [cross, image] = [await page.locator('#marking-cross').boundingBox(), await page.locator('#marking .viewer-image').boundingBox()];
  const scale = image.width / 256;
  assert.ok(Math.hypot(cross.x + 20 - image.x - 31.4 * scale, cross.y + 20 - image.y - 50.5 * scale) < 1, JSON.stringify([cross, image]));
  await assertAccessible(page, 'marking by keyboard');
  await page.keyboard.press('Enter');
  const near = (/** @type {any} */ mark, /** @type {number} */ x, /** @type {number} */ y) => Math.hypot(mark.x - x, mark.y - y) < 1e-6;
  let [mark] = await marks();
  assert.ok(near(mark, 30.9, 50), JSON.stringify(mark));
  assert.ok(await page.locator('#marking-cross').isHidden());
  // From the mark on; Enter on a button is the button's; the pointer marks as it always did.
  await page.keyboard.press('Shift+ArrowRight');
  await page.focus('#marking-zoom-in');
  await page.keyboard.press('Enter');
  assert.equal((await marks()).length, 1);
  assert.equal(sent.length, 1, 'the mark is where it was');
  const box = await page.locator('#marking-view').boundingBox();
  await page.mouse.click(box.x + box.width / 2, box.y + box.height / 2);
  [mark] = await marks();
  assert.ok(!near(mark, 30.9, 50));
  assert.ok(await page.locator('#marking-cross').isHidden());
  await page.focus('#marking-view');
  await page.keyboard.press('ArrowUp');
  await page.keyboard.press('Escape');
  await page.waitForSelector('#marking', { state: 'detached' });
  assert.deepEqual(await marks(), [mark]);
  assert.equal(sent.length, 2);
});

test('a mark that is dragged is put where it is let go: until then nothing is saved, nor asked of the server', options, async () => {
  const { page, marks, sent } = await openDialog();
  const box = await page.locator('#marking-view').boundingBox();
  const middle = [box.x + box.width / 2, box.y + box.height / 2];
  await page.mouse.click(middle[0], middle[1]);
  const [before] = await marks();
  await page.mouse.down();
  await page.mouse.move(middle[0] + 20, middle[1]);
  const [dragged] = await marks();
  assert.deepEqual([sent.length, dragged], [1, before]);
  const shown = await page.locator('#marking-mark').boundingBox();
  assert.ok(Math.abs(shown.x + shown.width / 2 - middle[0] - 20) < 1, 'it is seen where the pointer is');
  await page.mouse.move(middle[0] + 30, middle[1]);
  await page.mouse.up();
  const [after] = await marks();
  assert.ok(sent.length === 2 && after.x > before.x, JSON.stringify([sent.length, before, after]));
  await page.keyboard.press('Control+z');
  assert.deepEqual(await marks(), [before], 'one step to undo');
});

test('a removed point comes back by its own Undo, and what was changed after it stays', options, async () => {
  const { page } = await setUpReady('Meadow');
  let kept = { reference_system: 'EPSG:4326', points: ['P1', 'P2', 'P3'].map((name, i) => ({ name, x: 7 + i / 1000, y: 46, height: null, marks: [] })) };
  let edition = 0;
  await page.route('**/control', async (route) => {
    if (route.request().method() !== 'GET') {
      kept = route.request().postDataJSON();
      edition += 1;
    }
    await route.fulfill({ json: kept, headers: { ETag: `"${edition}"` } });
  });
  await page.click('#control > summary');
  await page.waitForSelector('#control-points [data-point="P3"]');
  const shown = () => page.locator('#control-points [data-point]').evaluateAll((rows) => rows.map((row) => row.getAttribute('data-point')));
  for (const name of ['P1', 'P3']) await page.click(`#control-points [aria-label="Remove ${name}"]`);
  assert.deepEqual(await shown(), ['P2']);
  await page.click('.note:has-text("P1") .note-action');
  assert.deepEqual(await shown(), ['P1', 'P2']);
  await until(() => kept.points.map(({ name }) => name).join() === 'P1,P2');
  // The page is left without a question where the server has all of it, and only there.
  await page.waitForFunction(() => dispatchEvent(new Event('beforeunload', { cancelable: true })));
  assert.ok(await page.evaluate(() => {
    /** @type {HTMLElement} */ (document.querySelector('#control-points [aria-label="Remove P1"]')).click();
    return !dispatchEvent(new Event('beforeunload', { cancelable: true }));
  }));
});
