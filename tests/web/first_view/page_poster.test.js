// The picture of the whole map that is there before the map, in Chromium against the mock server: that it lies where the
// map will lie, in whatever view, and that it comes and goes unnoticed.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { holdRequests, kPhone, mapIdle } from '../support/browser.js';
import { assertAccessible, options, usePages } from '../support/pages.js';

const { setUp, setUpFlight } = usePages();
const laptop = { viewport: { width: 1366, height: 768 } };
const phone = { ...kPhone, deviceScaleFactor: 2 };
const kPoster = '.poster:not([hidden])';
/** The list before asks for smaller ones. @param {URL} address */
const isPoster = ({ pathname, searchParams }) => pathname.endsWith('thumbnail.webp') && searchParams.get('size') === '1024';

/** Opens an address from nothing, while the library that draws maps is held back; the answer lets it through. */
async function openHeld(page, address) {
  const release = await holdRequests(page, '**/vendor/maplibre-gl.mjs');
  await page.goto('about:blank');
  await page.addInitScript(() => {
    /** @type {any} */ (window).shifts = [];
    new PerformanceObserver((list) => {
      for (const entry of /** @type {any[]} */ (list.getEntries())) {
        const moved = entry.sources.map((/** @type {any} */ { node }) => node?.id || node?.className || node?.nodeName);
        /** @type {any} */ (window).shifts.push({ value: entry.value, moved });
      }
    }).observe({ type: 'layout-shift', buffered: true });
  });
  await page.goto(address, { waitUntil: 'commit' });
  return release;
}

/** In the page: the corners of the bounds on the screen, as the map has them, in px of the window. */
const boundsOnScreen = (/** @type {number[]} */ [west, south, east, north]) => {
  const { map } = /** @type {any} */ (window).skyquilt;
  const box = map.getContainer().getBoundingClientRect();
  const corners = [[west, south], [west, north], [east, south], [east, north]].map((place) => map.project(place));
  const xs = corners.map(({ x }) => x + box.x);
  const ys = corners.map(({ y }) => y + box.y);
  return { left: Math.min(...xs), top: Math.min(...ys), right: Math.max(...xs), bottom: Math.max(...ys) };
};

async function boundsOf(mock, flight) {
  return (await (await fetch(`${mock.url}api/v1/flights/${flight.id}`)).json()).bounds;
}

const posterBox = (page) => page.$eval(kPoster, (poster) => {
  const { left, top, right, bottom } = poster.getBoundingClientRect();
  return { left, top, right, bottom };
});

function assertClose(poster, map, where) {
  for (const side of /** @type {const} */ (['left', 'top', 'right', 'bottom'])) {
    assert.ok(Math.abs(poster[side] - map[side]) < 1, `${where}, ${side}: poster ${poster[side].toFixed(2)}, map ${map[side].toFixed(2)}`);
  }
}

/** The poster of an address lies where the map comes to lie, then goes. */
async function assertGivesWay({ page, mock }, flight, address, where) {
  const release = await openHeld(page, address);
  await page.waitForSelector(kPoster);
  assert.equal(await page.evaluate(() => 'skyquilt' in window), false, 'before the map');
  const poster = await posterBox(page);
  assert.equal(await page.getAttribute('.poster', 'alt'), '');
  assert.equal(await page.getAttribute('.poster', 'aria-hidden'), 'true');
  release();
  await mapIdle(page);
  assertClose(poster, await page.evaluate(boundsOnScreen, await boundsOf(mock, flight)), where);
  await page.waitForFunction(() => !document.querySelector('.poster'));
  return page.evaluate(() => /** @type {any} */ (window).shifts);
}

test('before the map its picture lies exactly where the map will lie, on laptop and phone', options, async () => {
  for (const [name, screen] of /** @type {const} */ ([['laptop', laptop], ['phone', phone]])) {
    const { page, mock, flight } = await setUpFlight('Meadow', {}, screen);
    const asked = [];
    page.on('request', (request) => asked.push(new URL(request.url())));
    const shifts = await assertGivesWay({ page, mock }, flight, `${mock.url}#/flights/${flight.id}`, name);
    const shift = shifts.reduce((/** @type {number} */ sum, /** @type {{value: number}} */ { value }) => sum + value, 0);
    assert.ok(shift < 0.03, `${name}: the layout moved: ${JSON.stringify(shifts)}`);
    assert.ok(!shifts.some(({ moved }) => moved.some((/** @type {string} */ part) => /poster|stage|^map/.test(part))), JSON.stringify(shifts));
    assert.equal(asked.filter(isPoster).length, 1);
    assert.equal(asked.filter(({ pathname }) => pathname === `/api/v1/flights/${flight.id}`).length, 1, 'what was asked early is not asked again');
    assert.equal(asked.filter(({ pathname }) => pathname === `/tiles/${flight.id}.json`).length, 1);
    await assertAccessible(page, `map on a ${name}`);
  }
});

test('the picture lies right in a view that was moved and turned, and stays away where it would be a blot', options, async () => {
  const { page, mock, flight } = await setUpFlight('Meadow', {}, laptop);
  const { lon, lat } = flight.place;
  const at = (/** @type {string} */ zoom, /** @type {string} */ turned) => `${mock.url}#/flights/${flight.id}?at=${zoom}/${(lat + 0.0002).toFixed(7)}/${(lon - 0.0003).toFixed(7)}${turned}`;
  await assertGivesWay({ page, mock }, flight, at('18.30', ''), 'moved');
  await assertGivesWay({ page, mock }, flight, at('17.20', '/40'), 'turned');
  const release = await openHeld(page, at('21.50', ''));
  await page.waitForSelector('.poster', { state: 'attached' });
  assert.equal(await page.locator(kPoster).count(), 0);
  release();
  await mapIdle(page);
  await page.waitForFunction(() => !document.querySelector('.poster'));
});

test('the picture keeps its place when the window changes, and goes with the flight', options, async () => {
  const { page, mock, flight } = await setUpFlight('Meadow', {}, laptop);
  const release = await openHeld(page, `${mock.url}#/flights/${flight.id}`);
  await page.waitForSelector(kPoster);
  const before = await posterBox(page);
  await page.setViewportSize({ width: 1000, height: 560 });
  await page.waitForFunction((was) => Math.abs((document.querySelector('.poster')?.getBoundingClientRect().right ?? was) - was) > 50, before.right);
  const resized = await posterBox(page);
  await page.evaluate(() => { location.hash = '#/'; });
  await page.waitForFunction(() => !document.querySelector('.poster'));
  assert.equal(await page.locator('#map-area').isVisible(), false);
  release();
  await page.waitForSelector('.flights li');
  await page.click('.flights li a');
  await mapIdle(page);
  assertClose(resized, await page.evaluate(boundsOnScreen, await boundsOf(mock, flight)), 'resized');
  assert.equal(await page.locator('.poster').count(), 0, 'it is for what is opened first');
});

test('a flight without a map, one that is not there and one whose picture fails open as ever', options, async () => {
  const { page, mock, console_errors } = await setUp({}, { ...laptop, reducedMotion: 'reduce', colorScheme: 'dark', errors: /status of 404/ });
  const empty = mock.addFlight('Later');
  const asked = [];
  page.on('request', (request) => asked.push(request.url()));
  const open = async (/** @type {string} */ id) => {
    await page.goto('about:blank');
    await page.goto(`${mock.url}#/flights/${id}`);
  };
  await open(empty.id);
  await page.waitForSelector('#flight-title');
  assert.ok(!asked.some((url) => url.includes('thumbnail')));
  assert.deepEqual(console_errors, []);
  await open('f99999999');
  await page.waitForSelector('.callout-error');
  assert.equal(await page.locator('.poster').count(), 0);
  const flight = mock.seedReady('Meadow');
  await page.route('**/thumbnail.webp?size=1024**', (route) => route.fulfill({ status: 200, contentType: 'image/webp', body: 'no picture' }));
  await open(flight.id);
  await mapIdle(page);
  assert.equal(await page.locator('.poster').count(), 0);
  await page.unroute('**/thumbnail.webp?size=1024**');
  const release = await openHeld(page, `${mock.url}#/flights/${flight.id}`);
  await page.waitForSelector(kPoster);
  // Dark around the map from the start, and no fading for who wants none.
  assert.equal(await page.$eval('#stage', (stage) => getComputedStyle(stage).backgroundColor), 'rgb(27, 33, 31)');
  assert.equal(await page.$eval('.poster', (poster) => getComputedStyle(poster).transitionDuration), '0s');
  release();
  await mapIdle(page);
  await page.waitForFunction(() => !document.querySelector('.poster'));
});

test('who moves the map before its tiles are there takes the picture along', options, async () => {
  const { page, mock, flight } = await setUpFlight('Meadow', {}, laptop);
  const release = await holdRequests(page, '**/tiles/*/*/*/*');
  await page.goto('about:blank');
  await page.goto(`${mock.url}#/flights/${flight.id}`);
  await page.waitForSelector(kPoster);
  await page.waitForFunction(() => /** @type {any} */ (window).skyquilt?.map.getLayer('mosaic-1'));
  await page.evaluate(() => /** @type {any} */ (window).skyquilt.map.panBy([120, 60], { animate: false }));
  assertClose(await posterBox(page), await page.evaluate(boundsOnScreen, await boundsOf(mock, flight)), 'moved');
  release();
  await mapIdle(page);
  await page.waitForFunction(() => !document.querySelector('.poster'));
});

test('the bare map has its picture too, with the token of its address', options, async () => {
  const { page, mock, flight } = await setUpFlight('Meadow', { has_tokens: true }, laptop);
  const asked = [];
  page.on('request', (request) => asked.push(new URL(request.url())));
  await assertGivesWay({ page, mock }, flight, `${mock.url}embed/${flight.id}#token=sq_guest`, 'bare map');
  assert.equal(asked.find(isPoster)?.searchParams.get('token'), 'sq_guest');
  await assertAccessible(page, 'bare map');
});
