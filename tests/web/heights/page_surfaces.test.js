// A map with heights on the page, in Chromium against the mock server; what the server knows of heights is made up here.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { addCentres, drag, mapIdle, openMap, until } from '../support/browser.js';
import { allAsked, assertAccessible, options, usePages } from '../support/pages.js';
import { encodePng } from '../support/tile_picture.js';

const { setUp } = usePages();
const kGround_m = 405;
/** Enough for what is drawn in three dimensions by a processor. */
const kSmall = { viewport: { width: 1000, height: 640 } };

/** 412.35 m everywhere, as terrarium. */
const kTile = encodePng(256, 256, new Uint8Array(256 * 256 * 4).map((_, i) => [129, 156, 90, 255][i % 4]));

/** @param {number} lon @param {number} lat @returns {GeoJSON.FeatureCollection} */
const contoursAt = (lon, lat) => ({
  type: 'FeatureCollection',
  features: [404, 404.5, 405, 405.5].map((height_m, i) => ({ type: 'Feature', properties: { height_m }, geometry: { type: 'LineString', coordinates: [[lon - 0.0005, lat + i * 1e-4], [lon + 0.0005, lat + i * 1e-4]] } })),
});

/**
 * A flight whose map has heights, opened.
 * @param {{surfaces?: ('dsm'|'dtm')[], context?: object, facts?: object, later?: string}} [how] later: name of one more flight, flown after it
 */
async function openHeights({ surfaces = ['dsm', 'dtm'], context = {}, facts = {}, later = '' } = {}) {
  const opened = await setUp(facts, { viewport: { width: 1440, height: 900 }, locale: 'en-GB', ...context });
  const { page, mock } = opened;
  const [flight, other] = [mock.seedReady('Hill'), mock.seedReady('Flat')];
  if (later) mock.seedReady(later).captured = { first: '2026-06-12T09:31:00+02:00', last: '2026-06-12T09:31:34+02:00' };
  /** @type {{points: string[], volumes: {query: string, type: string, body: any}[], tiles: number}} */
  const asked = { points: [], volumes: [], tiles: 0 };
  const of = (/** @type {any} */ values) => Object.fromEntries(surfaces.map((surface) => [`${surface}_m`, values[surface]]));
  await page.route(`**/tiles/${flight.id}.json`, async (route) => {
    const tilejson = await (await route.fetch()).json();
    await route.fulfill({ json: { ...tilejson, heights: surfaces, ...(surfaces.length > 0 ? { terrain: `${mock.url}tiles/${flight.id}/terrain.json` } : {}) } });
  });
  await page.route(`**/tiles/${flight.id}/terrain.json*`, (route) => route.fulfill({ json: { tilejson: '3.0.0', encoding: 'terrarium', tileSize: 256, minzoom: 0, maxzoom: 21, tiles: [`${mock.url}tiles/${flight.id}/terrain/{z}/{x}/{y}.png?rev=1`], bounds: [7, 46, 8, 47] } }));
  await page.route(`**/tiles/${flight.id}/terrain/**`, (route) => {
    asked.tiles += 1;
    return route.fulfill({ contentType: 'image/png', body: kTile });
  });
  await page.route(`**/flights/${flight.id}/point?*`, (route) => {
    const query = new URL(route.request().url()).searchParams;
    asked.points.push(String(query));
    // A house in the west half.
    const is_house = Number(query.get('lon')) < flight.place.lon;
    return route.fulfill({ json: { revision: 1, ...of({ dsm: is_house ? kGround_m + 7.35 : kGround_m + 0.1, dtm: kGround_m }) } });
  });
  await page.route(`**/flights/${flight.id}/heights`, async (route) => {
    const profile = await (await route.fetch()).json();
    const samples = profile.samples.map((/** @type {any} */ sample, /** @type {number} */ i) => ({ ...sample, ...of({ dsm: kGround_m + (i > 20 && i < 40 ? 8 : 0), dtm: kGround_m }) }));
    return route.fulfill({ json: { ...profile, surfaces, samples } });
  });
  await page.route(`**/flights/${flight.id}/volume?*`, (route) => {
    const request = route.request();
    const query = new URL(request.url()).searchParams;
    asked.volumes.push({ query: String(query), type: request.headers()['content-type'], body: request.postDataJSON() });
    const base = query.get('base') ?? '';
    if (base === '9999' || base === '8888') {
      const reason = base === '9999' ? { code: 'volume_without_heights', values: {} } : { code: 'maps_far_apart', values: { most_m: 6 } };
      return route.fulfill({ status: 422, contentType: 'application/problem+json', json: { title: 'Unprocessable', status: 422, detail: 'None.', reason } });
    }
    const is_plane = base === 'plane';
    const since = query.get('since');
    return route.fulfill({ json: { revision: 1, of: 'dsm', base: since ? 'flight' : is_plane || base === 'lowest' ? base : 'given', ...(since ? { since, shift: { east_m: null, north_m: null, up_m: 0.2, sigma_m: 0.05, alike_share: 0.9 } } : {}), base_m: is_plane ? 405.6 : 404.8, area_m2: 1000, covered_m2: 1000, measured_share: is_plane ? 0.72 : 0.97, cell_m: 0.1, cut_m3: 1234.5, fill_m3: 34.56, net_m3: 1199.9, net_sigma_m3: 12.3, lowest_m: 404.8, highest_m: 412.4, mean_m: 406 } });
  });
  await page.route(`**/flights/${flight.id}/contours.geojson`, (route) => route.fulfill({ json: contoursAt(flight.place.lon, flight.place.lat) }));
  await openMap(page, `${mock.url}#/flights/${flight.id}`);
  return { ...opened, flight, other, asked };
}

/** @param {any} page @param {[number, number][]} at shares of the map's size */
async function clickAt(page, at) {
  const box = await page.locator('.maplibregl-canvas').boundingBox();
  for (const [x, y] of at) await page.mouse.click(box.x + x * box.width, box.y + y * box.height);
}

const layersOf = (/** @type {any} */ page) => page.evaluate(() => /** @type {any} */ (window).skyquilt.map.getStyle().layers.map((/** @type {any} */ { id }) => id));
const mapState = (/** @type {any} */ page) => page.evaluate(() => {
  const { map } = /** @type {any} */ (window).skyquilt;
  return { terrain: map.getTerrain(), pitch: Math.round(map.getPitch()), max_pitch: map.getMaxPitch(), sources: Object.keys(map.getStyle().sources) };
});
const kTriangle = /** @type {[number, number][]} */ ([[0.4, 0.4], [0.6, 0.4], [0.5, 0.6]]);

test('the height below the cursor stands beside its coordinates, and what stands on the ground', options, async () => {
  const { page, asked, flight } = await openHeights();
  const box = await page.locator('.maplibregl-canvas').boundingBox();
  const pointAt = (/** @type {number} */ x) => page.mouse.move(box.x + x * box.width, box.y + 0.5 * box.height);
  const height = () => page.locator('#cursor-height').innerText();
  await pointAt(0.4);
  await page.waitForFunction(() => /412\.35\sm \+7\.\d\sm/.test(document.querySelector('#cursor-height')?.textContent ?? ''));
  assert.match(asked.points.at(-1) ?? '', /ground=false/);
  await pointAt(0.6);
  await page.waitForFunction(() => /405\.10\sm/.test(document.querySelector('#cursor-height')?.textContent ?? ''));
  assert.doesNotMatch(await height(), /\+/);
  // Beside the map nothing is said, and nothing asked.
  await page.evaluate(([lon, lat]) => /** @type {any} */ (window).skyquilt.map.jumpTo({ center: [lon + 0.02, lat], zoom: 18 }), [flight.place.lon, flight.place.lat]);
  await mapIdle(page);
  await page.clock.install();
  const before = asked.points.length;
  await pointAt(0.5);
  assert.ok(await page.locator('#cursor-height').isHidden());
  await page.clock.runFor(1000);
  await allAsked(page);
  assert.equal(asked.points.length, before);
  await assertAccessible(page, 'map with heights');
});

test('a map without heights is asked nothing and offers nothing of them', options, async () => {
  const { page, asked } = await openHeights({ surfaces: [] });
  await page.clock.install();
  const box = await page.locator('.maplibregl-canvas').boundingBox();
  await page.mouse.move(box.x + 0.5 * box.width, box.y + 0.5 * box.height);
  assert.ok(await page.locator('#tool-3d').isHidden());
  await page.click('#tool-layers');
  for (const id of ['#show-hillshade', '#show-contours']) assert.ok(await page.locator(id).isHidden());
  await page.click('#tool-area');
  await clickAt(page, kTriangle);
  await page.waitForFunction(() => /\d/.test(document.querySelector('#measure-result')?.textContent ?? ''));
  assert.ok(await page.locator('#volume').isHidden());
  await page.clock.runFor(1000);
  await allAsked(page);
  assert.deepEqual([asked.points.length, asked.volumes.length, asked.tiles], [0, 0, 0]);
});

test('a profile shows the surface, and the ground below it as a quieter line', options, async () => {
  const { page } = await openHeights();
  await page.click('#tool-distance');
  await clickAt(page, [[0.35, 0.5], [0.65, 0.5]]);
  await page.waitForSelector('#height-chart');
  assert.deepEqual(await page.locator('#height-legend li').allInnerTexts(), ['Surface', 'Ground']);
  const figures = (await page.locator('#heights-figures dd').allTextContents()).map((text) => Number.parseFloat(text));
  assert.deepEqual(figures, [405, 413, 8, 8]);
  await page.focus('#height-chart');
  for (let i = 0; i < 25; i += 1) await page.keyboard.press('ArrowRight');
  assert.match((await page.textContent('.height-told')) ?? '', /^413\.0\sm at .*, ground 405\.0\sm$/);
  await assertAccessible(page, 'a profile of two surfaces');
});

test('a measured area has a volume above and below the chosen base', options, async () => {
  const { page, asked } = await openHeights({ context: { errors: /422/ } });
  await page.click('#tool-area');
  await clickAt(page, kTriangle);
  await page.waitForSelector('#volume-figures');
  assert.equal(asked.volumes.length, 1, 'asked once the outline rests');
  assert.equal(asked.volumes[0].query, 'of=dsm&base=lowest');
  assert.equal(asked.volumes[0].type, 'application/geo+json');
  assert.equal(asked.volumes[0].body.type, 'Polygon');
  assert.equal(asked.volumes[0].body.coordinates[0].length, 4, 'closed');
  const figures = async () => (await page.locator('#volume-figures dd').allInnerTexts()).map((/** @type {string} */ text) => text.replaceAll('\u00a0', ' '));
  assert.deepEqual(await figures(), ['1,235 m³', '34.6 m³', '1,200 m³ ± 12.3 m³', '404.8 m']);
  assert.equal(await page.locator('#volume .amber').count(), 0);
  await page.selectOption('#volume-base', 'plane');
  await page.waitForSelector('#volume .amber');
  assert.match((await page.textContent('#volume .amber')) ?? '', /72/);
  await assertAccessible(page, 'a volume');
  await page.selectOption('#volume-base', 'given');
  await until(() => asked.volumes.at(-1)?.query === 'of=dsm&base=405.6', 'begins with the base before');
  assert.equal(await page.inputValue('#volume-given'), '405.6');
  await page.fill('#volume-given', '9999');
  await page.waitForFunction(() => /No heights are known here/.test(document.querySelector('#volume-message')?.textContent ?? ''));
  await page.fill('#volume-given', '8888');
  await page.waitForFunction(() => /more than 6\sm apart sideways/.test(document.querySelector('#volume-message')?.textContent ?? ''));
  await page.fill('#volume-given', 'x');
  assert.equal(await page.getAttribute('#volume-given', 'aria-invalid'), 'true');
  await page.fill('#volume-given', '404,5');
  await page.waitForSelector('#volume-figures');
  const before = asked.volumes.length;
  await page.selectOption('#units', 'imperial');
  assert.match((await figures())[0], /^1,615 yd³$/);
  assert.equal(await page.inputValue('#volume-given'), '1327.1');
  assert.equal(asked.volumes.length, before, 'in other units without asking again');
  await page.press('#volume-given', 'End');
  await page.press('#volume-given', 'Backspace');
  assert.equal(await page.inputValue('#volume-given'), '1327.', 'the key is the field’s, not the outline’s');
  await page.click('#tool-distance');
  assert.ok(await page.locator('#volume').isHidden());
});

test('what has changed since an earlier flight is a layer, and a base of volumes', options, async () => {
  const { page, mock, flight, other, asked } = await openHeights({ later: 'Next month' });
  const shift = { east_m: 0.9, north_m: -1.2, up_m: -3.4, sigma_m: 0.08, alike_share: 0.6 };
  const address = `${mock.url}tiles/${flight.id}/change/{z}/{x}/{y}.png?rev=1&of=dsm&since=${other.id}&since_rev=1`;
  const stops = [[-1, '#d6604d'], [-0.1, '#fddbc7'], [0.1, '#d1e5f0'], [1, '#4393c3']].map(([change_m, colour]) => ({ change_m, colour }));
  let asked_of = '';
  await page.route(`**/tiles/${flight.id}/change.json*`, (route) => {
    asked_of = new URL(route.request().url()).search;
    return route.fulfill({ json: { tilejson: '3.0.0', tileSize: 256, minzoom: 0, maxzoom: 21, tiles: [address], bounds: [7, 46, 8, 47], since: other.id, shift, least_shown_m: 0.16, stops } });
  });
  await page.route(`**/tiles/${flight.id}/change/**`, (route) => route.fulfill({ contentType: 'image/png', body: kTile }));
  await page.click('#tool-layers');
  await page.waitForSelector('#change-since');
  assert.deepEqual((await page.locator('#change-since option').allInnerTexts()).map((text) => text.split(',')[0]), ['Not shown', 'Flat']);
  await page.selectOption('#change-since', other.id);
  await until(async () => (await layersOf(page)).includes('height-change'));
  assert.equal(asked_of, `?of=dsm&since=${other.id}`);
  assert.deepEqual((await page.locator('#change-legend li').allInnerTexts()).map((text) => text.trim().replaceAll('\u00a0', ' ')), ['+1.0 m', '+0.1 m', '-0.1 m', '-1.0 m']);
  assert.match((await page.textContent('#change-legend')) ?? '', /3\.40\sm apart in height and 1\.50\sm sideways[^]*Only 60% of the ground/);
  await assertAccessible(page, 'a change of heights');
  await page.selectOption('#change-since', '');
  await until(async () => !(await layersOf(page)).includes('height-change'));
  assert.equal(await page.textContent('#change-legend'), '');

  await page.click('#tool-area');
  await clickAt(page, kTriangle);
  await page.waitForSelector('#volume-figures');
  await page.waitForSelector('#volume-base option[value^="since="]', { state: 'attached' });
  await page.selectOption('#volume-base', `since=${other.id}`);
  await until(() => asked.volumes.at(-1)?.query === `of=dsm&since=${other.id}`);
  await page.waitForFunction(() => /Added since then/.test(document.querySelector('#volume-figures')?.textContent ?? ''));
  assert.equal(await page.locator('#volume-figures dt').count(), 3, 'no height of a base');
  assert.match((await page.textContent('#volume-result')) ?? '', /0\.20\sm apart in height; this is taken out/);
  assert.equal(await page.locator('#volume-result .amber').count(), 0);
  await page.focus('#volume-base');
  const corners = await page.textContent('#measure-result');
  await page.keyboard.press('Backspace');
  assert.equal(await page.textContent('#measure-result'), corners, 'the key is the choice’s, not the outline’s');
  // Another map has other flights of its place.
  await openMap(page, `${mock.url}#/flights/${other.id}`);
  assert.equal(await page.locator('#volume-base option[value^="since="]').count(), 0);
  assert.ok(await page.locator('#change-since').isHidden());
});

test('hillshade and contours lie over the map below its photos until they are taken away', options, async () => {
  const { page, asked } = await openHeights();
  await page.click('#tool-layers');
  assert.ok(!(await page.isChecked('#show-contours')) && !(await page.isChecked('#show-hillshade')));
  await page.check('#show-contours');
  await until(async () => (await layersOf(page)).includes('contours-label'));
  await page.check('#show-hillshade');
  await until(async () => (await layersOf(page)).includes('hillshade'));
  await mapIdle(page);
  await until(() => asked.tiles > 0, 'its tiles are asked for');
  const layers = await layersOf(page);
  const at = (/** @type {string} */ id) => layers.indexOf(id);
  const mosaic = layers.findIndex((/** @type {string} */ id) => id.startsWith('mosaic-'));
  assert.ok(mosaic < at('hillshade') && at('hillshade') < at('contours') && at('contours-label') < at('photos-fill'), `${layers}`);
  await assertAccessible(page, 'layers of heights');
  await page.uncheck('#show-contours');
  await page.uncheck('#show-hillshade');
  await until(async () => !(await layersOf(page)).some((/** @type {string} */ id) => /hillshade|contours/.test(id)));
});

test('in three dimensions the map is tilted, one measures on it, and it lies level again', options, async () => {
  const { page } = await openHeights({ context: { reducedMotion: 'reduce', is_drawn: true, ...kSmall } });
  assert.deepEqual([(await mapState(page)).pitch, await page.getAttribute('#tool-3d', 'aria-pressed')], [0, 'false']);
  await page.click('#tool-3d');
  await until(async () => (await mapState(page)).pitch === 60);
  assert.equal(await page.getAttribute('#tool-3d', 'aria-pressed'), 'true');
  assert.deepEqual((await mapState(page)).terrain, { source: 'relief', exaggeration: 1 });
  await mapIdle(page);
  // The right button tilts it.
  const box = await page.locator('.maplibregl-canvas').boundingBox();
  const middle = [box.x + box.width / 2, box.y + box.height / 2];
  await drag(page, middle, [middle[0], middle[1] + 40], 'right');
  await until(async () => (await mapState(page)).pitch < 50);
  await page.click('#tool-distance');
  await addCentres(page, [[7.4391, 46.9512], [7.4401, 46.9512]]);
  assert.match((await page.textContent('#measure-result')) ?? '', /^76\.\d/);
  await page.click('#tool-3d');
  await until(async () => (await mapState(page)).max_pitch === 0);
  const after = await mapState(page);
  assert.deepEqual([after.terrain, after.pitch, after.sources.includes('relief')], [null, 0, false]);
});

test('all of it goes with the map', options, async () => {
  const { page, other, mock } = await openHeights({ context: { reducedMotion: 'reduce', is_drawn: true, ...kSmall } });
  await page.click('#tool-layers');
  await page.check('#show-contours');
  await page.check('#show-hillshade');
  await page.click('#tool-3d');
  await until(async () => (await mapState(page)).pitch === 60);
  await until(async () => (await layersOf(page)).includes('contours-label'));
  await page.goto(`${mock.url}#/flights/${other.id}`);
  await page.waitForFunction(() => /** @type {any} */ (document.querySelector('#tool-3d')).hidden);
  await mapIdle(page);
  const { terrain, pitch, max_pitch, sources } = await mapState(page);
  assert.deepEqual([terrain, pitch, max_pitch], [null, 0, 0]);
  assert.deepEqual(sources.filter((/** @type {string} */ id) => /relief|hillshade|contours/.test(id)), []);
  assert.ok(await page.locator('#cursor-height').isHidden());
  assert.ok(await page.locator('#show-contours').isHidden());
});

test('the tools of heights fit a phone in German', options, async () => {
  const { page } = await openHeights({ context: { viewport: { width: 360, height: 740 }, locale: 'de-DE' } });
  // Without a cursor it is the height of the centre. It takes no room from the scale beside the readout.
  await page.waitForSelector('#cursor-height:not([hidden])');
  const width = () => page.locator('.coordinates').evaluate((element) => element.getBoundingClientRect().width);
  const with_height = await width();
  await page.locator('#cursor-height').evaluate((element) => element.setAttribute('hidden', ''));
  assert.ok(with_height - (await width()) < 14, 'a gap at most');
  await page.click('#tool-layers');
  const card = await page.locator('#layers-card').boundingBox();
  assert.ok(card.x >= 0 && card.x + card.width <= 360, JSON.stringify(card));
  assert.match((await page.textContent('#layers-card')) ?? '', /Schummerung[^]*Höhenlinien/);
});
