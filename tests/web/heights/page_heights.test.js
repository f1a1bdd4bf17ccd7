// The height profile of a measured distance, in Chromium against the mock server.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { chartRange, knownRuns, roundTicks, sampleNear } from '../../../web/src/heights/height_chart.js';
import { loadFlightStrings } from '../../../web/src/shared/flight_strings.js';
import { heightIn } from '../../../web/src/shared/units.js';
import { kPhone, mapIdle, openMap, until } from '../support/browser.js';
import { allAsked, assertAccessible, options, usePages } from '../support/pages.js';

await loadFlightStrings();
const { setUp, setUpReady } = usePages();
const laptop = { viewport: { width: 1440, height: 900 }, locale: 'de-CH' };
const phone = { ...kPhone, locale: 'de-CH' };

test('ticks are round and lie within what the chart shows', () => {
  assert.deepEqual(roundTicks(540.3, 566.1), [550, 560]);
  assert.deepEqual(roundTicks(0, 1.1).map((tick) => Number(tick.toFixed(6))), [0, 0.5, 1]);
  assert.deepEqual(roundTicks(-12, -3), [-10, -5]);
  for (const [low, high] of [[0.001, 0.0021], [431.2, 432.3], [-3, 900], [8848, 8850.2]]) {
    const ticks = roundTicks(low, high);
    assert.ok(ticks.length >= 1 && ticks.length <= 5, `${low} ${high}: ${ticks}`);
    assert.ok(ticks.every((tick) => tick >= low - 1e-9 && tick <= high + 1e-9));
  }
});

test('level ground does not look like mountains', () => {
  const [low, high] = chartRange(540.01, 540.03);
  assert.ok(high - low >= 1);
  const [lowest, highest] = chartRange(540, 565);
  assert.ok(lowest < 540 && highest > 565 && highest - lowest < 30);
});

test('a gap parts the line, and the sample nearest to a distance is found', () => {
  const samples = [0, 1, 2, 3, 4].map((distance_m) => ({ distance_m, lon: 0, lat: 0, height_m: distance_m === 2 ? null : 5 }));
  assert.deepEqual(knownRuns(samples).map((run) => run.length), [2, 2]);
  assert.deepEqual(knownRuns([]), []);
  assert.deepEqual([-3, 0.4, 0.6, 2.2, 3.9, 99].map((distance_m) => sampleNear(samples, distance_m).distance_m), [0, 0, 1, 2, 4, 4]);
});

test('heights have a decimetre and no minus before a zero', () => {
  assert.equal(heightIn(-0.04, 'metric'), '0.0\u00a0m');
  assert.equal(heightIn(-12.34, 'metric'), '-12.3\u00a0m');
  assert.equal(heightIn(30.48, 'imperial'), '100.0\u00a0ft');
  assert.equal(heightIn(550, 'metric', [550, 560]), '550\u00a0m');
  assert.equal(heightIn(550, 'metric', [550, 550.5]), '550.0\u00a0m');
});

/** @param {any} page @param {[number, number][]} at shares of the map's size */
async function clickMap(page, at) {
  // On a phone the map has less room while one measures.
  await page.waitForFunction(() => document.querySelector('.maplibregl-canvas')?.clientHeight === document.querySelector('#map')?.clientHeight);
  const box = await page.locator('.maplibregl-canvas').boundingBox();
  for (const [x, y] of at) {
    const [left, top] = [box.x + x * box.width, box.y + y * box.height];
    // On a phone the panel makes room first.
    await page.waitForFunction(([from_left, from_top]) => document.elementFromPoint(from_left, from_top)?.closest('.maplibregl-canvas-container'), [left, top]);
    await page.mouse.click(left, top);
  }
}

test('a distance has the heights of the ground below it; pointer and keys show the place on the map', options, async () => {
  const { page, flight } = await setUpReady('Hill', {}, laptop);
  await page.selectOption('#language', 'en').catch(() => undefined);
  await page.waitForSelector('#tool-distance');
  await mapIdle(page);
  await page.click('#tool-distance');
  assert.equal(await page.isVisible('#heights'), false);
  await clickMap(page, [[0.35, 0.5], [0.65, 0.5]]);
  await page.waitForSelector('#height-chart');
  const figures = await page.locator('#heights-figures dd').allTextContents();
  assert.equal(figures.length, 4);
  assert.match(figures[1], /^56\d\.\d\sm$/);
  const [lowest, highest, climb, descent] = figures.map((text) => Number.parseFloat(text));
  assert.ok(climb > 2 && descent > 2 && Math.max(climb, descent) <= highest - lowest + 0.15, `${figures}`);
  await assertAccessible(page, 'a height profile');
  // Along the chart by pointer.
  const box = await page.locator('.height-picture').boundingBox();
  await page.mouse.move(box.x + box.width * 0.56, box.y + box.height / 2);
  await page.waitForSelector('.height-mark');
  assert.match((await page.textContent('.height-told')) ?? '', /^56\d\.\d\sm at/);
  const [mark, canvas] = [await page.locator('.height-mark').boundingBox(), await page.locator('.maplibregl-canvas').boundingBox()];
  assert.ok(Math.abs((mark.x + mark.width / 2 - canvas.x) / canvas.width - 0.5) < 0.02, 'the mark lies below the middle of the line');
  assert.ok(Math.abs((mark.y + mark.height / 2 - canvas.y) / canvas.height - 0.5) < 0.01);
  await page.mouse.move(canvas.x + canvas.width * 0.8, canvas.y + canvas.height * 0.8);
  await page.waitForFunction(() => !document.querySelector('.height-mark'));
  // And by keyboard.
  await page.focus('#height-chart');
  await page.keyboard.press('End');
  const at_end = await page.locator('.height-mark').boundingBox();
  assert.ok(Math.abs((at_end.x + at_end.width / 2 - canvas.x) / canvas.width - 0.65) < 0.01);
  await page.keyboard.press('ArrowLeft');
  assert.ok((await page.locator('.height-mark').boundingBox()).x < at_end.x);
  assert.equal(await page.getAttribute('#height-chart', 'aria-valuetext'), await page.textContent('.height-told'));
  // In feet, without asking again.
  const asked = flight.asked_heights;
  await page.selectOption('#units', 'imperial');
  assert.match((await page.locator('#heights-figures dd').first().textContent()) ?? '', /^1,[78]\d\d\.\d\sft$/);
  assert.equal(flight.asked_heights, asked);
  await page.click('#measure-undo');
  await page.waitForFunction(() => /** @type {HTMLElement} */ (document.querySelector('#heights')).hidden);
  assert.equal(await page.locator('.height-mark').count(), 0);
});

test('the server is asked when a line rests, not at each step of a drag', options, async () => {
  const { page, flight } = await setUpReady('Drag', {}, laptop);
  await page.click('#tool-distance');
  await clickMap(page, [[0.4, 0.5], [0.6, 0.5]]);
  await page.waitForSelector('#height-chart');
  const before = flight.asked_heights;
  const point = await page.locator('.measure-point').last().boundingBox();
  await page.mouse.move(point.x + point.width / 2, point.y + point.height / 2);
  await page.mouse.down();
  for (let i = 1; i <= 20; i += 1) await page.mouse.move(point.x + 6 * i, point.y + 3 * i);
  const [answer] = await Promise.all([page.waitForResponse('**/heights'), page.mouse.up()]);
  await answer.finished();
  assert.equal(flight.asked_heights - before, 1);
  await page.click('#tool-area');
  assert.equal(await page.isVisible('#heights'), false);
});

test('a map that is made again while one measures has its own profile', options, async () => {
  const { page, flight } = await setUpReady('Again', { job_ms: 300 }, laptop);
  await page.click('#tool-distance');
  await clickMap(page, [[0.4, 0.5], [0.6, 0.5]]);
  await page.waitForSelector('#height-chart');
  const before = flight.asked_heights;
  await page.click('#processing-details summary');
  await page.click('#run-again');
  await page.click('#options-submit');
  await until(() => flight.asked_heights > before, 'the heights of the map that is shown now are asked for');
  await page.waitForSelector('#height-chart');
});

test('maps without heights say so: made on level ground, or older', options, async () => {
  const { page, mock } = await setUp({}, { ...phone, errors: /404/ });
  await page.clock.install();
  for (const [ground, says] of /** @type {['plane'|'none', RegExp][]} */ ([['plane', /ebenes Gelände|level ground/], ['none', /keine Geländehöhen|no ground heights/]])) {
    const flight = mock.seedReady(ground);
    flight.ground = ground;
    await openMap(page, `${mock.url}#/flights/${flight.id}`);
    await page.click('#tool-distance');
    await clickMap(page, [[0.3, 0.85], [0.7, 0.88]]);
    await page.waitForFunction(() => /\u2026$/.test(document.querySelector('#heights-message')?.textContent ?? '\u2026') === false);
    assert.match((await page.textContent('#heights-message')) ?? '', says);
    assert.equal(await page.locator('#height-chart').count(), 0);
    await clickMap(page, [[0.5, 0.9]]);
    await page.clock.runFor(1000);
    await allAsked(page);
    if (ground === 'none') assert.equal(flight.asked_heights, 1, 'asked once');
  }
  await assertAccessible(page, 'a map without heights');
});

test('on a phone the profile lies within the card, which scrolls', options, async () => {
  const { page } = await setUpReady('Phone', {}, phone);
  await page.click('#tool-distance');
  await clickMap(page, [[0.3, 0.85], [0.7, 0.8]]);
  await page.waitForSelector('#height-chart');
  await page.locator('#heights-figures').scrollIntoViewIfNeeded();
  const [card, chart] = [await page.locator('#measure-card').boundingBox(), await page.locator('#heights-figures').boundingBox()];
  assert.ok(chart.x >= card.x && chart.x + chart.width <= card.x + card.width + 0.5, 'nothing is cut');
  assert.ok(chart.y + chart.height <= card.y + card.height + 0.5);
  await assertAccessible(page, 'a height profile on a phone');
});
