// The page against the real server and a simulated flight: drop, wait, look, compare with the flight's truth, delete.
import assert from 'node:assert/strict';
import { spawn, spawnSync } from 'node:child_process';
import { existsSync, mkdtempSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { launchBrowser, mapIdle, missingForBrowser, openPage } from './support/browser.js';
import { screenshotPixels } from './support/pixels.js';

const binary = process.env.SKYQUILT_BINARY ?? fileURLToPath(new URL('../../build/release/bin/skyquilt', import.meta.url));
const missing = missingForBrowser() || (existsSync(binary) ? '' : `no program at ${binary}`);
const options = { skip: missing || false, timeout: 400_000 };

let browser;
let folder = '';
let photos = [];

before(async () => {
  if (missing) return;
  folder = mkdtempSync(join(tmpdir(), 'skyquilt-real-'));
  const made = spawnSync(binary, ['simulate', '-o', join(folder, 'flight'), '--photos', '6', '--size', '800x600'], { encoding: 'utf8' });
  assert.equal(made.status, 0, made.stderr);
  photos = findPhotos(join(folder, 'flight'));
  assert.equal(photos.length, 6);
  browser = await launchBrowser();
});
after(async () => {
  await browser?.close();
  if (folder) rmSync(folder, { recursive: true, force: true });
});

/** @param {string} root @returns {string[]} */
function findPhotos(root) {
  return readdirSync(root, { withFileTypes: true })
    .flatMap((entry) => (entry.isDirectory() ? findPhotos(join(root, entry.name)) : [join(root, entry.name)]))
    .filter((path) => /\.jpe?g$/i.test(path))
    .sort();
}

/** Starts the server and waits for the line that tells its address. */
async function startServer(listen = '127.0.0.1:0') {
  const child = spawn(binary, ['serve', '--data', join(folder, 'data'), '--listen', listen], { stdio: ['ignore', 'pipe', 'pipe'] });
  let output = '';
  const url = await new Promise((resolve, reject) => {
    const read = (chunk) => {
      output += chunk;
      const match = output.match(/serving at (http:\/\/127\.0\.0\.1:\d+\/)/);
      if (match) resolve(match[1]);
    };
    child.stdout.on('data', read);
    child.stderr.on('data', read);
    child.on('exit', (code) => reject(new Error(`the server ended with ${code}: ${output}`)));
  });
  const stop = (signal = 'SIGTERM') =>
    new Promise((resolve) => {
      child.removeAllListeners('exit');
      child.on('exit', (code) => resolve(code));
      child.kill(/** @type {any} */ (signal));
    });
  return { url, stop };
}

test('dropped photos become a map on the real server, even when it is killed in between', options, async () => {
  let server = await startServer();
  const { page, context, foreign_requests, console_errors } = await openPage(browser, server.url);
  try {
    await page.waitForSelector('#flights-message:not([hidden])');
    const text_file = join(folder, 'text.jpg');
    writeFileSync(text_file, 'not a photo');
    await page.setInputFiles('#files-input', [...photos, text_file]);
    await page.waitForSelector('#job-progress, #report', { timeout: 60_000 });

    const { port } = new URL(server.url);
    await server.stop('SIGKILL');
    await page.waitForTimeout(1500);
    server = await startServer(`127.0.0.1:${port}`);

    await page.waitForSelector('#report', { timeout: 240_000 });
    await mapIdle(page);
    assert.match(await page.textContent('#report'), /6 \/ 6/);
    const box = await page.locator('#map').boundingBox();
    const middle = await screenshotPixels(page, { x: box.x + box.width * 0.35, y: box.y + box.height * 0.35, width: box.width * 0.3, height: box.height * 0.3 });
    assert.ok(middle.colours > 60, `only ${middle.colours} colours in the middle of the map`);

    // Every photo has its footprint, and its camera stands within the mosaic's bounds.
    const id = (await page.evaluate(() => location.hash)).split('/')[2];
    const [geojson, flight] = await page.evaluate(async (flight_id) => {
      const get = async (path) => (await fetch(path)).json();
      return [await get(`/api/v1/flights/${flight_id}/photos.geojson`), await get(`/api/v1/flights/${flight_id}`)];
    }, id);
    assert.equal(geojson.features.length, 6);
    const [west, south, east, north] = flight.bounds;
    for (const { properties } of geojson.features) {
      assert.ok(properties.camera_lon > west && properties.camera_lon < east, properties.name);
      assert.ok(properties.camera_lat > south && properties.camera_lat < north, properties.name);
    }
    await page.locator('#map canvas').focus();
    await page.keyboard.press('Enter');
    await page.waitForSelector('#photo-card:not([hidden])');

    const download = page.waitForEvent('download');
    await page.click('.download');
    assert.match((await download).suggestedFilename(), /\.mbtiles$/);

    await page.click('#flight-delete');
    await page.click('.note .icon-button');
    await page.waitForFunction(async () => (await (await fetch('/api/v1/flights')).json()).flights.length === 0);
    assert.deepEqual(foreign_requests, []);
    assert.deepEqual(console_errors.filter((text) => !/ERR_CONNECTION|ERR_EMPTY_RESPONSE/.test(text)), []);
  } finally {
    await context.close();
    assert.equal(await server.stop(), 0);
  }
});
