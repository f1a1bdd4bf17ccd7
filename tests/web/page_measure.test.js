// Measuring and own data on the map, in Chromium against the mock server.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { measurementsGeoJson, measurementsGpx, measurementsKml } from '../../web/src/map/measurement_files.js';
import { boundsOfData, OwnDataError, readOwnData } from '../../web/src/map/own_data.js';
import { loadFlightStrings } from '../../web/src/shared/flight_strings.js';
import { areaIn, lengthIn, usualUnits } from '../../web/src/shared/units.js';
import { drag, kPhone, openPhotoCard, reloadMap, savedBy } from './support/browser.js';
import { assertAccessible, options, usePages } from './support/pages.js';

await loadFlightStrings();

const { setUpReady } = usePages();
const square = /** @type {[number, number][]} */ ([[7.4388, 46.951], [7.4388, 46.9515], [7.4396, 46.9515], [7.4396, 46.951]]);

test('feet and acres are those of the United States, metres and hectares of nearly everybody else', () => {
  assert.deepEqual(['en-US', 'en', 'de-CH', 'en-GB', 'my', 'nonsense!'].map(usualUnits), ['imperial', 'imperial', 'metric', 'metric', 'imperial', 'metric']);
  assert.equal(lengthIn(30.48, 'imperial'), '100.0\u00a0ft');
  assert.equal(lengthIn(3218.688, 'imperial'), '2.000\u00a0mi');
  assert.equal(areaIn(40_468.564224, 'imperial'), '10.0\u00a0acres');
  assert.equal(areaIn(92.90304, 'imperial'), '1,000\u00a0ft²');
  assert.equal(areaIn(24_310, 'metric'), '2.43\u00a0ha');
});

test('a measurement is saved as GeoJSON and KML that are read back as they were', () => {
  const area = { name: 'Field <1>', places: square, length_m: 230.1234, area_m2: 3385.25 };
  const { features } = JSON.parse(measurementsGeoJson([area]));
  assert.deepEqual(features[0].properties, { name: 'Field <1>', area_m2: 3385.25, perimeter_m: 230.123 });
  // It was drawn clockwise; RFC 7946 wants outlines anticlockwise and closed.
  assert.deepEqual(features[0].geometry.coordinates, [[...square].reverse().concat([square[3]])]);
  const path = JSON.parse(measurementsGeoJson([{ name: 'Path', places: square.slice(0, 2), length_m: 55.6, area_m2: null }]));
  assert.equal(path.features[0].geometry.type, 'LineString');
  assert.deepEqual(boundsOfData(readOwnData('path.geojson', JSON.stringify(path))), [7.4388, 46.951, 7.4388, 46.9515]);
  assert.match(measurementsKml([area]), /<name>Field &lt;1&gt;<\/name>[^]*<Polygon>.*7\.4396,46\.951 7\.4396,46\.9515/);
  const track = measurementsGpx([area]);
  assert.match(track, /<name>Field &lt;1&gt;<\/name>/);
  const points = [...track.matchAll(/<trkpt lat="([\d.]+)" lon="([\d.]+)"\/>/g)].map(([, lat, lon]) => [Number(lon), Number(lat)]);
  assert.equal(points.length, 5, 'closed');
  assert.deepEqual(points[0], points[4]);
  assert.deepEqual(new Set(points.map(String)), new Set(square.map(String)));
});

test('GeoJSON of every kind is read, and what is none is refused with what to do', () => {
  const read = (/** @type {unknown} */ value) => readOwnData('x.geojson', typeof value === 'string' ? value : JSON.stringify(value));
  const kinds = (/** @type {unknown} */ value) => read(value).features.map(({ geometry }) => geometry.type);
  assert.deepEqual(kinds({ type: 'Point', coordinates: [7, 46, 500] }), ['Point']);
  assert.deepEqual(read({ type: 'Point', coordinates: [7, 46, 500] }).features[0].geometry, { type: 'Point', coordinates: [7, 46] });
  assert.deepEqual(kinds({ type: 'Feature', geometry: { type: 'GeometryCollection', geometries: [{ type: 'LineString', coordinates: [[7, 46], [8, 46]] }, { type: 'MultiPolygon', coordinates: [[[[7, 46], [8, 46], [8, 47], [7, 46]]]] }] } }), ['LineString', 'MultiPolygon']);
  assert.deepEqual(kinds({ type: 'FeatureCollection', features: [{ type: 'Feature', geometry: null }, { type: 'Feature', geometry: { type: 'MultiPoint', coordinates: [[7, 46]] } }] }), ['MultiPoint']);
  const deep = { type: 'GeometryCollection', geometries: /** @type {any[]} */ ([]) };
  let inner = deep;
  for (let i = 0; i < 20; i += 1) {
    const next = { type: 'GeometryCollection', geometries: [] };
    inner.geometries.push(next);
    inner = next;
  }
  for (const [value, says] of /** @type {[unknown, RegExp][]} */ ([
    ['{', /neither GeoJSON nor KML/], ['PK\u0003\u0004', /zip/], ['null', /cannot be read|no points/], ['[]', /cannot be read/], [{ type: 'FeatureCollection', features: [] }, /no points/], [{ type: 'FeatureCollection' }, /cannot be read/],
    [{ type: 'Point', coordinates: [600_000, 200_000] }, /WGS 84/], [{ type: 'Point', coordinates: ['7', '46'] }, /cannot be read/], [{ type: 'LineString', coordinates: [7, 46] }, /cannot be read/], [{ type: 'toString', coordinates: [] }, /cannot be read/],
    [{ type: 'FeatureCollection', crs: { properties: { name: 'urn:ogc:def:crs:EPSG::2056' } }, features: [] }, /WGS 84/], [{ type: 'MultiPoint', coordinates: Array.from({ length: 200_001 }, () => [7, 46]) }, /200,000 points/], [deep, /cannot be read/],
  ])) {
    assert.throws(() => read(value), (error) => error instanceof OwnDataError && says.test(error.message), JSON.stringify(value).slice(0, 80));
  }
});

test('where the scale of a map is a guess the measurement says so', options, async () => {
  for (const is_unplaced of [true, false]) {
    const { page } = await setUpReady('Nowhere', { is_unplaced }, { locale: 'en-GB' });
    await page.click('#tool-distance');
    assert.equal(await page.locator('#measure-no-scale').isVisible(), is_unplaced);
    if (!is_unplaced) continue;
    assert.match(await page.innerText('#measure-no-scale'), /scale is a guess: do not measure/);
    await assertAccessible(page, 'measuring without a scale');
    await page.click('#tool-distance');
    await openPhotoCard(page);
    assert.match((await page.textContent('#photo-card')) ?? '', /Height above ground\s*unknown/);
  }
});

test('points are dragged and undone, parts have their lengths, units are kept, the result is saved', options, async () => {
  const { page } = await setUpReady('Meadow', {}, { viewport: { width: 1440, height: 900 }, locale: 'en-GB' });
  await page.click('#tool-distance');
  const box = await page.locator('#map').boundingBox();
  const click = (/** @type {number} */ x, /** @type {number} */ y) => page.mouse.click(box.x + x, box.y + y);
  await click(400, 500);
  await click(600, 500);
  await click(600, 650);
  const labels = () => page.locator('.measure-label').allTextContents();
  const metres = (/** @type {string|null} */ text) => Number(text?.match(/^([\d.]+)\sm$/)?.[1]);
  await page.waitForFunction(() => document.querySelectorAll('.measure-label').length === 2);
  const whole = () => page.textContent('#measure-result');
  const [first, second] = (await labels()).map(metres);
  assert.ok(Math.abs(first + second - metres(await whole())) < 0.2, `${await labels()} ${await whole()}`);
  assert.ok(Math.abs(first / second - 200 / 150) < 0.02);

  // The corner is dragged to make the first part half as long, and comes back by one step.
  const corner = await page.locator('.measure-point >> nth=1').boundingBox();
  await drag(page, [corner.x + 13, corner.y + 13], [corner.x - 87, corner.y + 13]);
  assert.ok(Math.abs(metres((await labels())[0]) - first / 2) < 0.3, `${await labels()}`);
  assert.equal(await page.locator('.measure-point').count(), 3, 'a drag adds no point');
  await page.click('#measure-undo');
  assert.ok(Math.abs(metres((await labels())[0]) - first) < 0.01);
  await page.focus('.measure-point >> nth=2');
  await page.keyboard.press('ArrowDown');
  assert.ok(metres((await labels())[1]) > second);
  await page.keyboard.press('Delete');
  assert.equal(await page.locator('.measure-point').count(), 2);
  await page.keyboard.press('Control+z');
  assert.equal(await page.locator('.measure-point').count(), 3);
  await assertAccessible(page, 'measuring');

  assert.match((await page.textContent('#report .facts')) ?? '', /Area2\.43\sha.*±2\.3\sm/);
  await page.selectOption('#units', 'imperial');
  assert.match((await page.textContent('#report .facts')) ?? '', /Area5\.994\sacres.*±7\.5\sft/);
  assert.match((await page.textContent('.flight-head .flight-facts')) ?? '', /±7\.5\sft/);
  assert.match((await whole()) ?? '', /\sft$/);
  assert.match((await page.textContent('#map .maplibregl-ctrl-scale')) ?? '', /ft/);
  await page.click('#tool-area');
  await click(400, 500);
  await click(600, 500);
  await click(600, 650);
  assert.match((await whole()) ?? '', /ft²|acres/);
  const geojson = await savedBy(page, '#measure-geojson');
  assert.equal(geojson.name, 'area.geojson');
  assert.equal(JSON.parse(geojson.text).features[0].geometry.coordinates[0].length, 4);
  const kml = await savedBy(page, '#measure-kml');
  assert.equal(kml.name, 'area.kml');

  // What was saved is laid over the map again.
  await page.keyboard.press('Escape');
  await reloadMap(page);
  await page.click('#tool-area');
  assert.equal(await page.inputValue('#units'), 'imperial', 'the units are kept');
  await page.click('#tool-area');
  await page.click('#tool-layers');
  await page.setInputFiles('#own-data-input', [{ name: 'area.kml', mimeType: 'text/xml', buffer: Buffer.from(kml.text) }, { name: 'area.geojson', mimeType: 'application/json', buffer: Buffer.from(geojson.text) }]);
  await page.waitForFunction(() => document.querySelectorAll('.own-data li').length === 2);
  const drawn = await page.evaluate(async () => {
    const { map } = /** @type {any} */ (window).skyquilt;
    return Promise.all(['own-1', 'own-2'].map(async (id) => (await map.getSource(id).getData()).features[0].geometry));
  });
  assert.equal(drawn[0].type, 'Polygon');
  assert.deepEqual(drawn[0], drawn[1]);
  await assertAccessible(page, 'own data');
  await page.click('.own-data .icon-button');
  assert.equal(await page.evaluate(() => /** @type {any} */ (window).skyquilt.map.getSource('own-1') === undefined), true);
});

test('a file that cannot be laid over the map is named with what to do', options, async () => {
  const { page } = await setUpReady('Meadow', {}, { ...kPhone, errors: /inline style/ });  // Chromium's own words on damaged XML
  await page.click('#tool-layers');
  const kml = (/** @type {string} */ inside) => `<?xml version="1.0"?><kml xmlns="http://www.opengis.net/kml/2.2"><Document>${inside}</Document></kml>`;
  for (const [text, says] of /** @type {[string, RegExp][]} */ ([
    ['<kml><Placemark>', /incomplete or damaged/], ['<gpx></gpx>', /neither GeoJSON nor KML/], [kml(''), /no points/], [kml('<Placemark><Point><coordinates>a,b</coordinates></Point></Placemark>'), /cannot be read/],
    ['<!DOCTYPE kml [<!ENTITY a "aaaa">]><kml>&a;</kml>', /cannot be read/], [kml('<Placemark><Point><coordinates>2600000,1200000</coordinates></Point></Placemark>'), /WGS 84/],
  ])) {
    await page.setInputFiles('#own-data-input', { name: 'plan.kml', mimeType: 'text/xml', buffer: Buffer.from(text) });
    await page.waitForSelector('.note-error');
    assert.match((await page.textContent('.note-error')) ?? '', says);
    assert.match((await page.textContent('.note-error')) ?? '', /^plan\.kml: /);
    await page.click('.note-error .icon-button');
  }
  assert.equal(await page.locator('.own-data li').count(), 0);
  await page.setInputFiles('#own-data-input', { name: 'far.kml', mimeType: 'text/xml', buffer: Buffer.from(kml('<Placemark><Point><coordinates>-70,-30,0</coordinates></Point></Placemark>')) });
  await page.waitForSelector('.note:has-text("outside this view")');
  await page.click('.note-action');
  await page.waitForFunction(() => Math.abs(/** @type {any} */ (window).skyquilt.map.getCenter().lng + 70) < 0.01);
});

for (const [screen, context] of /** @type {const} */ ([['laptop', {}], ['phone', kPhone]])) {
  test(`what is measured is covered by nothing on a ${screen}; a band follows, and an area is offered for an export`, options, async () => {
    const { page, flight } = await setUpReady('Meadow', {}, { locale: 'en-GB', ...context });
    await page.click('#tool-area');
    const view = () => page.evaluate(() => {
      const { left, top, width, height } = /** @type {HTMLElement} */ (document.querySelector('#map')).getBoundingClientRect();
      return { left, top, width, height };
    });
    await page.waitForFunction(() => /** @type {any} */ (window).skyquilt.map.getCanvas().clientHeight === document.querySelector('#map')?.clientHeight);
    // Near the corners, where cards used to lie.
    const box = await view();
    const press = (/** @type {number} */ x, /** @type {number} */ y) => (screen === 'phone' ? page.touchscreen.tap(box.left + x, box.top + y) : page.mouse.click(box.left + x, box.top + y));
    await press(30, 40);
    const band = () => page.evaluate(async () => {
      const { map } = /** @type {any} */ (window).skyquilt;
      const found = (await map.getSource('measure').getData()).features.find((/** @type {any} */ f) => f.properties.band);
      return found ? found.geometry.coordinates.map((/** @type {any} */ place) => map.project(place)) : null;
    });
    if (screen === 'laptop') {
      await page.mouse.move(box.left + 300, box.top + 200);
      const [from, to] = await band();
      assert.ok(Math.hypot(from.x - 30, from.y - 40) < 1 && Math.hypot(to.x - 300, to.y - 200) < 1, JSON.stringify([from, to]));
    } else {
      // A finger moves the map below the cross, which is where the next point would be.
      await page.evaluate(() => /** @type {any} */ (window).skyquilt.map.panBy([-20, -30], { duration: 0 }));
      const [from, to] = await band();
      assert.ok(Math.hypot(from.x - 50, from.y - 70) < 1 && Math.hypot(to.x - box.width / 2, to.y - box.height / 2) < 1, JSON.stringify([from, to, box]));
      await page.evaluate(() => /** @type {any} */ (window).skyquilt.map.panBy([20, 30], { duration: 0 }));
    }
    await press(30, box.height - 60);
    await press(box.width - 90, box.height - 60);
    assert.equal(await page.locator('.measure-point').count(), 3);
    const covered = await page.locator('.measure-point').evaluateAll((points) => points.map((point) => {
      const { left, top, width, height } = point.getBoundingClientRect();
      return point.contains(document.elementFromPoint(left + width / 2, top + height / 2));
    }));
    assert.deepEqual(covered, [true, true, true], 'each point can be seen and taken');
    const card = await page.locator('#measure-card').boundingBox();
    const now = await view();
    assert.deepEqual([now.left, now.top, now.width, now.height], [box.left, box.top, box.width, box.height], 'the map stays as it is while one measures');
    assert.ok(card.x + card.width <= now.left + 1 || card.y >= now.top + now.height - 17, `${JSON.stringify(card)} beside ${JSON.stringify(now)}`);
    await assertAccessible(page, `measuring on a ${screen}`);
    await page.click('#measure-export');
    await page.waitForSelector('#export-area');
    assert.match(await page.locator('#export-area option:checked').textContent(), /^Area drawn on the map/);
    await page.click('#export-start');
    await page.waitForSelector('#exports li');
    assert.equal(flight.exports[0].boundary.coordinates[0].length, 4);
    await page.keyboard.press('Escape');
    await page.click('#measure-card .card-head .icon-button');
    assert.equal(await page.locator('#measure-card').isVisible(), false);
    assert.equal(await page.evaluate(() => 'measuring' in document.body.dataset), false);
  });
}
