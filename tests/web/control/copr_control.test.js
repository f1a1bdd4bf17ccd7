// Control points on the page with a real flight: 41 photos from a kite without any position, and targets surveyed on the
// dunes, whose pixels are clicked as the surveyor noted them.
import assert from 'node:assert/strict';
import { existsSync, readFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { test } from 'node:test';
import { realPhotos } from '../support/real_server.js';
import { parseControlList } from '../../../web/src/control/control_lists.js';
import { geodesicLength } from '../../../web/src/map/geodesy.js';
import { applyPoints, importList, markPoint } from './marking.js';
import { get, makeMap, optionsOf, useRealServer } from '../support/real_flights.js';

const photos = realPhotos('copr_41');
const list_path = photos.length > 0 ? join(dirname(dirname(photos[0])), 'gcp_list.txt') : '';
const missing = existsSync(list_path) ? '' : 'no real photos';
const used = useRealServer(missing);

test('the dunes come to their surveyed place', optionsOf(missing, 590_000), async () => {
  const list = parseControlList(readFileSync(list_path, 'utf8'));
  const names = new Map(photos.map((path) => [path.split('/').pop().toLowerCase(), path.split('/').pop()]));
  for (const point of list.points) for (const mark of point.marks) mark.photo = names.get(mark.photo.toLowerCase()) ?? mark.photo;
  const clicked = list.points.filter(({ marks }) => marks.length >= 3).slice(0, 6);
  assert.ok(clicked.length >= 6);
  const { server, page, foreign_requests, console_errors } = await used.openServer('data');
  const id = await makeMap(page, server.url, photos);
  assert.equal((await get(server.url, `flights/${id}/report`)).is_placed, false);
  await importList(page, list.points.map(({ name, x, y }) => `${name}, ${x}, ${y}`).join('\n'), list.reference_system);
  assert.equal(await page.locator('#control-points tbody tr').count(), list.points.length);
  for (const { name, marks } of clicked) await markPoint(page, name, marks.slice(0, 3));
  const flight = await applyPoints(page, server.url, id);

  // The whole map lies where the targets are, and is no larger than such a flight can be.
  const { points } = await get(server.url, `flights/${id}/control`);
  const [west, south, east, north] = flight.bounds;
  for (const { name, lon, lat } of points) assert.ok(lon > west && lat > south && lon < east && lat < north, `${name} is on the map`);
  assert.ok(geodesicLength([west, south], [east, north]) < 400);
  // Also marks that nobody clicked lie where they were surveyed. (One of the list is on another target, and the survey
  // itself contradicts the photos by a metre.)
  const misses_m = [];
  for (const { name, marks } of list.points) {
    const { lon, lat } = points.find((point) => point.name === name);
    for (const { photo, x, y } of marks) {
      const ground = await get(server.url, `flights/${id}/photos/${photo}/ground?x=${x}&y=${y}`);
      if (ground.lon !== undefined) misses_m.push(geodesicLength([ground.lon, ground.lat], [lon, lat]));
    }
  }
  misses_m.sort((a, b) => a - b);
  assert.ok(misses_m.length > 20, `${misses_m.length} marks`);
  assert.ok(misses_m[Math.floor(misses_m.length / 2)] < 2.5 && misses_m[Math.floor(misses_m.length * 0.9)] < 8, `${misses_m}`);
  const report = await get(server.url, `flights/${id}/report`);
  assert.equal(report.is_placed, true);
  const used_points = report.alignment.ground_control.filter((point) => point.is_used).length;
  assert.ok(used_points >= 4, `${used_points} points are used`);
  await page.waitForSelector('#control-residuals');
  await page.click('#control-residuals > summary');
  assert.ok((await page.locator('#control-residuals tbody tr').count()) >= 15);
  if (process.env.SKYQUILT_PICTURES) await page.screenshot({ path: join(process.env.SKYQUILT_PICTURES, 'copr_control.png') });
  assert.deepEqual(foreign_requests, []);
  assert.deepEqual(console_errors, []);
});
