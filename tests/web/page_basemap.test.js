// Public basemaps on the page, in Chromium against the mock server, with a stand-in for their makers' server: nobody is
// asked before one is chosen, and then map and basemap lie on each other.
import assert from 'node:assert/strict';
import { createServer } from 'node:http';
import { test } from 'node:test';
import { mapIdle, reloadMap, screenshotPixels } from './support/browser.js';
import { assertAccessible, openReady, options, usePages } from './support/pages.js';
import { encodePng } from './support/tile_picture.js';

const { setUp, setUpReady, cleanUp } = usePages();
const kSide = 256;

/** Light, with a dark line along its north and its west edge. */
function linedTile() {
  const rgba = new Uint8Array(kSide * kSide * 4).fill(255);
  for (let i = 0; i < kSide; i += 1) {
    for (const pixel of [i, i * kSide]) rgba.set([0, 0, 0], pixel * 4);
  }
  return encodePng(kSide, kSide, rgba);
}

/** @returns {Promise<{origin: string, asked: {path: string, referer: string|undefined}[]}>} */
async function startMakers() {
  /** @type {{path: string, referer: string|undefined}[]} */
  const asked = [];
  const tile = linedTile();
  const server = createServer((request, response) => {
    asked.push({ path: request.url ?? '', referer: request.headers.referer });
    response.writeHead(200, { 'Content-Type': 'image/png', 'Access-Control-Allow-Origin': '*' });
    response.end(tile);
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', () => resolve(undefined)));
  cleanUp(() => new Promise((resolve) => { server.closeAllConnections(); server.close(() => resolve(undefined)); }));
  return { origin: `http://127.0.0.1:${/** @type {import('node:net').AddressInfo} */ (server.address()).port}`, asked };
}

test('a public basemap asks nobody before it is chosen, and lies below the map to a pixel', options, async () => {
  const makers = await startMakers();
  const { page, mock, foreign_requests } = await setUp({ public_basemap: makers.origin }, { is_drawn: true });
  const flight = await openReady({ page, mock }, 'Meadow');
  await page.click('#tool-layers');
  await page.waitForSelector('#basemap optgroup option', { state: 'attached' });
  assert.match((await page.textContent('#basemap-note')) ?? '', /their makers’ servers, which learn your address/);
  await assertAccessible(page, 'public basemaps');
  assert.deepEqual([...foreign_requests, ...makers.asked], [], 'before anybody chose');

  await page.selectOption('#basemap', 'public:stand-in');
  await page.waitForFunction(() => Boolean(/** @type {any} */ (window).skyquilt.map.getLayer('basemap-tiles')));
  const corner = await page.evaluate(async () => {
    const { map } = /** @type {any} */ (window).skyquilt;
    const zoom = 18, tiles = 2 ** (zoom + 1);  // its unit is tiles of 512 pixels
    const { lng, lat } = map.getCenter();
    const x = Math.ceil(((lng + 180) / 360) * tiles);
    const y = Math.ceil(((1 - Math.asinh(Math.tan((lat * Math.PI) / 180)) / Math.PI) / 2) * tiles);
    const place = [(x / tiles) * 360 - 180, (Math.atan(Math.sinh(Math.PI * (1 - (2 * y) / tiles))) * 180) / Math.PI];
    map.jumpTo({ center: [place[0] + 1e-5, place[1] - 1e-5], zoom, bearing: 0 });
    await new Promise((resolve) => map.once('idle', resolve));
    return map.project(place);
  });
  await page.fill('#opacity', '0');
  await page.waitForTimeout(300);
  const box = /** @type {any} */ (await page.locator('#map').boundingBox());
  const size = 60;
  const left = Math.round(box.x + corner.x) - size / 2, top = Math.round(box.y + corner.y) - size / 2;
  const { at } = await screenshotPixels(page, { x: left, y: top, width: size, height: size });
  const darkest = (/** @type {(i: number) => number[]} */ pixel) => [...Array(size).keys()].reduce((best, i) => (pixel(i)[0] < pixel(best)[0] ? i : best), 0);
  const line_x = left + darkest((i) => at(i, 10)) + 0.5, line_y = top + darkest((i) => at(10, i)) + 0.5;
  assert.ok(Math.abs(line_x - (box.x + corner.x)) <= 1, `the line lies at ${line_x}, the place at ${box.x + corner.x}`);
  assert.ok(Math.abs(line_y - (box.y + corner.y)) <= 1, `the line lies at ${line_y}, the place at ${box.y + corner.y}`);
  assert.ok(makers.asked.length > 0);
  for (const { path, referer } of makers.asked) {
    assert.match(path, /^\/\d+\/\d+\/\d+\.png$/);
    assert.equal(referer, `${new URL(mock.url).origin}/`, 'the makers learn which site asks, and nothing of the flight');
  }
  assert.equal(await page.textContent('#map .maplibregl-ctrl-attrib-inner'), 'Stand-in makers');
  await reloadMap(page);
  assert.ok(await page.evaluate(() => Boolean(/** @type {any} */ (window).skyquilt.map.getLayer('basemap-tiles'))), 'the choice stays');
  assert.deepEqual(foreign_requests.splice(0).filter((/** @type {string} */ address) => !address.startsWith(makers.origin)), []);
});

test('a basemap that is offered no more gives way to the coastlines', options, async () => {
  const { page } = await setUpReady('Meadow');
  await page.evaluate(() => localStorage.setItem('skyquilt.basemap', 'public:gone'));
  await reloadMap(page);
  await page.waitForFunction(() => Boolean(/** @type {any} */ (window).skyquilt.map.getLayer('basemap-land')));
  await page.click('#tool-layers');
  await page.waitForFunction(() => /** @type {HTMLSelectElement} */ (document.querySelector('#basemap')).value === 'land');
  assert.ok(await page.locator('#basemap-note').isHidden(), 'nothing public is offered');
});

test('a basemap whose archive is not there is said to be missing, and gives way to the coastlines', options, async () => {
  const { page } = await setUpReady('Meadow', {}, { errors: /status of 404/ });
  await page.route('**/basemap.json', (route) => route.fulfill({ json: { tilejson: '3.0.0', tiles: [], pmtiles: '/gone.pmtiles', public: [] } }));
  await page.evaluate(() => localStorage.setItem('skyquilt.basemap', 'server'));
  await page.reload();
  await page.waitForSelector('.note-error:has-text("The basemap could not be loaded")');
  await mapIdle(page);
  await page.waitForFunction(() => Boolean(/** @type {any} */ (window).skyquilt.map.getLayer('basemap-land')));
});
