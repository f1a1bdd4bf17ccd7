// Vegetation indices on the page, in Chromium against the mock server; what their addresses are.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { calibrationOf, indexTiles, parseRange, roundTo } from '../../../web/src/indices/index_query.js';
import { holdRequests, mapIdle, openMap, screenshotPixels, twoFrames, until } from '../support/browser.js';
import { allAsked, assertAccessible, options, usePages } from '../support/pages.js';

const { setUp, setUpFlight } = usePages();

test('tiles of an index have the address of the map with what is asked for', () => {
  const look = { index: { id: 'vari', title: 'VARI', expression: 'x', rescale: [0, 1], colormap: 'rdylgn' }, colormap: 'viridis_r', rescale: [-0.5, 0.5] };
  assert.equal(indexTiles('/tiles/f/{z}/{x}/{y}?rev=3', look), '/tiles/f/{z}/{x}/{y}.png?rev=3&index=vari&rescale=-0.5,0.5&colormap=viridis_r');
  const own = { ...look, index: { ...look.index, id: undefined, expression: '(green-red)/(green+red)' } };
  assert.ok(indexTiles('/tiles/f/{z}/{x}/{y}?rev=3&token=sq', own).endsWith('?rev=3&token=sq&expression=(green-red)%2F(green%2Bred)&rescale=-0.5,0.5&colormap=viridis_r'));
});

test('a range is two numbers, the lesser first, with the comma of German too', () => {
  assert.deepEqual(parseRange('-0,2', ' 0.9 '), [-0.2, 0.9]);
  for (const [least, most] of [['', '1'], ['1', '1'], ['2', '1'], ['a', '1'], ['0', 'Infinity'], ['0', '1,250']]) assert.equal(parseRange(least, most), null);
  assert.equal(roundTo(0.12345, 0.6), 0.12);
  assert.equal(roundTo(-1234.5, 900), -1230);
});

test('an index is worth no more than the least of its bands', () => {
  const bands = /** @type {import('../../../web/src/shared/types.js').ReportedBand[]} */ ([
    { name: 'red', calibration: 'reflectance', held_against: 'panel' }, { name: 'nir', calibration: 'reflectance', held_against: null },
    { name: 'green', calibration: 'relative reflectance' }, { name: 'lwir', calibration: 'kelvin' },
  ]);
  assert.equal(calibrationOf('(nir-red)/(nir+red)', bands), 'sensor');
  assert.equal(calibrationOf('red', bands), 'panel');
  assert.equal(calibrationOf('(green - RED) / red', bands), 'relative reflectance');
  assert.equal(calibrationOf('lwir-273.15', bands), 'kelvin');
  assert.equal(calibrationOf('nir', [{ name: 'nir', calibration: 'reflectance' }]), 'reflectance', 'of an older report');
  assert.equal(calibrationOf('nir', []), 'unknown');
  assert.equal(calibrationOf('(green-red)/(green+red-blue)', null), 'colours');
});

/** @param {object} [context] is_drawn: for who looks at its pixels @param {object} [facts] of the stand-in server */
async function openIndices(context = { locale: 'en-GB' }, facts = {}) {
  const opened = await setUp({ has_indices: true, ...facts }, context);
  const { page, mock } = opened;
  const flight = mock.seedReady('Meadow');
  /** @type {string[]} */
  const asked = [];
  page.on('request', (request) => asked.push(request.url()));
  await openMap(page, `${mock.url}#/flights/${flight.id}`);
  if (await page.locator('#layers-card').isHidden()) await page.click('#tool-layers');
  await page.waitForSelector('#index option[value="vari"]', { state: 'attached' });
  return { ...opened, asked };
}

test('a flight with bands opens with its first index, in words, and what its values are worth', options, async () => {
  const { page, mock, flight } = await setUpFlight('Field', { has_indices: true, bands_bounds: [-180, -85, 180, 85] }, { locale: 'en-GB', errors: /bands\.tif/ });
  await page.goto(`${mock.url}#/flights/${flight.id}`);
  await page.waitForSelector('#index-histogram rect');
  assert.equal(await page.inputValue('#index'), 'vari');
  assert.deepEqual(await page.locator('#index-colours option').allTextContents(), ['Red to green', 'Purple to yellow']);
  assert.equal(await page.textContent('#index-calibration'), 'Sensor levels, not calibrated', 'blue is not');
  await page.selectOption('#index', 'own');
  await page.fill('#index-expression', '(green-red)/(green+red)');
  await page.waitForFunction(() => document.querySelector('#index-calibration')?.textContent === 'Reflectance, calibrated with a panel');
  await page.click('#index-geotiff');
  await page.waitForSelector('#download-dialog #exports li');
  const { format, crs, expression } = flight.exports[0];
  assert.deepEqual([format, crs, expression], ['geotiff', 'utm', '(green-red)/(green+red)']);
  await page.keyboard.press('Escape');
  await page.goto(`${mock.url}#/`);
  await page.waitForSelector('#layers-card', { state: 'hidden' });
});

test('an index reaches as far as its bands do', options, async () => {
  const { page, asked } = await openIndices(undefined, { bands_bounds: [-180, -85, 180, 85] });
  const tiles = (/** @type {RegExp} */ of) => new Set(asked.filter((url) => of.test(url)).map((url) => new URL(url).pathname.replace('.png', '')));
  await page.selectOption('#index', 'vari');
  await page.waitForSelector('#index-histogram rect');
  await until(() => {
    const of_map = tiles(/\/tiles\/[^?]*\?rev=\d+$/);
    return [...tiles(/index=vari/)].some((path) => !of_map.has(path));
  }, 'no tile beside those of the map was asked for');
});

test('an index lies over the map in its colours, which follow what is chosen and typed', options, async () => {
  const { page, asked } = await openIndices({ locale: 'en-GB', is_drawn: true });
  const shows = async (/** @type {[number, number, number]} */ [r, g, b]) => {
    await mapIdle(page);
    const box = await page.locator('#map').boundingBox();
    return (await screenshotPixels(page, { x: box.x + 60, y: box.y + 200, width: 300, height: 200 })).share(r, g, b, 30);
  };
  await page.selectOption('#index', 'vari');
  await page.waitForSelector('#index-histogram rect');
  assert.ok((await shows([0, 160, 60])) > 0.5);
  assert.ok(asked.some((url) => /\.png\?rev=\d+&index=vari&rescale=-0\.4,0\.4&colormap=rdylgn$/.test(url)));
  assert.match((await page.getAttribute('#index-histogram', 'aria-label')) ?? '', /from [-−]0\.50 to 0\.50/);
  await page.selectOption('#index-colours', 'viridis');
  assert.ok((await shows([200, 40, 200])) > 0.5);
  await page.check('#index-turned');
  await page.fill('#index-most', '0.25');
  await page.waitForRequest((request) => request.url().includes('rescale=-0.4,0.25&colormap=viridis_r'));
  await page.click('#index-fit');
  assert.equal(await page.inputValue('#index-least'), '-0.29');
  await page.fill('#index-least', '7');
  await page.waitForSelector('#index-least[aria-invalid="true"]');
  const map = await page.locator('#map').boundingBox();
  await page.mouse.move(map.x + 100, map.y + 300);
  await page.mouse.move(map.x + 120, map.y + 320);
  await page.waitForFunction(() => document.querySelector('#index-value')?.textContent?.includes('0.250'));
  assert.match((await page.getAttribute('#zones-shp', 'href')) ?? '', /zones\?index=vari&classes=5&format=shp/);
  await page.selectOption('#index-zones', '3');
  await assertAccessible(page, 'layers with an index');
  await page.selectOption('#index', '');
  assert.equal(await shows([200, 40, 200]), 0);
});

test('a button below counts when the value of a place comes while it is pressed', options, async () => {
  const { page, mock } = await openIndices();
  const release = await holdRequests(page, '**/point?*');
  await page.selectOption('#index', 'vari');
  await page.waitForSelector('#index-histogram rect');
  const map = await page.locator('#map').boundingBox();
  await page.mouse.move(map.x + 100, map.y + 300);
  await Promise.all([page.waitForRequest('**/point?*'), page.mouse.move(map.x + 120, map.y + 320)]);
  await page.hover('#index-geotiff');
  await page.mouse.down();
  release();
  await page.waitForFunction(() => document.querySelector('#index-value')?.textContent?.includes('0.250'));
  await page.mouse.up();
  await page.waitForSelector('#exports li');
  assert.deepEqual([...mock.flights.values()][0].exports.map((/** @type {any} */ { format, index }) => [format, index]), [['geotiff', 'vari']]);
});

test('a formula of one\'s own is shown, and where it cannot be read the page says where', options, async () => {
  const { page } = await openIndices({ locale: 'en-GB', errors: /400/ });
  await page.selectOption('#index', 'own');
  await page.fill('#index-expression', 'green-red');
  await page.waitForRequest((request) => request.url().includes('.png?rev=1&expression=green-red&rescale=-0.29,0.29'));
  await page.fill('#index-expression', 'green+');
  await page.waitForSelector('#index-fault:not([hidden])');
  assert.match((await page.textContent('#index-fault')) ?? '', /character 7/);
  assert.equal(await page.locator('#index-histogram rect, #zones-geojson[href], #index-geotiff:enabled').count(), 0, 'of the one before');
  await page.fill('#index-expression', 'green+blue');
  await page.waitForSelector('#index-fault', { state: 'hidden' });
  await page.waitForSelector('#zones-geojson[href*="green%2Bblue"]');
  assert.ok(await page.isEnabled('#index-geotiff'));
});

test('what was asked about one map is not laid over the next', options, async () => {
  const { page, mock } = await openIndices();
  const other = mock.seedReady('Brook');
  await page.route(`**/tiles/${other.id}.json`, async (route) => {
    const { bands, indices, ...tilejson } = await (await route.fetch()).json();
    await route.fulfill({ json: tilejson });
  });
  const release = await holdRequests(page, '**/statistics?*');
  await Promise.all([page.waitForRequest('**/statistics?*'), page.selectOption('#index', 'own')]);
  await page.goto(`${mock.url}#/flights/${other.id}`);
  await page.waitForFunction((id) => Object.values(/** @type {any} */ (window).skyquilt.map.getStyle().sources).some((/** @type {any} */ { tiles }) => tiles?.[0].includes(id)), other.id);
  const answered = page.waitForResponse('**/statistics?*');
  release();
  await (await answered).finished();
  await allAsked(page);
  await twoFrames(page);
  assert.equal(await page.evaluate(() => Boolean(/** @type {any} */ (window).skyquilt.map.getLayer('index'))), false);
});

test('the card fits a phone in German', options, async () => {
  const { page } = await openIndices({ locale: 'de-DE', viewport: { width: 360, height: 740 } });
  await page.selectOption('#index', 'gli');
  await page.waitForSelector('#index-histogram rect');
  const card = await page.locator('#layers-card').boundingBox();
  assert.ok(card.x >= 0 && card.x + card.width <= 360, JSON.stringify(card));
  assert.ok(await page.locator('#layers-card').evaluate((element) => element.scrollWidth <= element.clientWidth));
  assert.match((await page.textContent('#layers-card')) ?? '', /Vegetationsindex/);
});

test('a map without bands offers no index', options, async () => {
  const { page, mock } = await setUp({}, { locale: 'en-GB' });
  await openMap(page, `${mock.url}#/flights/${mock.seedReady('Meadow').id}`);
  await page.click('#tool-layers');
  assert.ok(await page.locator('#index').isHidden());
});
