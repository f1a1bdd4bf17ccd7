// Placing a map on the page against the real server: a simulated flight that recorded no position lies nowhere, and by two
// clicks and two typed places comes to where it was flown, to a few metres.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { mapIdle } from '../support/browser.js';
import { geodesicLength } from '../../../web/src/map/geodesy.js';
import { get, makeMap, missing_exiftool, moveMap, optionsOf, run, stripPlaces, useRealServer } from '../support/real_flights.js';

const kTruth = { lat: 46.8, lon: 7.1 };  // of the simulated take-off
const used = useRealServer();

/** Where a photo's camera was, as the map has it: what a user finds on Earth. */
async function cameras(url, id) {
  const { features } = await get(url, `flights/${id}/photos.geojson`);
  return new Map(features.map(({ properties }) => [properties.name, [properties.camera_lon, properties.camera_lat]]));
}

/** Metres east and north of a place nearby. */
const metresFrom = ([lon0, lat0], [lon, lat]) => [(lon - lon0) * 111_320 * Math.cos((lat0 * Math.PI) / 180), (lat - lat0) * 111_170];

/** How far from where a clicked point is the map shows it now, by where two cameras were before and after. */
function missOfPoint(before, after, names, shown, is) {
  const [a, b] = names;
  const [x, y] = metresFrom(before.get(a), before.get(b)), [u, v] = metresFrom(after.get(a), after.get(b));
  const [re, im] = [(u * x + v * y) / (x * x + y * y), (v * x - u * y) / (x * x + y * y)];  // turn and scale, as a complex number
  const [p, q] = metresFrom(before.get(a), shown), [s, t] = metresFrom(after.get(a), is);
  return Math.hypot(re * p - im * q - s, re * q + im * p - t);
}

/** Clicks the map at a place, and types where it is. */
async function point(page, number, shown, [lon, lat]) {
  const box = await page.locator('#map').boundingBox();
  const spot = await page.evaluate((p) => /** @type {any} */ (window).skyquilt.map.project(p), shown);
  await page.mouse.click(box.x + spot.x, box.y + spot.y);
  await page.fill(`#place-is-${number}`, `${lat.toFixed(7)}, ${lon.toFixed(7)}`);
  await page.keyboard.press('Enter');
}

/** Presses the button, and waits for the map of the next revision. */
async function goAndWait(page, url, id) {
  const flight = await moveMap(page, url, id, '#place-go');
  // The view has gone along.
  const seen = await page.evaluate(() => {
    const bounds = /** @type {any} */ (window).skyquilt.map.getBounds();
    return [bounds.getWest(), bounds.getSouth(), bounds.getEast(), bounds.getNorth()];
  });
  const [west, south, east, north] = flight.bounds;
  assert.ok(seen[0] < west && seen[1] < south && seen[2] > east && seen[3] > north, `the view ${seen} holds ${flight.bounds}`);
  assert.ok(east - west > 0.2 * (seen[2] - seen[0]), 'and not much more');
  return flight;
}

test('a map without any position comes to its place by two clicks', optionsOf(missing_exiftool, 500_000), async () => {
  const flown = used.simulate('flight', 12, '1200x900', '--noise', 'exact', '--no-world');
  const truth = flown.truth.photos;
  // The same photos with the true poses that they recorded.
  run('stitch', join(used.folder, 'flight', 'photos'), '-o', join(used.folder, 'known'));
  const true_bounds = JSON.parse(readFileSync(join(used.folder, 'known', 'report.json'), 'utf8')).bounds;
  stripPlaces(flown.photos);
  const { server, page, foreign_requests, console_errors } = await used.openServer('data');
  const id = await makeMap(page, server.url, flown.photos);
  assert.match(await page.innerText('#result-verdict'), /Not georeferenced/);
  const before = await get(server.url, `flights/${id}`);
  assert.ok(Math.abs(before.bounds[0]) < 0.1 && Math.abs(before.bounds[1]) < 0.1, `${before.bounds} is near 0, 0`);
  const shown = await cameras(server.url, id);
  const isAt = (/** @type {any} */ { camera_center_in_enu: [east_m, north_m] }) =>
    [kTruth.lon + east_m / (111_320 * Math.cos((kTruth.lat * Math.PI) / 180)), kTruth.lat + north_m / 111_170];
  // The two photos furthest apart.
  const [a, b] = truth.flatMap((one, i) => truth.slice(i + 1).map((other) => [one, other]))
    .sort(([a, b], [c, d]) => geodesicLength(isAt(c), isAt(d)) - geodesicLength(isAt(a), isAt(b)))[0];
  await page.click('#flight-place');
  await page.waitForSelector('#place-card:not([hidden])');
  await mapIdle(page);
  await point(page, 1, shown.get(a.name), isAt(a));
  assert.ok(await page.isDisabled('#place-go'));
  await point(page, 2, shown.get(b.name), isAt(b));
  const after = await goAndWait(page, server.url, id);

  // The points lie where it was said, to two pixels of the map.
  const { gsd_m } = await get(server.url, `flights/${id}/report`);
  const places = after.job.options.place;
  assert.equal(places.length, 2);
  const now = await cameras(server.url, id);
  for (const { shown: [lat, lon], is } of places) {
    const miss_m = missOfPoint(shown, now, [a.name, b.name], [lon, lat], [is[1], is[0]]);
    assert.ok(miss_m < 2 * gsd_m, `a point lies ${miss_m} m off, pixels are ${gsd_m} m`);
  }

  // Every camera, also those that were not clicked, stands where it was flown.
  const placed = await cameras(server.url, id);
  for (const photo of truth) {
    const miss_m = geodesicLength(placed.get(photo.name), isAt(photo));
    assert.ok(miss_m < 2, `${photo.name} lies ${miss_m} m off`);
  }
  const [west, south, east, north] = after.bounds;
  for (const [corner, true_corner] of [[[west, south], [true_bounds[0], true_bounds[1]]], [[east, north], [true_bounds[2], true_bounds[3]]]]) {
    const miss_m = geodesicLength(corner, true_corner);
    assert.ok(miss_m < 4, `${after.bounds} is ${miss_m} m off ${true_bounds}`);
  }
  const report = await get(server.url, `flights/${id}/report`);
  assert.equal(report.is_placed, true);
  assert.match(report.warnings.join(' '), /placed by hand, by 2 places/);
  assert.equal(await page.locator('#flight-place').count(), 0);
  assert.doesNotMatch(await page.innerText('#result-verdict'), /Not georeferenced/);
  assert.deepEqual(foreign_requests, []);
  assert.deepEqual(console_errors, []);
});

test('a map that has its place is moved by one point, and points too near together are refused in words', optionsOf('', 500_000), async () => {
  const { photos } = used.simulate('placed', 6, '800x600', '--no-world');
  const { server, page, console_errors } = await used.openServer('placed_data');
  const id = await makeMap(page, server.url, photos);
  assert.equal(await page.locator('#flight-place').count(), 0);
  const before = await get(server.url, `flights/${id}`);
  const [west, south, east, north] = before.bounds;
  const middle = [(west + east) / 2, (south + north) / 2];
  await page.click('#flight-move');
  await page.waitForSelector('#place-card:not([hidden])');
  await mapIdle(page);
  await point(page, 1, middle, middle);
  await point(page, 2, [middle[0] + 0.01 * (east - west), middle[1]], [middle[0] + 0.001, middle[1]]);
  assert.ok(await page.locator('#place-hint').isVisible());
  await page.click('#place-go');
  await page.waitForSelector('#failure:has-text("too near together")', { timeout: 120_000 });
  assert.match(await page.innerText('#failure'), /The map could not be moved/);
  await page.click('#place-again');
  await page.click('[aria-label="Remove point 2"]');
  await page.fill('#place-is-1', `${middle[1] + 0.0004}, ${middle[0] - 0.0003}`);
  await page.keyboard.press('Enter');
  assert.match(await page.innerText('#place-effect'), /^The map moves by 16[4-7]\.\d\sft\.$/);  // 50 m; the browser speaks American English
  const after = await goAndWait(page, server.url, id);
  const wanted = [west - 0.0003, south + 0.0004, east - 0.0003, north + 0.0004];
  for (const [i, j] of [[0, 1], [2, 3]]) {
    // By a click, which hits a pixel of the screen.
    const miss_m = geodesicLength([after.bounds[i], after.bounds[j]], [wanted[i], wanted[j]]);
    assert.ok(miss_m < 2, `${after.bounds} is ${miss_m} m off ${wanted}`);
  }
  assert.deepEqual(console_errors, []);
});
