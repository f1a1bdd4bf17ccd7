// The page in Chromium against the mock server: the whole way a pilot takes, by pointer and by keyboard.
import assert from 'node:assert/strict';
import { mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, afterEach, before, test } from 'node:test';
import { launchBrowser, mapIdle, missingForBrowser, openPage, packageFile } from './support/browser.js';
import { startMockServer } from './support/mock_server.js';
import { photoFiles } from './support/photo_files.js';
import { screenshotPixels } from './support/pixels.js';

const missing = missingForBrowser();
const options = { skip: missing || false, timeout: 120_000 };
let browser;
/** @type {(() => Promise<void>)[]} */
let cleanups = [];

before(async () => {
  if (!missing) browser = await launchBrowser();
});
after(() => browser?.close());
afterEach(async () => {
  for (const clean of cleanups.reverse()) await clean();
  cleanups = [];
});

/** @param {object} [server_options] @param {object} [context_options] */
async function setUp(server_options = {}, context_options = {}) {
  const mock = await startMockServer({ job_ms: 1500, ...server_options });
  cleanups.push(() => mock.close());
  const opened = await openPage(browser, mock.url, context_options);
  cleanups.push(() => opened.context.close());
  return { mock, ...opened };
}

async function assertQuiet(opened, expected_errors = []) {
  assert.deepEqual(opened.foreign_requests, []);
  assert.deepEqual(opened.console_errors.filter((text) => !expected_errors.some((pattern) => pattern.test(text))), []);
}

async function assertAccessible(page, where) {
  if (!(await page.evaluate(() => 'axe' in window))) await page.evaluate(readFileSync(packageFile('axe-core/axe.min.js'), 'utf8'));
  const { violations } = await page.evaluate(() => /** @type {any} */ (window).axe.run(document, { resultTypes: ['violations'], rules: { 'target-size': { enabled: true } } }));
  const found = violations.map((v) => `${v.id}: ${v.nodes.map((n) => n.target.join(' ')).join(', ')} (${v.nodes[0].failureSummary})`);
  assert.deepEqual(found, [], `axe finds faults in the ${where}`);
}

/** Drops files on the page as a file manager would. */
async function dropFiles(page, files) {
  await page.evaluate((list) => {
    const transfer = new DataTransfer();
    for (const { name, base64 } of list) {
      transfer.items.add(new File([Uint8Array.from(atob(base64), (c) => c.charCodeAt(0))], name, { type: 'image/jpeg' }));
    }
    for (const type of ['dragenter', 'dragover', 'drop']) {
      document.body.dispatchEvent(new DragEvent(type, { bubbles: true, cancelable: true, dataTransfer: transfer }));
    }
  }, files.map(({ name, buffer }) => ({ name, base64: buffer.toString('base64') })));
}

test('dropped photos become a map, its photos open by click, and the flight can be deleted and brought back', options, async () => {
  const opened = await setUp({ upload_ms: 60 });
  const { page, mock } = opened;
  await page.waitForSelector('#flights-message:not([hidden])');
  const release = mock.holdUploads();
  await dropFiles(page, photoFiles(18));
  await page.waitForSelector('#upload-progress');
  await page.waitForSelector('#verdict');
  assert.match(await page.textContent('#verdict'), /18 photos · FC300S · 132\.\d\sm across · flown in 51\ss.*Every photo has a position/);
  release();
  await page.waitForSelector('#job-progress');
  assert.match(await page.evaluate(() => location.hash), /^#\/flights\/f\d+/);
  await mapIdle(page);
  assert.equal([...mock.flights.values()][0].files.size, 18);

  // The mosaic's own colours fill the middle of the map; the plain ground lies around it.
  const box = await page.locator('#map').boundingBox();
  const middle = await screenshotPixels(page, { x: box.x + box.width * 0.3, y: box.y + box.height * 0.3, width: box.width * 0.4, height: box.height * 0.4 });
  assert.ok(middle.colours > 60, `only ${middle.colours} colours in the middle of the map`);
  const pond = middle.share(62, 96, 104, 40);
  assert.ok(pond > 0.01 && pond < 0.4, `the pond covers ${pond} of the middle`);
  const corner = await screenshotPixels(page, { x: box.x + 2, y: box.y + 2, width: 20, height: 20 });
  assert.deepEqual(corner.at(10, 10), [0xdf, 0xe4, 0xe0]);

  // The camera under the pointer is the photo that opens.
  const target = await page.evaluate(() => {
    const { map } = /** @type {any} */ (window).skyquilt;
    const feature = map.querySourceFeatures('cameras').find((f) => f.properties.name === 'DJI_0009.JPG');
    const point = map.project(feature.geometry.coordinates);
    return { x: point.x, y: point.y };
  });
  await page.mouse.click(box.x + target.x, box.y + target.y);
  await page.waitForSelector('#photo-card:not([hidden])');
  assert.equal(await page.textContent('#photo-card .card-title'), 'DJI_0009.JPG');
  assert.match(await page.textContent('#photo-card'), /270\.0°, -0\.4°, 0\.7°/);

  // The next one opens at the pixel that shows the place: it lies in the middle, under the mark.
  await page.click('#photo-card .step-next');
  await page.click('#photo-open');
  await page.waitForSelector('.viewer-mark:not([hidden])');
  await assertAccessible(page, 'photo viewer');
  const spot = await page.evaluate(() => {
    const middle = (/** @type {string} */ selector) => {
      const box = /** @type {Element} */ (document.querySelector(selector)).getBoundingClientRect();
      return { x: box.x + box.width / 2, y: box.y + box.height / 2 };
    };
    return { view: middle('.viewer-view'), mark: middle('.viewer-mark') };
  });
  assert.ok(Math.hypot(spot.view.x - spot.mark.x, spot.view.y - spot.mark.y) < 1, JSON.stringify(spot));
  await page.keyboard.press('+');
  await page.keyboard.press('Escape');
  await page.waitForSelector('#photo-viewer', { state: 'detached' });

  // The report in words.
  assert.match(await page.textContent('#report'), /18 \/ 19/);
  assert.match(await page.textContent('#report'), /DJI_0999\.JPGIt has no GPS position/);

  await page.click('#flight-delete');
  await page.waitForSelector('.note-action');
  assert.equal(await page.locator('.flights li').count(), 0);
  await page.click('.note-action');
  await page.waitForSelector('.flights li');
  assert.equal(mock.flights.size, 1);
  await page.hover('.flights li');
  await page.click('.flights li .row-actions button:nth-child(2)');
  await page.waitForFunction(() => document.querySelectorAll('.flights li').length === 0);
  await page.click('.note .icon-button');
  await page.waitForFunction(() => document.querySelectorAll('.note').length === 0 || document.querySelector('.note-error'));
  for (let i = 0; i < 50 && mock.flights.size > 0; i += 1) await page.waitForTimeout(50);
  assert.equal(mock.flights.size, 0);
  await assertQuiet(opened);
});

test('a chosen folder is searched to the bottom; refused and unusable files are named, the rest goes on', options, async () => {
  const opened = await setUp();
  const { page, mock } = opened;
  const folder = mkdtempSync(join(tmpdir(), 'skyquilt-web-'));
  cleanups.push(async () => rmSync(folder, { recursive: true, force: true }));
  mkdirSync(join(folder, 'Meadow', 'DCIM', '100MEDIA'), { recursive: true });
  const [a, b] = photoFiles(2);
  writeFileSync(join(folder, 'Meadow', 'DCIM', '100MEDIA', 'a.jpg'), a.buffer);
  writeFileSync(join(folder, 'Meadow', 'flaky.jpg'), b.buffer);
  writeFileSync(join(folder, 'Meadow', 'refused.jpg'), b.buffer);
  writeFileSync(join(folder, 'Meadow', 'text.jpg'), 'not a photo at all');
  await page.setInputFiles('#folder-input', join(folder, 'Meadow'));
  await page.waitForSelector('#upload-failures .callout');
  assert.match(await page.textContent('#upload-failures'), /refused\.jpgThe photo is cut off/);
  assert.match(await page.textContent('#upload-failures'), /text\.jpg/);
  await page.click('text=Make the map without them');
  await mapIdle(page);
  const flight = [...mock.flights.values()][0];
  assert.equal(flight.name, 'Meadow');
  assert.deepEqual([...flight.files.keys()].sort(), ['a.jpg', 'flaky.jpg']);
  await assertQuiet(opened, [/422/, /503/]);
});

test('a reload in the middle of a job returns to it; cancelling keeps the photos', options, async () => {
  const opened = await setUp({ job_ms: 20_000 });
  const { page } = opened;
  await page.setInputFiles('#files-input', photoFiles(3));
  await page.waitForSelector('#job-progress');
  await page.reload();
  await page.waitForSelector('#job-progress');
  await page.waitForFunction(() => /%/.test(document.querySelector('#job .big-number')?.textContent ?? ''));
  await page.click('#job-cancel');
  await page.waitForSelector('#start-job');
  assert.match(await page.textContent('#waiting'), /Cancelled/);
  await assertQuiet(opened);
});

test('a failed job says why and can be started again', options, async () => {
  const opened = await setUp({ job_ms: 600 });
  const { page, mock } = opened;
  const flight = mock.addFlight('doomed');
  await page.evaluate((id) => (location.hash = `#/flights/${id}`), flight.id);
  await page.waitForSelector('#waiting');
  await page.setInputFiles('#files-input', photoFiles(2));
  await page.waitForSelector('#failure');
  assert.match(await page.textContent('#failure'), /No photo has a GPS position/);
  await assertAccessible(page, 'failure');
  flight.name = 'saved';
  await page.click('#start-job');
  await mapIdle(page);
  await assertQuiet(opened);
});

test('a paused upload waits and goes on', options, async () => {
  const opened = await setUp();
  const { page, mock } = opened;
  const release = mock.holdUploads();
  await page.setInputFiles('#files-input', photoFiles(12));
  await page.waitForSelector('#upload-pause');
  await page.click('#upload-pause');
  await page.waitForFunction(() => document.querySelector('#upload-pause')?.textContent?.includes('Go on'));
  while (mock.heldUploads() > 0) await page.waitForTimeout(50);  // until the page's giving up has arrived
  release();
  await page.waitForTimeout(600);
  assert.equal([...mock.flights.values()][0].files.size, 0);
  await page.click('#upload-pause');
  await mapIdle(page);
  assert.equal([...mock.flights.values()][0].files.size, 12);
  await assertQuiet(opened);
});

test('names are shown as text, never as markup', options, async () => {
  const opened = await setUp();
  const { page, mock } = opened;
  const evil = '<img src=x onerror="document.title=\'owned\'">';
  const flight = mock.seedReady(evil);
  flight.files.set(`${evil}.JPG`, 1);
  await page.reload();
  await page.waitForSelector('.flights li');
  assert.equal(await page.textContent('.flight-name'), evil);
  await page.click('.flight-link');
  await mapIdle(page);
  assert.equal(await page.textContent('#flight-title'), evil);
  assert.ok(!(await page.title()).startsWith('owned'));
  await assertQuiet(opened);
});

test('a long list is searched and sorted', options, async () => {
  const opened = await setUp();
  const { page, mock } = opened;
  for (const [i, name] of ['Field 10', 'Field 2', 'Brook', 'Quarry', 'Roof', 'Dam'].entries()) mock.seedReady(name, 3 + i);
  await page.reload();
  const names = () => page.locator('.flight-name').allTextContents();
  await page.waitForFunction(() => document.querySelectorAll('.flights li').length === 6);
  assert.deepEqual(await names(), ['Dam', 'Roof', 'Quarry', 'Brook', 'Field 2', 'Field 10']);
  await page.selectOption('#flight-order', 'name');
  assert.deepEqual(await names(), ['Brook', 'Dam', 'Field 2', 'Field 10', 'Quarry', 'Roof']);
  await page.fill('#flight-search', 'fie');
  assert.deepEqual(await names(), ['Field 2', 'Field 10']);
  await page.fill('#flight-search', 'nothing');
  assert.match(await page.textContent('#flights-message'), /No flight/);
  await assertAccessible(page, 'searched list');
  await assertQuiet(opened);
});

test('a flight is renamed by keyboard', options, async () => {
  const opened = await setUp();
  const { page, mock } = opened;
  const flight = mock.seedReady('Old name');
  await page.goto(`${mock.url}#/flights/${flight.id}`);
  await mapIdle(page);
  await page.focus('#flight-rename');
  await page.keyboard.press('Enter');
  await page.waitForSelector('#rename-input');
  await assertAccessible(page, 'dialog');
  await page.keyboard.type('New name');
  await page.keyboard.press('Enter');
  await page.waitForFunction(() => document.querySelector('#flight-title')?.textContent === 'New name');
  assert.equal(flight.name, 'New name');
  await assertQuiet(opened);
});

test('measuring by keyboard gives the true distance', options, async () => {
  const opened = await setUp();
  const { page, mock } = opened;
  const flight = mock.seedReady('Meadow');
  await page.goto(`${mock.url}#/flights/${flight.id}`);
  await mapIdle(page);
  const jump = (lon, lat) => page.evaluate((c) => /** @type {any} */ (window).skyquilt.map.jumpTo({ center: c }), [lon, lat]);
  await page.click('#tool-distance');
  await page.locator('#map canvas').focus();
  await jump(7.4391, 46.9512);
  await page.keyboard.press('Enter');
  await jump(7.4401, 46.9512);
  await page.keyboard.press('Enter');
  // GeographicLib says 76.125 m.
  assert.match(await page.textContent('#measure-result'), /^76\.13\s/);
  await page.click('#tool-area');
  assert.equal(await page.getAttribute('#tool-area', 'aria-pressed'), 'true');
  await assertQuiet(opened);
});

test('settings for other programs are saved and the download sizes are told', options, async () => {
  const opened = await setUp();
  const { page, mock } = opened;
  const flight = mock.seedReady('Meadow & "brook"');
  await page.goto(`${mock.url}#/flights/${flight.id}`);
  await page.waitForFunction(() => /4\s*B,/.test(document.querySelector('.download small')?.textContent ?? ''));
  const download = page.waitForEvent('download');
  await page.click('text=Settings for QGIS');
  const file = await download;
  assert.equal(file.suggestedFilename(), 'Meadow_brook_.qgis.xml');
  assert.match(readFileSync(await file.path(), 'utf8'), new RegExp(`name="Meadow &amp; &quot;brook&quot;" url="${mock.url}tiles/${flight.id}/`));
  await assertQuiet(opened);
});

test('a new revision of a map takes the place of the old one', options, async () => {
  const opened = await setUp({ job_ms: 800 });
  const { page, mock } = opened;
  const flight = mock.seedReady('Meadow');
  await page.goto(`${mock.url}#/flights/${flight.id}`);
  await mapIdle(page);
  await page.setInputFiles('#files-input', photoFiles(20));
  await page.click('text=Add to this flight');
  await page.waitForSelector('#job');
  await page.waitForSelector('#job', { state: 'detached' });
  await mapIdle(page);
  await page.waitForFunction(() => Object.keys(/** @type {any} */ (window).skyquilt.map.getStyle().sources).filter((id) => id.startsWith('mosaic')).join() === 'mosaic-2');
  assert.match(await page.textContent('#report'), /20 \/ 21/);
  await assertQuiet(opened);
});

test('two flights are compared by swipe and by fade', options, async () => {
  const opened = await setUp();
  const { page, mock } = opened;
  const left = mock.seedReady('Before');
  const right = mock.seedReady('After');
  right.place.season = 40;
  await page.goto(`${mock.url}#/flights/${left.id}`);
  await mapIdle(page);
  await page.click('#tool-compare');
  await page.click('.choice');
  await mapIdle(page, '#map-above');
  const box = await page.locator('#map').boundingBox();
  const clip = { x: Math.round(box.x + box.width * 0.3), y: Math.round(box.y + box.height * 0.3), width: 60, height: 60 };
  const picture = async () => (await screenshotPixels(page, clip)).at(30, 30).join();
  await page.focus('#compare-slider');
  await page.keyboard.press('End');
  const all_left = await picture();
  await page.keyboard.press('Home');
  const all_right = await picture();
  assert.notEqual(all_left, all_right);
  await page.check('#compare-fade');
  await page.focus('#compare-slider');
  await page.keyboard.press('End');
  assert.equal(await picture(), all_right);
  await assertAccessible(page, 'comparison');
  await page.click('#compare-bar .icon-button');
  await page.waitForSelector('#map-above', { state: 'detached' });
  await assertQuiet(opened);
});

for (const colorScheme of /** @type {const} */ (['light', 'dark'])) {
  for (const [screen, context] of Object.entries({ laptop: {}, phone: { viewport: { width: 390, height: 844 }, isMobile: true, hasTouch: true } })) {
    test(`axe finds no fault in any view on a ${screen} in the ${colorScheme} scheme`, options, async () => {
      const opened = await setUp({ upload_ms: 400, job_ms: 20_000 }, { ...context, colorScheme, reducedMotion: 'reduce' });
      const { page, mock } = opened;
      const flight = mock.seedReady('Meadow');
      await page.reload();
      await page.waitForSelector('.flights li');
      await page.click('summary');
      await assertAccessible(page, 'home');
      await page.goto(`${mock.url}#/flights/${flight.id}`);
      await mapIdle(page);
      await page.waitForSelector('#report');
      await assertAccessible(page, 'map');
      await page.locator('#map canvas').focus();
      await page.keyboard.press('Enter');
      await page.waitForSelector('#photo-card:not([hidden])');
      await page.click('#tool-layers');
      await page.selectOption('#colour-by', 'error');
      await assertAccessible(page, 'map with cards');
      await page.goto(`${mock.url}#/`);
      await page.setInputFiles('#files-input', [...photoFiles(9), { ...photoFiles(1)[0], name: 'refused.JPG' }]);
      await page.waitForSelector('#upload-progress');
      await assertAccessible(page, 'upload');
      await page.waitForSelector('#upload-failures .callout');
      await assertAccessible(page, 'failed upload');
      await page.click('text=Make the map without them');
      await page.waitForSelector('#job-progress');
      await assertAccessible(page, 'processing');
      await assertQuiet(opened, [/422/]);
    });
  }
}

test('the first view is light, and the map library comes only with the first map', options, async () => {
  const opened = await setUp();
  const { page, mock } = opened;
  await page.waitForLoadState('networkidle');
  assert.ok(opened.transferred() < 400_000, `${opened.transferred()} bytes for the first view`);
  const flight = mock.seedReady('Meadow');
  await page.goto(`${mock.url}#/flights/${flight.id}`);
  await mapIdle(page);
  await assertQuiet(opened);
});

test('outlines of the land lie below the map until nothing is chosen, and that is remembered', options, async () => {
  const opened = await setUp();
  const { page, mock } = opened;
  const flight = mock.seedReady('Meadow');
  const layers = () => page.evaluate(() => /** @type {any} */ (window).skyquilt.map.getStyle().layers.map((/** @type {any} */ { id }) => id));
  await page.goto(`${mock.url}#/flights/${flight.id}`);
  await mapIdle(page);
  const before = await layers();
  assert.deepEqual(before.slice(0, 3), ['ground', 'basemap-land', 'basemap-coast'], 'below the mosaic');
  await page.click('#tool-layers');
  assert.deepEqual(await page.locator('#basemap option').allTextContents(), ['Nothing', 'Outlines of the land']);
  await page.selectOption('#basemap', 'none');
  await page.waitForFunction(() => !(/** @type {any} */ (window).skyquilt.map.getLayer('basemap-land')));
  await page.reload();
  await mapIdle(page);
  assert.ok(!(await layers()).some((/** @type {string} */ id) => id.startsWith('basemap-')));
  await assertQuiet(opened);
});

test('the server away and back again: the list says so and recovers', options, async () => {
  const opened = await setUp();
  const { page, mock } = opened;
  mock.seedReady('Meadow');
  await page.route('**/api/v1/flights?*', (route) => route.abort());
  await page.reload();
  await page.waitForFunction(() => /could not be loaded/.test(document.querySelector('#flights-message')?.textContent ?? ''));
  await page.unroute('**/api/v1/flights?*');
  await page.waitForSelector('.flights li', { timeout: 15_000 });
  await assertQuiet(opened, [/ERR_FAILED/]);
});
