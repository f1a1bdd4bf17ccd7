// The page against the real server and a simulated flight: drop, wait, look, compare with the flight's truth, delete.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { before, test } from 'node:test';
import { setTimeout } from 'node:timers/promises';
import { holdRequests, mapIdle, openPhotoCard, screenshotPixels, until } from './support/browser.js';
import { tilePosition } from '../../web/src/map/tile_addresses.js';
import { addToken, assertOpensAtItsPixel, options, useSimulatedFlight } from './support/real_flights.js';
import { findPhotos } from './support/real_server.js';

const used = useSimulatedFlight();
/** @type {string[]} */
let photos = [];
before(() => {
  if (options.skip) return;
  photos = findPhotos(join(used.folder, 'flight'));
  assert.equal(photos.length, 6);
});

/** The page has found nobody at the server's address. @param {any} page */
const noticesItIsAway = (page) => page.waitForEvent('requestfailed', (/** @type {any} */ request) => /CONNECTION_REFUSED/.test(request.failure()?.errorText));

/** The saved GDAL settings and the GeoTIFF show the same ground at the same place. */
async function assertGdalSeesTheSame(page, url, id, [west, south, east, north]) {
  if (spawnSync('gdal_translate', ['--version']).error) return;
  const saved = page.waitForEvent('download');
  await page.click('text=Settings for GDAL');
  const settings = join(used.folder, 'map.gdal.xml');
  await (await saved).saveAs(settings);
  const edge_m = 20037508.342789244;
  const x = ((west + east) / 360) * edge_m;
  const y = (Math.atanh(Math.sin(((south + north) / 360) * Math.PI)) / Math.PI) * edge_m;
  const window = [x - 6, y + 6, x + 6, y - 6].map(String);
  const [tiles, cog] = [settings, `/vsicurl/${url}api/v1/flights/${id}/download.tif`].map((source, i) => {
    const raw = join(used.folder, `window${i}.raw`);
    const result = spawnSync('gdal_translate', ['-q', '-of', 'ENVI', '-b', '1', '-projwin', ...window, '-outsize', '128', '128', source, raw], { encoding: 'utf8' });
    assert.equal(result.status, 0, result.stderr);
    return readFileSync(raw);
  });
  let difference = 0;
  let mean = 0;
  tiles.forEach((value, i) => {
    difference += Math.abs(value - cog[i]) / tiles.length;
    mean += value / tiles.length;
  });
  // Both are compressed with loss; a shift by a pixel or a mirrored axis differs by far more.
  assert.ok(difference < 6, `tiles and GeoTIFF differ by ${difference} grey levels on average`);
  assert.ok(mean > 20, 'the window shows ground, not the outside');
}

/** The page's Share makes a link for who has nothing else, and Revoke ends it. */
async function assertSharesOneFlight(page, id) {
  await page.click('#flight-share');
  await page.click('#share-make');
  await page.waitForSelector('#share-made input');
  const link = await page.inputValue('#share-made input');
  const guests = await used.browser.newContext();
  try {
    const guest = await guests.newPage();
    await guest.goto(link);
    await guest.waitForSelector('#report');
    await mapIdle(guest);
    assert.ok(!guest.url().includes('token'), 'the address does not keep the token');
    assert.equal(await guest.locator('#flight-delete, #flight-rename, #flight-share').count(), 0);
    const token = new URL(link).hash.split('token=')[1];
    const asked = (/** @type {string} */ path) => guest.evaluate(async ([at, bearer]) => (await fetch(at, { headers: { Authorization: `Bearer ${bearer}` } })).status, [path, token]);
    assert.equal(await asked(`/api/v1/flights/${id}/download.mbtiles`), 200);
    assert.equal(await asked('/api/v1/webhooks'), 403);
    await page.locator('.shares li button').first().click();
    await page.waitForFunction(() => document.querySelectorAll('.shares li').length === 1);
    assert.equal(await asked(`/api/v1/flights/${id}`), 401);
  } finally {
    await guests.close();
  }
}

test('a server with tokens opens to the one that was typed, and to a share link', options, async () => {
  const data = join(used.folder, 'guarded');
  const [upload, read] = [addToken(data, 'upload'), addToken(data, 'read')];
  const server = await used.serve('guarded');
  const { page, context } = await used.open(server.url);
  await page.fill('#token-input', upload);
  await page.keyboard.press('Enter');
  await page.waitForSelector('#token-dialog', { state: 'detached' });
  await page.setInputFiles('#files-input', photos);
  await page.waitForSelector('#report', { timeout: 240_000 });
  const id = /** @type {RegExpMatchArray} */ (page.url().match(/flights\/(\w+)/))[1];
  const shared = await context.newPage();
  await shared.goto(`${server.url}?token=${read}#/flights/${id}`);
  await shared.waitForSelector('#report');
  await mapIdle(shared);
  assert.ok(!shared.url().includes('token'), 'the address does not keep the token');
  assert.equal(await shared.locator('#token-dialog').count(), 0);
  // What is handed out for other programs opens the map by itself, and never with a token that may change things.
  const read_address = await shared.locator('.address input').first().inputValue();
  assert.ok(read_address.endsWith(`token=${read}`), read_address);
  await page.click('#links-make');
  const made_address = await page.locator('.address input').first().inputValue();
  assert.ok(!made_address.includes(upload) && !made_address.includes(read), made_address);
  const { bounds, max_zoom } = await page.evaluate(async ([at, bearer]) => (await fetch(at, { headers: { Authorization: `Bearer ${bearer}` } })).json(), [`/api/v1/flights/${id}`, upload]);
  const middle = tilePosition((bounds[0] + bounds[2]) / 2, (bounds[1] + bounds[3]) / 2, max_zoom);
  for (const address of [read_address, made_address]) {
    const tile = address.replace('{z}', max_zoom).replace('{x}', String(Math.floor(middle.x))).replace('{y}', String(Math.floor(middle.y)));
    assert.equal((await fetch(tile)).status, 200, address);
  }
  assert.ok((await (await fetch(`${server.url}api/v1/flights/${id}?token=${read}`)).json()).captured.first);
  await assertSharesOneFlight(page, id);
});

test('an upload outlives the server and, chosen again, a reload', options, async () => {
  let server = await used.serve('outlived');
  const { page, context, foreign_requests } = await used.open(server.url);
  page.on('dialog', (dialog) => dialog.accept());
  const stored = async () => {
    const { flights } = await (await fetch(`${server.url}api/v1/flights`)).json();
    return flights[0]?.file_count ?? 0;
  };
  let sent = 0;
  await page.route('**/api/v1/uploads', async (route) => {
    if (route.request().method() === 'POST') {
      sent += 1;
      await setTimeout(sent * 250);  // not the page's own clock: it may be closed by then
    }
    await route.continue().catch(() => {});  // the page that asked is gone after the reload
  });
  await page.setInputFiles('#files-input', photos);
  await until(async () => (await stored()) >= 2);
  const { port } = new URL(server.url);
  const noticed = noticesItIsAway(page);
  await server.stop('SIGKILL');
  await noticed;
  server = await used.serve('outlived', `127.0.0.1:${port}`);
  await until(async () => (await stored()) >= 3);
  await page.reload();
  await page.waitForSelector('#waiting');
  assert.ok((await stored()) < photos.length);
  sent = 0;
  await page.setInputFiles('#files-input', photos);
  await page.waitForSelector('#job-progress, #report', { timeout: 60_000 });
  assert.equal(await stored(), photos.length);
  assert.ok(sent <= photos.length - 2, `${sent} files were sent again`);
  assert.deepEqual(foreign_requests, []);
  const flights = async () => (await (await fetch(`${server.url}api/v1/flights`)).json()).flights.length;
  await page.click('#flight-delete');
  await until(async () => (await flights()) === 0);
  // The tab is closed while the note with "Undo" is there: the flight is in the trash, and comes back from it.
  await page.close();
  const again = await context.newPage();
  await again.goto(server.url);
  await again.click('#trash-fold summary');
  await again.click('#trash button:has-text("Restore")');
  await again.waitForSelector('.flights li');
  assert.equal(await flights(), 1);
});

test('the preview grows while photos arrive and gives way to the map without a flicker', options, async () => {
  const { server, page, foreign_requests, console_errors } = await used.openServer('live');
  const middleOfMap = async () => {
    const box = await page.locator('#map').boundingBox();
    return screenshotPixels(page, { x: box.x + box.width * 0.4, y: box.y + box.height * 0.4, width: box.width * 0.2, height: box.height * 0.2 });
  };
  const drawn = async (/** @type {number} */ least) => {
    await page.waitForFunction((/** @type {number} */ n) => Number(document.getElementById('preview-note')?.textContent?.match(/\d+/)?.[0]) >= n, least, { timeout: 240_000 });
    await mapIdle(page);
    return (await middleOfMap()).colours;
  };
  const release = await holdRequests(page, '**/api/v1/uploads', 1);
  await page.setInputFiles('#files-input', photos);
  assert.ok((await drawn(1)) > 60, 'the first photo is on the map while the others wait');
  const phone = await used.open(server.url, { viewport: { width: 390, height: 560 } });
  const [flight] = (await (await fetch(`${server.url}api/v1/flights`)).json()).flights;
  await phone.page.goto(`${server.url}#/flights/${flight.id}`);
  await phone.page.waitForSelector('#preview-note:not([hidden])');
  await mapIdle(phone.page);
  const room_px = await phone.page.evaluate(([west, , , north]) => {
    const map = /** @type {any} */ (window).skyquilt.map;
    const note = /** @type {HTMLElement} */ (document.getElementById('preview-note')).getBoundingClientRect();
    return map.project([west, north]).y + map.getContainer().getBoundingClientRect().top - note.bottom;
  }, flight.preview.bounds);
  assert.ok(room_px >= 0, `the note covers ${-room_px} px of the preview on a phone`);
  await phone.context.close();
  const zoom_of_one = await page.evaluate(() => /** @type {any} */ (window).skyquilt.map.getZoom());
  release();
  // The middle of what has come may be where no photo has come yet. With all of them, and from there to the map, it
  // is never empty.
  await page.waitForFunction((/** @type {number} */ all) => {
    const drawn = Number(document.getElementById('preview-note')?.textContent?.match(/\d+/)?.[0]);
    return drawn === all || document.getElementById('report') !== null;
  }, photos.length, { timeout: 240_000 });
  await mapIdle(page);
  let fewest = Infinity;
  while (await page.locator('#report').count() === 0) fewest = Math.min(fewest, (await middleOfMap()).colours);
  for (let i = 0; i < 5; i += 1) fewest = Math.min(fewest, (await middleOfMap()).colours);
  assert.ok(fewest > 60, `only ${fewest} colours in the middle of the map at some time`);
  await mapIdle(page);
  assert.ok(await page.locator('#preview-note').isHidden());
  // The report does not wait for the map to be drawn, nor for the view to come to rest on it.
  const zoom = () => page.evaluate(() => /** @type {any} */ (window).skyquilt.map.getZoom());
  const tiles = () => page.evaluate(() => Object.values(/** @type {any} */ (window).skyquilt.map.getStyle().sources).flatMap((s) => s.tiles ?? []));
  await until(async () => (await zoom()) < zoom_of_one - 0.1, `the view does not follow what grows: still at ${zoom_of_one}`);
  await until(async () => {
    const sources = await tiles();
    return sources.length === 1 && sources[0].includes('rev=1');
  }, 'the map does not replace its preview');
  assert.deepEqual(foreign_requests, []);
  assert.deepEqual(console_errors, []);
});

test('an archive of photos is sent as it is and becomes the map of what is in it', options, async () => {
  const archive = join(used.folder, 'card.tar');
  assert.equal(spawnSync('tar', ['-cf', archive, '-C', join(used.folder, 'flight'), 'photos']).status, 0);
  const { server, page, console_errors } = await used.openServer('archived');
  // The preview's document comes so late that it is the map's by then: it is drawn within the map's bounds.
  const flights = async () => (await (await fetch(`${server.url}api/v1/flights`)).json()).flights;
  await page.route('**/*.json?rev=preview', async (route) => {
    await until(async () => (await flights())[0].tilejson !== null);
    await route.continue();
  });
  await page.setInputFiles('#files-input', archive);
  await page.waitForSelector('#report', { timeout: 240_000 });
  await mapIdle(page);
  assert.match(await page.textContent('#report'), /6 \/ 6/);
  assert.deepEqual(console_errors, []);
});

/** Each layer covers the middle of the map in its own colours, and goes again. */
async function assertLayersLieOverTheMap(page, url, id, middle) {
  const legends = await (await fetch(`${url}api/v1/flights/${id}/layers.json`)).json();
  const parts = (/** @type {string} */ hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));
  const share = async (colours, tolerance) => {
    const seen = await screenshotPixels(page, middle);
    return colours.map((hex) => seen.share(.../** @type {[number, number, number]} */ (parts(hex)), tolerance)).reduce((a, b) => a + b, 0);
  };
  await page.click('#tool-layers');
  await page.uncheck('#show-footprints');
  const photo_colours = legends.photo.colours.map(({ colour }) => colour);
  assert.ok((await share(photo_colours, 6)) < 0.3, 'the picture first');
  await page.selectOption('#overlay', 'photo');
  await page.waitForFunction(() => /** @type {any} */ (window).skyquilt.map.getLayer('overlay')?.type === 'raster');
  await mapIdle(page);
  assert.ok((await share(photo_colours, 6)) > 0.9, 'every pixel has the colour of a photo');
  await page.selectOption('#overlay', 'height');
  await page.waitForFunction(() => /** @type {any} */ (window).skyquilt.map.getLayer('overlay')?.type === 'color-relief');
  await mapIdle(page);
  assert.ok((await share(photo_colours, 6)) < 0.3, 'the photos\' colours are gone');
  assert.ok((await screenshotPixels(page, middle)).colours < 200, 'heights, no picture');
  assert.match(await page.textContent('.overlay-choice .map-legend'), /\d\s(m|ft).*\d\s(m|ft)/);
  await page.selectOption('#overlay', 'none');
  await page.waitForFunction(() => !(/** @type {any} */ (window).skyquilt.map.getLayer('overlay')));
  await mapIdle(page);
  assert.ok((await screenshotPixels(page, middle)).colours > 60, 'the picture again');
  await page.check('#show-footprints');
  await page.click('#tool-layers');
}

test('dropped photos become a map on the real server, even when it is killed in between', options, async () => {
  let server = await used.serve('data');
  const { page, foreign_requests, console_errors } = await used.open(server.url);
  await page.waitForSelector('#flights-message:not([hidden])');
  const text_file = join(used.folder, 'text.jpg');
  writeFileSync(text_file, 'not a photo');
  await page.setInputFiles('#files-input', [...photos, text_file]);
  await page.waitForSelector('#job-progress, #report', { timeout: 60_000 });

  const { port } = new URL(server.url);
  const noticed = noticesItIsAway(page);
  await server.stop('SIGKILL');
  await noticed;
  server = await used.serve('data', `127.0.0.1:${port}`);

  await page.waitForSelector('#report', { timeout: 240_000 });
  await mapIdle(page);
  assert.match(await page.textContent('#report'), /6 \/ 6/);
  const box = await page.locator('#map').boundingBox();
  const clip = { x: box.x + box.width * 0.35, y: box.y + box.height * 0.35, width: box.width * 0.3, height: box.height * 0.3 };
  const middle = await screenshotPixels(page, clip);
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
  await assertLayersLieOverTheMap(page, server.url, id, clip);
  await openPhotoCard(page);
  await assertOpensAtItsPixel(page, server.url, id);

  const download = page.waitForEvent('download');
  await page.click('#flight-download');
  await page.click('.download[href*="mbtiles"]');
  assert.match((await download).suggestedFilename(), /\.mbtiles$/);
  await page.keyboard.press('Escape');
  await assertGdalSeesTheSame(page, server.url, id, flight.bounds);

  await page.click('#flight-delete');
  await page.click('.note .icon-button');
  await page.waitForFunction(async () => (await (await fetch('/api/v1/flights')).json()).flights.length === 0);
  assert.deepEqual(foreign_requests, []);
  // While the server is away nothing answers, and for a moment after it there is no preview.
  assert.deepEqual(console_errors.filter((text) => !/ERR_CONNECTION|ERR_EMPTY_RESPONSE|404 .*\.json\?rev=preview$/.test(text)), []);
});
