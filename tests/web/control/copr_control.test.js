// Control points on the page with a real flight: 41 photos from a kite without any position, and targets surveyed on the
// dunes, whose pixels are clicked as the surveyor noted them.
import assert from 'node:assert/strict';
import { existsSync, mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { after, before, test } from 'node:test';
import { launchBrowser, missingForBrowser, openPage } from '../support/browser.js';
import { missingBinary, realPhotos, startServer } from '../support/real_server.js';
import { parseControlList } from '../../../web/src/control/control_lists.js';
import { geodesicLength } from '../../../web/src/map/geodesy.js';
import { applyPoints, get, importList, makeMap, markPoint } from './marking.js';

const photos = realPhotos('copr_41');
const list_path = photos.length > 0 ? join(dirname(dirname(photos[0])), 'gcp_list.txt') : '';
const missing = missingForBrowser() || missingBinary() || (existsSync(list_path) ? '' : 'no real photos');

let browser;
let folder = '';
before(async () => {
  if (missing) return;
  folder = mkdtempSync(join(tmpdir(), 'skyquilt-copr-'));
  browser = await launchBrowser();
});
after(async () => {
  await browser?.close();
  if (folder) rmSync(folder, { recursive: true, force: true });
});

test('the dunes come to their surveyed place', { skip: missing || false, timeout: 590_000 }, async () => {
  const list = parseControlList(readFileSync(list_path, 'utf8'));
  const names = new Map(photos.map((path) => [path.split('/').pop().toLowerCase(), path.split('/').pop()]));
  for (const point of list.points) for (const mark of point.marks) mark.photo = names.get(mark.photo.toLowerCase()) ?? mark.photo;
  const clicked = list.points.filter(({ marks }) => marks.length >= 3).slice(0, 6);
  assert.ok(clicked.length >= 6);
  const server = await startServer(join(folder, 'data'));
  const { page, context, foreign_requests, console_errors } = await openPage(browser, server.url);
  try {
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
    const used = report.alignment.ground_control.filter((point) => point.is_used).length;
    assert.ok(used >= 4, `${used} points are used`);
    await page.waitForSelector('#control-residuals');
    await page.click('#control-residuals > summary');
    assert.ok((await page.locator('#control-residuals tbody tr').count()) >= 15);
    if (process.env.SKYQUILT_PICTURES) await page.screenshot({ path: join(process.env.SKYQUILT_PICTURES, 'copr_control.png') });
    assert.deepEqual(foreign_requests, []);
    assert.deepEqual(console_errors, []);
  } finally {
    await context.close();
    assert.equal(await server.stop(), 0);
  }
});
