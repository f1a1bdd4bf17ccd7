// The page against the real server and a real flight, from the drop to the undone deletion, as a user goes through it.
// Skips where the photos are not.
import assert from 'node:assert/strict';
import { readFileSync, readdirSync, writeFileSync } from 'node:fs';
import { basename, join } from 'node:path';
import { test } from 'node:test';
import { holdRequests, mapIdle, openPhotoCard, screenshotPixels } from '../support/browser.js';
import { realPhotos } from '../support/real_server.js';
import { assertOpensAtItsPixel, optionsOf, run, useRealServer } from '../support/real_flights.js';

const photos = realPhotos('brighton_beach');
const missing = photos.length === 18 ? '' : 'no real photos';
const used = useRealServer(missing);

/** A JPEG without what its camera wrote about it. @param {Buffer} jpeg */
function withoutExif(jpeg) {
  const kept = [jpeg.subarray(0, 2)];
  let at = 2;
  for (; jpeg[at + 1] !== 0xda; at += 2 + jpeg.readUInt16BE(at + 2)) {
    if (jpeg[at + 1] !== 0xe1) kept.push(jpeg.subarray(at, at + 2 + jpeg.readUInt16BE(at + 2)));
  }
  return Buffer.concat([...kept, jpeg.subarray(at)]);
}

const metresBetween = (/** @type {number[]} */ [lon_a, lat_a], /** @type {number[]} */ [lon_b, lat_b]) => {
  const rad = Math.PI / 180;
  const h = Math.sin(((lat_b - lat_a) * rad) / 2) ** 2 + Math.cos(lat_a * rad) * Math.cos(lat_b * rad) * Math.sin(((lon_b - lon_a) * rad) / 2) ** 2;
  return 2 * 6_371_008.8 * Math.asin(Math.sqrt(h));
};

/** Measures from one camera to another, and compares with what their positions say. */
async function assertMeasures(page, url, id) {
  const { features } = await (await fetch(`${url}api/v1/flights/${id}/photos.geojson`)).json();
  const ends = [features[0], features.at(-1)].map(({ properties }) => [properties.camera_lon, properties.camera_lat]);
  await page.click('#tool-distance');
  await page.locator('#map canvas').focus();
  for (const end of ends) {
    await page.evaluate((center) => /** @type {any} */ (window).skyquilt.map.jumpTo({ center }), end);
    await page.keyboard.press('Enter');
  }
  await page.selectOption('#units', 'metric');
  const [, number] = (await page.textContent('#measure-result')).match(/^([\d.]+)\sm/);
  const want_m = metresBetween(ends[0], ends[1]);
  assert.ok(Math.abs(Number(number) - want_m) < want_m * 0.006 + 0.01, `${number} for ${want_m} m`);  // a sphere against the ellipsoid
  await page.click('#tool-distance');
}

/** The program finds the same photos for the place, at the same pixels. */
async function assertProgramLocates(page, url, id, data) {
  const { lng, lat } = await page.evaluate(() => /** @type {any} */ (window).skyquilt.map.getCenter());
  const { photos: seen } = await (await fetch(`${url}api/v1/flights/${id}/at?lon=${lng}&lat=${lat}`)).json();
  const revision = readdirSync(join(data, 'flights', id)).find((name) => /^r\d+$/.test(name));
  const [line] = run('locate', join(data, 'flights', id, revision), '--lonlat', `${lng},${lat}`).split('\n').filter((text) => text.includes(seen[0].name));
  const [x, y] = line.replace(seen[0].name, '').match(/[\d.]+/g).map(Number);
  assert.ok(Math.hypot(x - seen[0].x, y - seen[0].y) < 1, `${line} for ${JSON.stringify(seen[0])}`);
}

test('a real flight goes from the drop to the map, and every tool on it says what is true', optionsOf(missing, 500_000), async () => {
  const { folder } = used;
  const data = join(folder, 'data');
  const bad = { 'text.jpg': Buffer.from('not a photo'), 'cut.jpg': readFileSync(photos[3]).subarray(0, 900_000), 'nowhere.jpg': withoutExif(readFileSync(photos[4])) };
  for (const [name, bytes] of Object.entries(bad)) writeFileSync(join(folder, name), bytes);
  const server = await used.serve('data');
  const { page, foreign_requests, console_errors } = await used.open(server.url);
  // Half of them wait until the first are on the map.
  const release = await holdRequests(page, '**/api/v1/uploads', 9);
  await page.setInputFiles('#files-input', [...photos, ...Object.keys(bad).map((name) => join(folder, name))]);
  await page.waitForSelector('#verdict');
  assert.match(await page.textContent('#verdict'), /18|19|20/);
  await page.waitForFunction(() => Number(document.getElementById('preview-note')?.textContent?.match(/\d+/)?.[0]) >= 3, null, { timeout: 120_000 });
  await mapIdle(page);
  const box = await page.locator('#map').boundingBox();
  const clip = { x: box.x + box.width * 0.4, y: box.y + box.height * 0.4, width: box.width * 0.2, height: box.height * 0.2 };
  assert.ok((await screenshotPixels(page, clip)).colours > 200, 'the first photos lie on the map');
  release();
  await page.waitForSelector('#job-progress', { timeout: 60_000 });
  await page.waitForSelector('#report', { timeout: 240_000 });
  await mapIdle(page);
  const report = await page.textContent('#report');
  // The photo without any record is placed by what it shows.
  assert.match(report, /19 \/ \d\d/);
  assert.ok(report.includes('cut.jpg'), `cut.jpg is not named: ${report}`);
  assert.ok((await screenshotPixels(page, clip)).colours > 500, 'the map is there');

  const id = (await page.evaluate(() => location.hash)).split('/')[2];
  await openPhotoCard(page);
  await assertOpensAtItsPixel(page, server.url, id);
  await assertProgramLocates(page, server.url, id, data);
  await assertMeasures(page, server.url, id);

  // The same place again from every other photo, coarser: both are seen through the slider.
  const json = { 'Content-Type': 'application/json' };
  const other = await (await fetch(`${server.url}api/v1/flights`, { method: 'POST', headers: json, body: '{"name":"Every other photo"}' })).json();
  for (const path of photos.filter((_, i) => i % 2 === 0)) {
    await fetch(`${server.url}api/v1/flights/${other.id}/files/${basename(path)}`, { method: 'PUT', body: readFileSync(path) });
  }
  await fetch(`${server.url}api/v1/flights/${other.id}/jobs`, { method: 'POST', headers: json, body: '{"options":{"gsd_m":0.2,"method":"imu"}}' });
  const state = async () => (await (await fetch(`${server.url}api/v1/flights/${other.id}`)).json()).state;
  for (let i = 0; i < 240 && (await state()) !== 'ready'; i += 1) await page.waitForTimeout(500);
  assert.equal(await state(), 'ready');
  await page.evaluate(() => /** @type {any} */ (window).skyquilt.map.zoomTo(20, { animate: false }));
  await page.click('#tool-compare');
  await page.click('.choice');
  await mapIdle(page, '#map-above');
  const picture = async (/** @type {string} */ key) => {
    await page.focus('#compare-slider');
    await page.keyboard.press(key);
    await mapIdle(page, '#map-above');
    return screenshotPixels(page, clip);
  };
  const [left, right] = [await picture('End'), await picture('Home')];
  assert.ok(left.colours !== right.colours, 'the finished map and the coarse one are not the same picture');
  await page.click('#compare-bar .icon-button');
  await page.waitForSelector('#map-above', { state: 'detached' });

  const download = page.waitForEvent('download');
  await page.click('#flight-download');
  await page.click('.download[href*="mbtiles"]');
  const saved = join(folder, 'saved.mbtiles');
  await (await download).saveAs(saved);
  assert.equal(readFileSync(saved).subarray(0, 15).toString(), 'SQLite format 3');
  await page.keyboard.press('Escape');

  const count = async () => (await (await fetch(`${server.url}api/v1/flights`)).json()).flights.length;
  await page.click('#flight-delete');
  await page.click('.note-action');
  await page.waitForFunction(() => document.querySelectorAll('.flights li').length === 2);
  assert.equal(await count(), 2);
  assert.deepEqual(foreign_requests, []);
  assert.deepEqual(console_errors, []);
});
