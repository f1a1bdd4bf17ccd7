// The home view of the page, in Chromium against the mock server: the map of all flights, the list with its pictures.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { matches, orders, plain } from '../../web/src/home/flight_list.js';
import { boxOf, fitted, gridOf, groups, outlinesOf, parted } from '../../web/src/home/overview_map.js';
import { distanceTold, keepUnits, roundLength } from '../../web/src/shared/format.js';
import { drag, kPhone, mapIdle, twoFrames } from './support/browser.js';
import { assertAccessible, options, usePages } from './support/pages.js';
import { seedMany } from './support/mock_flight.js';

const { setUp } = usePages();
const laptop = { viewport: { width: 1440, height: 900 } };
const desk = { viewport: { width: 1920, height: 1080 } };

test('a search knows neither accents nor capitals, and finds words in any order and dates', () => {
  assert.equal(plain('Œuvre ÉTÉ Łódź Straße Ærø'), 'oeuvre ete lodz strasse aero');
  const flight = /** @type {any} */ ({ name: 'Zürich, Käferberg', captured: { first: '2026-05-12T09:31:00+02:00', last: '2026-05-12T09:31:34+02:00' } });
  for (const query of ['', 'zurich', 'KAFERBERG zür', '2026-05', '2026 zurich']) assert.ok(matches(flight, query), query);
  assert.ok(!matches(flight, 'zurich bern'));
});

test('flights are sorted by when they were flown, not by when they came', () => {
  const flight = (/** @type {string} */ first, /** @type {string} */ created_at, side = 1) => /** @type {any} */ ({ name: first, created_at, captured: first ? { first, last: first } : null, bounds: [7, 46, 7 + side, 46 + side] });
  const early = flight('2025-03-01T10:00:00Z', '2026-06-01T00:00:00Z', 3);
  const late = flight('2026-04-01T10:00:00+02:00', '2026-04-02T00:00:00Z');
  const unknown = flight('', '2025-12-24T00:00:00Z', 2);
  assert.deepEqual([early, late, unknown].sort(orders.taken), [late, unknown, early]);
  assert.deepEqual([early, late, unknown].sort(orders.newest), [early, late, unknown]);
  assert.deepEqual([late, unknown, early].sort(orders.area), [early, unknown, late]);
});

test('marks that would cover each other are one until the view parts them', () => {
  const at = (/** @type {number} */ lon, /** @type {number} */ lat) => ({ flight: /** @type {any} */ ({ id: `${lon} ${lat}` }), box: boxOf([lon, lat, lon + 0.001, lat + 0.001]) });
  const near = [at(7.4, 46.9), at(7.41, 46.9)];
  const placed = [...near, at(-70, -30)];
  const whole = fitted({ left: 0, top: 0, right: 1, bottom: 1 }, 800, 600, 20);
  const found = groups(placed, whole, 800, 600);
  assert.deepEqual(found.map(({ members }) => members.length), [2, 1]);
  const next = parted(found[0], whole, 800, 600);
  assert.ok(next);
  assert.equal(groups(near, next, 800, 600).length, 2);
  const same = groups([at(7.4, 46.9), at(7.4, 46.9)], whole, 800, 600);
  assert.equal(parted(same[0], whole, 800, 600), null, 'the same place cannot be parted');
});

test('the scale is a round length in the units that are chosen', () => {
  const scales = () => [40, 2000, 100_000].map((most_m) => distanceTold(roundLength(most_m)).replace('\u00a0', ' '));
  keepUnits('imperial');
  assert.deepEqual(scales(), ['100 ft', '1 mi', '50 mi']);
  keepUnits('metric');
  assert.deepEqual(scales(), ['30 m', '2 km', '100 km']);
});

test('three hundred flights are a light first view: 30 requests, 400 kB, pictures only in sight', options, async () => {
  const { page, mock } = await setUp({ page_limit: 500 }, desk);
  seedMany(mock, 300);
  const context = page.context();
  await page.close();
  const fresh = await context.newPage();
  const requests = [];
  let bytes = 0;
  fresh.on('request', (request) => requests.push(new URL(request.url()).pathname));
  fresh.on('response', (response) => (bytes += Number(response.headers()['content-length'] ?? 0)));
  await fresh.goto(mock.url);
  await fresh.waitForFunction(() => document.querySelectorAll('.flights li').length === 300);
  await fresh.waitForFunction(() => document.querySelectorAll('.thumb-image').length >= 4);
  await fresh.waitForLoadState('networkidle');
  const pictures = requests.filter((path) => path.endsWith('/thumbnail.webp'));
  assert.ok(pictures.length >= 4 && pictures.length <= 8, `${pictures.length} pictures`);
  assert.equal(new Set(pictures).size, pictures.length, 'one request a picture');
  assert.ok(requests.length <= 30, `${requests.length} requests: ${requests.join(' ')}`);
  assert.ok(bytes < 400_000, `${bytes} bytes`);
  assert.ok(!requests.some((path) => path.includes('maplibre')));
  await fresh.locator('.flights li').nth(40).scrollIntoViewIfNeeded();
  await fresh.waitForFunction(() => /** @type {HTMLImageElement|null} */ (document.querySelectorAll('.flights li')[40].querySelector('img'))?.complete);
  await assertAccessible(fresh, 'home with three hundred flights');
});

test('the overview has a mark for each flight with a place, and a click opens the flight', options, async () => {
  const { page, mock } = await setUp({}, laptop);
  const names = ['Brook', 'Quarry', 'Nowhere', 'Dam'];
  const [brook, quarry, nowhere, dam] = names.map((name) => mock.seedReady(name));
  Object.assign(quarry.place, { lon: 7.61, lat: 47.1 });
  Object.assign(dam.place, { lon: 8.1, lat: 46.6 });
  Object.assign(nowhere.place, { lon: 0, lat: 0 });
  await page.reload();
  await page.waitForFunction(() => document.querySelectorAll('.overview-mark').length === 3);
  assert.deepEqual((await page.locator('.overview-mark .mark-name').allTextContents()).sort(), ['Brook', 'Dam', 'Quarry']);
  assert.ok(await page.locator('#drop-bar').isVisible());
  assert.equal(await page.locator('#drop-zone').count(), 0);
  // The row and the mark point at each other.
  await page.hover(`.flights li:has-text("Quarry")`);
  assert.equal(await page.locator('.overview-mark.pointed').textContent(), 'Quarry');
  await page.hover('.overview-mark:has-text("Dam")');
  assert.match((await page.locator('.flights li.pointed').textContent()) ?? '', /Dam/);
  // A drag moves the map and opens nothing.
  const box = await page.locator('.overview-mark:has-text("Brook")').boundingBox();
  await drag(page, [box.x + 14, box.y + 14], [box.x + 94, box.y + 54]);
  await page.waitForFunction((x) => Math.abs((document.querySelector('.overview-mark')?.getBoundingClientRect().x ?? 0) - x) > 40, box.x);
  assert.equal(new URL(page.url()).hash, '');
  // Let go beside it, the pointer drags nothing when it comes back.
  const overview = await page.locator('#overview').boundingBox();
  await twoFrames(page);
  const held = await page.getAttribute('.overview-mark:has-text("Brook")', 'style');
  await drag(page, [overview.x + 5, overview.y + 300], [overview.x - 60, overview.y + 300]);
  await page.mouse.move(overview.x + 200, overview.y + 300, { steps: 3 });
  await twoFrames(page);
  assert.equal(await page.getAttribute('.overview-mark:has-text("Brook")', 'style'), held);
  await page.click('.overview-mark:has-text("Brook") .mark-dot');
  await mapIdle(page);
  assert.equal(new URL(page.url()).hash, `#/flights/${brook.id}`);
});

test('flights of one field are one mark that tells them apart, and a search leaves its own on the map', options, async () => {
  const { page, mock } = await setUp({}, kPhone);
  for (const name of ['Field in May', 'Field in June', 'Élevage', 'A', 'B', 'C']) mock.seedReady(name);
  Object.assign([...mock.flights.values()][2].place, { lon: 2.3, lat: 48.8 });
  await page.reload();
  await page.waitForSelector('.mark-group');
  await page.click('.mark-group');
  assert.equal(await page.locator('#overview-choice a').count(), 5);
  await assertAccessible(page, 'home on a phone');
  await page.keyboard.press('Escape');
  await page.fill('#flight-search', 'elevage');
  await page.waitForFunction(() => document.querySelectorAll('.overview-mark').length === 1);
  assert.equal(await page.locator('.overview-mark .mark-name').textContent(), 'Élevage');
  await page.fill('#flight-search', '');
  await page.selectOption('#flight-order', 'area');
  await page.reload();
  await page.waitForSelector('.flights li');
  assert.equal(await page.inputValue('#flight-order'), 'area', 'the order is kept');
});

test('land across the antimeridian is drawn on both sides of the world, and nothing runs across it', () => {
  const across = outlinesOf([[170, 60], [-170, 60], [-170, 70], [170, 70], [170, 60]]);
  assert.equal(across.length, 2);
  for (const outline of across) {
    for (const [i, { x }] of outline.entries()) assert.ok(i === 0 || Math.abs(x - outline[i - 1].x) < 0.1);
  }
  assert.deepEqual(across.map((outline) => outline.some(({ x }) => x < 0.1)), [false, true]);
  assert.equal(outlinesOf([[0, 0], [10, 0], [10, 10], [0, 0]]).length, 1);
  const round_pole = outlinesOf([[0, -70], [120, -70], [-120, -70], [0, -70]]);
  assert.ok(round_pole.every((outline) => outline.filter(({ y }) => y === 1).length === 2));
});

test('the lines of the grid lie at round degrees, neither close together nor out of sight', () => {
  for (let scale = 256; scale <= 256 * 2 ** 18; scale *= 1.7) {
    const { step_deg, line_digits } = gridOf(scale);
    const apart_px = (step_deg * scale) / 360;
    assert.ok(step_deg === 90 || (apart_px >= 149 && apart_px <= 400), `${step_deg} degrees are ${apart_px} px`);
    assert.equal(Number((step_deg * 3).toFixed(line_digits)).toPrecision(8), (step_deg * 3).toPrecision(8), 'no digit is lost');
  }
});

test('a note stays while its action has the focus, or the pointer is on it', options, async () => {
  const { page, mock } = await setUp();
  mock.seedReady('Meadow');
  await page.reload();
  await page.waitForSelector('.flights li');
  await page.clock.install();
  await page.hover('.flights li');
  await page.click('.flights li .row-actions button:nth-child(2)');
  await page.focus('.note-action');
  await page.clock.runFor(60_000);
  assert.equal(await page.locator('.note').count(), 1);
  await page.locator('#flights-heading').focus();
  await page.clock.runFor(5000);
  await page.hover('.note');
  await page.clock.runFor(60_000);
  assert.equal(await page.locator('.note').count(), 1);
  await page.mouse.move(0, 0);
  await page.clock.runFor(9000);
  assert.equal(await page.locator('.note').count(), 0);
});
