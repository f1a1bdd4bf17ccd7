// Exports on the page, in Chromium against the mock server: the form, progress, downloads, and what is refused.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { exportWords, wishOf } from '../../../web/src/flight/export_view.js';
import { outlineOf } from '../../../web/src/map/outlines.js';
import { loadFlightStrings } from '../../../web/src/shared/flight_strings.js';
import { holdAnswer, kPhone, twoFrames, until } from '../support/browser.js';
import { allAsked, assertAccessible, options, usePages } from '../support/pages.js';

await loadFlightStrings();

const { setUpReady } = usePages();
const ring = [[7.438, 46.951], [7.439, 46.951], [7.439, 46.952], [7.438, 46.951]];
const feature = (/** @type {any} */ geometry) => ({ type: 'Feature', properties: {}, geometry });

test('what the form says is what the server is asked for', () => {
  const form = { format: 'geotiff', crs: 'stored', epsg: '', resolution_cm: '' };
  assert.deepEqual(wishOf(form, null), { format: 'geotiff' });
  assert.deepEqual(wishOf({ ...form, crs: 'utm', resolution_cm: '2.5' }, null), { format: 'geotiff', crs: 'utm', resolution_m: 0.025 });
  for (const epsg of ['2056', ' EPSG:2056 ', 'epsg 2056']) assert.equal(wishOf({ ...form, crs: 'epsg', epsg }, null).crs, 'EPSG:2056');
  const geometry = /** @type {const} */ ({ type: 'Polygon', coordinates: [ring] });
  assert.deepEqual(wishOf({ ...form, format: 'kmz', crs: 'utm' }, { name: 'Field', geometry }), { format: 'kmz', boundary: geometry }, 'only a GeoTIFF has another system');
  assert.deepEqual(wishOf({ ...form, format: 'report', resolution_cm: '5' }, { name: 'Field', geometry }), { format: 'report' }, 'a report is of the whole map');
  const words = exportWords(/** @type {any} */ ({ format: 'geotiff', crs: 'EPSG:2056', resolution_m: 0.1, boundary: geometry, is_current: false }));
  assert.match(words, /^GeoTIFF · EPSG:2056 · 10.*cm.* · part of the map · earlier version of the map$/);
});

test('an outline is all polygons of a file and nothing else in it', () => {
  const of = (/** @type {any[]} */ ...geometries) => outlineOf('x.geojson', { type: 'FeatureCollection', features: geometries.map(feature) });
  const [point, one, two] = [{ type: 'Point', coordinates: [7, 46] }, { type: 'Polygon', coordinates: [ring] }, { type: 'MultiPolygon', coordinates: [[ring], [ring]] }];
  assert.equal(of(point), null);
  assert.deepEqual(of(point, one)?.geometry, one);
  assert.deepEqual(of(one, two)?.geometry, { type: 'MultiPolygon', coordinates: [[ring], [ring], [ring]] });
});

for (const [screen, context] of /** @type {const} */ ([['laptop', {}], ['phone', kPhone]])) {
  test(`a map is exported, downloaded and deleted on a ${screen}, and refusals are said`, options, async () => {
    const { page, flight } = await setUpReady('Meadow', {}, { ...context, errors: /422/ });
    await page.click('#flight-download');
    assert.equal(await page.locator('.download').count(), 8);
    await page.click('#export-open');
    await page.selectOption('#export-crs', 'epsg');
    await page.click('#export-start');
    assert.equal(flight.exports?.length ?? 0, 0, 'without a number nothing is sent');
    await page.fill('#export-epsg', '1');
    await page.click('#export-start');
    await page.waitForSelector('#export-refusal');
    assert.match((await page.textContent('#export-refusal')) ?? '', /There is no coordinate system EPSG:1\. Look the code up/);
    await assertAccessible(page, 'export that is refused');
    await page.fill('#export-epsg', '2056');
    await page.fill('#export-resolution', '10');
    await page.click('#export-start');
    await page.waitForSelector('#exports li progress');
    assert.equal(await page.locator('#export-refusal').count(), 0);
    await page.waitForSelector('#exports li a');
    assert.match((await page.textContent('#exports li')) ?? '', /GeoTIFF · EPSG:2056 · 10.*12\.3.MB · kept until/);
    const [download] = await Promise.all([page.waitForEvent('download'), page.click('#exports li a')]);
    assert.match(download.url(), /exports\/e1\/file$/);
    assert.deepEqual([flight.exports[0].crs, flight.exports[0].resolution_m], ['EPSG:2056', 0.1]);
    // One that fails while it is made says why; another format asks for no system.
    await page.fill('#export-epsg', '2');
    await page.click('#export-start');
    await page.waitForSelector('#exports li .bad');
    assert.match((await page.textContent('#exports li .bad')) ?? '', /outside the coordinate system/);
    await assertAccessible(page, 'exports');
    await page.selectOption('#export-format', 'pmtiles');
    assert.ok(await page.locator('#export-crs').isHidden());
    await page.locator('#exports li button').first().click();
    await page.waitForFunction(() => document.querySelectorAll('#exports li').length === 1);
    await page.keyboard.press('Escape');
    await page.waitForSelector('#download-dialog', { state: 'detached' });
  });
}

/** The exports of a flight, one of which is being made for as long as a case takes. */
async function openWithLong() {
  const opened = await setUpReady('Meadow');
  opened.flight.exports = [{ id: 'e1', format: 'geotiff', at: Date.now() + 60_000 }];
  await opened.page.click('#flight-download');
  await opened.page.click('#export-open');
  return opened;
}

test('an export is stopped by a click that begins before it goes on and ends after that', options, async () => {
  const { page, flight } = await openWithLong();
  await page.hover('#exports li button');
  await page.mouse.down();
  // Its progress is another in each answer.
  for (let answers = 0; answers < 2; answers += 1) await page.waitForResponse(`**/flights/${flight.id}/exports`);
  await allAsked(page);
  await twoFrames(page);
  await page.mouse.up();
  await page.waitForSelector('#exports li', { state: 'detached' });
  assert.deepEqual(flight.exports, []);
});

test('an export that is deleted does not come back with an answer from before', options, async () => {
  const { page, flight } = await openWithLong();
  await page.waitForSelector('#exports li progress');
  const { isHeld, release } = await holdAnswer(page, `**/flights/${flight.id}/exports`);
  await until(isHeld);
  await page.click('#exports li button');
  await page.waitForSelector('#exports li', { state: 'detached' });
  release();
  await allAsked(page);
  await twoFrames(page);
  assert.equal(await page.locator('#exports li').count(), 0);
});

test('the first download is what one measures in', options, async () => {
  const { page, flight } = await setUpReady('Meadow');
  await page.click('#flight-download');
  assert.match(await page.locator('.download').first().innerText(), /^GeoTIFF in UTM\s+to measure, for GIS and CAD$/);
  assert.match(await page.locator('a.download[href*="download.tif"]').innerText(), /^GeoTIFF in Web Mercator\s.*for web maps/s);
  await page.click('#download-utm');
  await page.waitForSelector('#exports li a');
  assert.deepEqual(flight.exports.map((/** @type {any} */ { format, crs, resolution_m, boundary }) => ({ format, crs, resolution_m, boundary })), [{ format: 'geotiff', crs: 'utm', resolution_m: undefined, boundary: undefined }]);
  assert.equal(await page.inputValue('#export-crs'), 'utm', 'an export is to measure in, unless one says otherwise');
  await assertAccessible(page, 'download in UTM');
});

test('a report and a file for Google Earth are one click away', options, async () => {
  const { page, flight } = await setUpReady('Meadow');
  for (const [name, format] of [['report', 'report'], ['kmz', 'kmz']]) {
    await page.click('#flight-download');
    await page.click(`#download-${name}`);
    await page.waitForSelector('#exports li a');
    assert.deepEqual(flight.exports.map((/** @type {any} */ wish) => wish.format).includes(format), true);
    await page.keyboard.press('Escape');
    await page.waitForSelector('#download-dialog', { state: 'detached' });
  }
  await page.click('#flight-download');
  await page.click('#export-open');
  await page.selectOption('#export-format', 'report');
  for (const hidden of ['#export-crs', '#export-resolution', '#export-area']) assert.ok(await page.locator(hidden).isHidden(), hidden);
});

test('a map is cut to what is drawn, to a loaded file, or to one that is chosen there', options, async () => {
  const { page, flight } = await setUpReady('Meadow');
  const file = (/** @type {string} */ name, /** @type {any} */ geometry) => ({ name, mimeType: 'application/geo+json', buffer: Buffer.from(JSON.stringify(geometry)) });
  await page.click('#tool-layers');
  await page.setInputFiles('#own-data-input', [file('field.geojson', { type: 'Polygon', coordinates: [ring] }), file('path.geojson', { type: 'LineString', coordinates: ring })]);
  await page.waitForFunction(() => document.querySelectorAll('.own-data li').length === 2);
  await page.click('#tool-area');
  const box = /** @type {any} */ (await page.locator('#map').boundingBox());
  for (const [x, y] of [[0.4, 0.4], [0.6, 0.4], [0.6, 0.6]]) await page.mouse.click(box.x + x * box.width, box.y + y * box.height);
  await page.click('#flight-download');
  await page.click('#export-open');
  await page.waitForSelector('#export-area');
  const names = await page.locator('#export-area option').allTextContents();
  assert.equal(names.length, 3, 'a path has no area');
  assert.match(names[1], /^Area drawn on the map \(.*(m²|ha|ft²|acres)\)$/);
  assert.equal(names[2], 'field.geojson');
  await page.selectOption('#export-area', '0');
  await page.click('#export-start');
  await page.waitForSelector('#exports li');
  assert.equal(flight.exports[0].boundary.type, 'Polygon');
  assert.equal(flight.exports[0].boundary.coordinates[0].length, 4);
  await page.setInputFiles('#export-area-file', file('line.geojson', { type: 'LineString', coordinates: ring }));
  await page.waitForSelector('#export-refusal');
  assert.match((await page.textContent('#export-refusal')) ?? '', /line\.geojson: The file has no areas/);
  await page.setInputFiles('#export-area-file', file('two.geojson', { type: 'MultiPolygon', coordinates: [[ring], [ring]] }));
  await page.waitForFunction(() => /** @type {HTMLSelectElement} */ (document.getElementById('export-area')).value === '2');
  await page.click('#export-start');
  await page.waitForFunction(() => document.querySelectorAll('#exports li').length === 2);
  assert.equal(flight.exports[0].boundary.type, 'MultiPolygon');
});

test('downloads whose sizes cannot be asked for are offered all the same, and nobody hears of it', options, async () => {
  const { page } = await setUpReady('Meadow', {}, { errors: /ERR_FAILED/ });
  let asked = 0;
  await page.route('**/download.*', async (/** @type {any} */ route) => {
    asked += 1;
    await route.abort();
  });
  await page.click('#flight-download');
  await until(() => asked > 0);
  await allAsked(page);
  await twoFrames(page);
  assert.ok((await page.locator('a.download').count()) > 0);
  assert.equal(await page.locator('.note-error').count(), 0);
});
