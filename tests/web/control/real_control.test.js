// Control points on the page against the real server: a simulated flight without any position is brought to where it was
// flown by a list that is imported and marks that are clicked; they are saved as they are made.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { drag, mapIdle } from '../support/browser.js';
import { assertAccessible } from '../support/pages.js';
import { geodesicLength } from '../../../web/src/map/geodesy.js';
import { applyPoints, choosePhoto, clickPixel, importList, markPoint, openPoint, saved } from './marking.js';
import { get, makeMap, missing_exiftool, optionsOf, stripPlaces, useRealServer } from '../support/real_flights.js';

const used = useRealServer();
const flown = (/** @type {string} */ name) => used.simulate(name, 16, '800x600', '--no-world', '--noise', 'xmp');

/** @param {number[]} quaternion w, x, y, z @param {number[]} v */
function turned([w, ...axis], v) {
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const twice = cross(axis, v).map((value) => 2 * value);
  const twist = cross(axis, twice);
  return v.map((value, i) => value + w * twice[i] + twist[i]);
}

/** Surveyed places on the simulated ground, and the three photos that show each nearest to their middle. */
function survey(truth) {
  const { intrinsics: lens, origin, photos } = truth;
  const along = (axis, key) => {
    const sorted = [...photos].sort((a, b) => a[key] - b[key]);
    const [first, last] = [sorted[0], sorted[sorted.length - 1]];
    return (last.camera_center_in_enu[axis] - first.camera_center_in_enu[axis]) / (last[key] - first[key]);
  };
  const [a_degree_east, a_degree_north] = [along(0, 'lon_deg'), along(1, 'lat_deg')];
  return [[-20, -18], [20, -16], [2, 20], [18, 18], [-18, 16], [0, 0]].map(([east, north], i) => {
    const marks = photos.flatMap((photo) => {
      const [x, y, z] = turned(photo.cam_from_enu_wxyz, [east, north, 0].map((value, k) => value - photo.camera_center_in_enu[k]));
      const at = { x: (lens.focal_x_px * x) / z + lens.center_x_px, y: (lens.focal_y_px * y) / z + lens.center_y_px };
      const is_in = at.x > 20 && at.y > 20 && at.x < lens.width_px - 20 && at.y < lens.height_px - 20;
      return is_in ? [{ photo: photo.name, ...at, off: Math.hypot(at.x - lens.center_x_px, at.y - lens.center_y_px) }] : [];
    });
    return { name: `P${i + 1}`, lon: origin.lon_deg + east / a_degree_east, lat: origin.lat_deg + north / a_degree_north, height: origin.height_ellipsoid_m, all: new Set(marks.map(({ photo }) => photo)), marks: marks.sort((a, b) => a.off - b.off).slice(0, 3) };
  });
}

const table = (points) => ['name;lon;lat;height', ...points.map(({ name, lon, lat, height }) => `${name};${lon.toFixed(9)};${lat.toFixed(9)};${height}`)].join('\n');

test('a map without any position is placed by points that are imported and clicked', optionsOf(missing_exiftool, 560_000), async () => {
  const { truth, photos } = flown('nowhere');
  stripPlaces(photos);
  const points = survey(truth);
  const { server, page, foreign_requests, console_errors } = await used.openServer('data');
  const id = await makeMap(page, server.url, photos);
  await importList(page, table(points), 'EPSG:4326');
  assert.equal(await page.locator('#control-points tbody tr').count(), 6);
  assert.ok(await page.isDisabled('#control-apply'));
  assert.match(await page.innerText('#control-advice'), /3 more points/);

  // Nothing tells yet which photos show the first: all are offered.
  await openPoint(page, 'P1');
  assert.equal(await page.locator('#marking .frame').count(), 16);
  const [first] = points[0].marks;
  await choosePhoto(page, first.photo);
  await clickPixel(page, first);
  await assertAccessible(page, 'marking dialog');
  // The keyboard moves the cross, Enter the mark to it, and the next is undone.
  const kept = async () => (await get(server.url, `flights/${id}/control`)).points[0].marks[0];
  await page.keyboard.press('Shift+ArrowRight');
  await page.keyboard.press('Enter');
  await page.keyboard.press('ArrowUp');
  await page.keyboard.press('Enter');
  await page.keyboard.press('Control+z');
  await saved(page);
  const moved = await kept();
  assert.equal(moved.photo, first.photo);
  assert.ok(Math.abs(moved.x - first.x - 10) < 0.6 && Math.abs(moved.y - first.y) < 0.6, JSON.stringify([moved, first]));
  await page.click('#marking-undo');
  // Dragged away and back again by undoing.
  const mark = await page.locator('#marking-mark').boundingBox();
  await drag(page, [mark.x + 16, mark.y + 16], [mark.x + 60, mark.y + 50]);
  await saved(page);
  assert.ok((await kept()).x > first.x + 1);
  await page.keyboard.press('Control+z');
  await saved(page);
  assert.ok(Math.abs((await kept()).x - first.x) < 0.6, 'the whole drag is one step');
  await page.keyboard.press('Escape');
  for (const { name, marks } of points.slice(0, 2)) await markPoint(page, name, marks);

  // By now the map tells where the others are expected: within some pixels, the best photo first.
  await saved(page);
  await openPoint(page, 'P3');
  const best = await page.getAttribute('#marking .frame >> nth=0', 'title');
  assert.match(best, /vertical/, 'with how far off the vertical it looks');
  assert.ok(points[2].all.has(best.split(',')[0]), `${best} shows P3`);
  await page.waitForSelector('.marking-expected:not([hidden])');
  assert.ok(await choosePhoto(page, points[2].marks[0].photo));
  const circle = await page.locator('.marking-expected').boundingBox();
  const image = await page.locator('#marking .viewer-image').boundingBox();
  const scale = image.width / 800;
  const off_px = Math.hypot((circle.x + 22 - image.x) / scale - points[2].marks[0].x, (circle.y + 22 - image.y) / scale - points[2].marks[0].y);
  assert.ok(off_px < 40, `expected ${off_px} px off`);
  await page.keyboard.press('Escape');
  for (const { name, marks } of points.slice(2, 5)) await markPoint(page, name, marks);

  // All of it is there again after a reload.
  await saved(page);
  await page.reload();
  await page.waitForSelector('#report');
  await mapIdle(page);
  await page.click('#control > summary');
  await page.waitForSelector('#control-points .control-ready');
  assert.equal(await page.locator('#control-points .control-ready').count(), 5);
  const flight = await applyPoints(page, server.url, id);

  const report = await get(server.url, `flights/${id}/report`);
  assert.equal(report.is_placed, true);
  assert.ok(!report.timings.some(({ stage }) => stage === 'check'), 'no photo was compared again');
  const { lon, lat } = points[5];  // that no mark was set for
  assert.ok(flight.bounds[0] < lon && flight.bounds[1] < lat && flight.bounds[2] > lon && flight.bounds[3] > lat);
  const sees = await get(server.url, `flights/${id}/at?lon=${lon}&lat=${lat}`);
  const check = points[5].marks[0];
  const seen = sees.photos.find(({ name }) => name === check.photo);
  assert.ok(Math.hypot(seen.x - check.x, seen.y - check.y) < 20, `${JSON.stringify(seen)} where ${JSON.stringify(check)} is true`);
  for (const photo of (await get(server.url, `flights/${id}/photos.geojson`)).features) {
    const real = truth.photos.find(({ name }) => name === photo.properties.name);
    const miss_m = geodesicLength([photo.properties.camera_lon, photo.properties.camera_lat], [real.lon_deg, real.lat_deg]);
    assert.ok(miss_m < 5, `${real.name} lies ${miss_m} m off what it recorded`);
  }
  // The panel is still open, with the residuals, and the points are on the map.
  await page.waitForSelector('#control-residuals');
  assert.match(await page.innerText('#control-points tbody tr:first-child'), /\d.*ft.*px/);
  await page.click('#control-residuals > summary');
  assert.equal(await page.locator('#control-residuals tbody tr').count(), 15);
  await page.waitForSelector('.control-mark[data-point="P6"]');
  await assertAccessible(page, 'panel of control points');
  assert.deepEqual(foreign_requests, []);
  assert.deepEqual(console_errors, []);
});

test('a mark that contradicts the others is flagged, and what the server refuses is said in the form', optionsOf('', 560_000), async () => {
  const { truth, photos } = flown('placed');
  const points = survey(truth);
  const { server, page, console_errors } = await used.openServer('placed_data', ['--base-path', '/maps']);
  const id = await makeMap(page, server.url, photos);
  // Until the flight's points are here none can be added: they would take the place of all.
  let answer = () => {};
  const asked = new Promise((resolve) => void page.route('**/control', async (route) => {
    resolve(undefined);
    await new Promise((go) => (answer = () => go(undefined)));
    await route.abort();
  }, { times: 1 }));
  await page.click('#control > summary');
  await asked;
  assert.ok(!(await page.isVisible('#control-add')) && !(await page.isVisible('#control-import-open')));
  answer();
  await page.click('#control-retry');
  await page.click('#control-import-open');
  await page.fill('#control-text', table(points));
  await page.fill('#control-system', 'EPSG:999999');
  await page.click('#control-import-go');
  await page.waitForSelector('#control-import-fault:has-text("not known")');
  await page.click('#control-import button:has-text("Cancel")');
  assert.equal(await page.locator('#control-points tbody tr').count(), 0, 'nothing was changed');
  // As gcp_list.txt, with its marks, one of them wrong.
  points[1].marks[0].x += points[1].marks[0].x > 400 ? -90 : 90;
  const rows = points.flatMap(({ name, lon, lat, height, marks }) => marks.map((mark) => `${lon} ${lat} ${height} ${mark.x + 0.5} ${mark.y + 0.5} ${mark.photo} ${name}`));
  await importList(page, ['EPSG:4326', ...rows].join('\n'));
  await applyPoints(page, server.url, id);
  await page.waitForSelector('#control-residuals .outlier', { state: 'attached' });
  await page.click('#control-residuals > summary');
  assert.match(await page.innerText('#control-residuals summary'), /1 to check/);
  assert.match(await page.innerText('#control-residuals .outlier'), new RegExp(`P2\\s+${points[1].marks[0].photo}`));
  // By hand: a point, changed and removed again.
  await page.click('#control-add');
  for (const [field, text] of [['name', 'by hand'], ['x', '7.1'], ['y', 'north']]) await page.fill(`#control-${field}`, text);
  await page.click('#control-point-go');
  await page.waitForSelector('#control-point-fault:has-text("must be numbers")');
  await page.fill('#control-y', '46,8001');
  await page.click('#control-point-go');
  await page.waitForSelector('#control-points [data-point="by hand"]');
  await page.click('[aria-label="Remove by hand"]');
  await saved(page);
  assert.equal((await get(server.url, `flights/${id}/control`)).points.length, 6);
  assert.deepEqual(console_errors.filter((text) => !/422|ERR_FAILED/.test(text)), []);
});
