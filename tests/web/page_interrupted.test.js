// Uploads that do not run through, in Chromium against the mock server: stopped, deleted and taken back, paused, and a
// server that is away.
import assert from 'node:assert/strict';
import { mkdirSync, mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { mapIdle, until } from './support/browser.js';
import { allAsked, assertAccessible, options, stopClock, usePages } from './support/pages.js';
import { photoFiles } from './support/photo_files.js';

const { setUp, setUpReady, cleanUp } = usePages();
const only = (/** @type {any} */ mock) => [...mock.flights.values()][0];

/** Sends photos of which the server takes so many and holds the rest. */
async function uploadPart(page, mock, taken, all) {
  await page.route('**/api/v1/uploads', async (route) => {
    if (only(mock)?.files.size >= taken) return undefined;  // neither answered nor refused
    return route.continue();
  });
  await page.setInputFiles('#files-input', photoFiles(all));
  await page.waitForFunction((n) => Number(document.querySelector('#upload-counts')?.textContent?.split(' ')[0]) >= n, taken);
}

test('a new flight during an upload is a flight of its own, and photos of another card are asked about', options, async () => {
  const { page, mock } = await setUp();
  const release = mock.holdUploads();
  await page.setInputFiles('#files-input', photoFiles(6));
  await page.waitForSelector('#upload-progress');
  const [first] = mock.flights.values();
  // Cards number their photos alike.
  const folder = mkdtempSync(join(tmpdir(), 'skyquilt-web-'));
  cleanUp(async () => rmSync(folder, { recursive: true, force: true }));
  mkdirSync(join(folder, 'Dunes'));
  const dunes = photoFiles(4, 30_000);
  for (const { name, buffer } of dunes) writeFileSync(join(folder, 'Dunes', name), buffer);
  const [chooser] = await Promise.all([page.waitForEvent('filechooser'), page.click('#new-flight')]);
  await chooser.setFiles(join(folder, 'Dunes'));
  await page.waitForFunction((id) => /flights\/\w/.test(location.hash) && !location.hash.includes(id), first.id);
  assert.equal(await page.locator('dialog').count(), 0, 'who says so is not asked');
  await page.waitForSelector('#upload-counts:has-text("of 4 files")');
  assert.equal(mock.flights.size, 2);
  // Without a word, photos of the names that are being sent are not taken for those.
  await page.setInputFiles('#files-input', photoFiles(3, 40_000));
  await page.waitForSelector('dialog #where-title');
  assert.doesNotMatch((await page.textContent('dialog')) ?? '', /rebuild/, 'there is no map yet');
  await page.click('dialog >> text=Cancel');
  await page.waitForSelector('dialog', { state: 'detached' });
  // The same again is the same upload.
  const second = [...mock.flights.values()].find((flight) => flight !== first);
  const [, is_asked] = await Promise.all([
    page.setInputFiles('#files-input', dunes),
    Promise.race([page.waitForRequest(`**/flights/${second.id}/files`).then(() => false), page.waitForSelector('dialog').then(() => true)]),
  ]);
  assert.ok(!is_asked);
  release();
  await mapIdle(page);
  await until(() => first.files.size === 6 && Boolean(first.job));
  assert.deepEqual([first.files.size, second.files.size, second.name], [6, 4, 'Dunes']);
  assert.ok(second.job, 'each has its own job');
});

test('a stopped upload says what the server lacks, there and after a reload, and goes on', options, async () => {
  const { page, mock } = await setUp({ upload_ms: 40 });
  await uploadPart(page, mock, 8, 18);
  await page.click('text=Stop');
  await page.waitForSelector('#start-job');
  const there = () => only(mock).files.size;
  const says = async () => (await page.textContent('#waiting')) ?? '';
  await until(async () => (await says()).includes(`${there()} of 18 files are on the server`));
  assert.doesNotMatch(await says(), /All/);
  assert.match(await says(), new RegExp(`${18 - there()} are missing`));
  assert.match((await page.textContent('#start-job')) ?? '', /without them/);
  await assertAccessible(page, 'stopped upload');
  page.on('dialog', (dialog) => dialog.accept());
  await page.reload();
  await page.waitForSelector('#start-job');
  assert.match(await says(), new RegExp(`${there()} of 18 files are on the server`));
  await page.unroute('**/api/v1/uploads');
  await page.setInputFiles('#files-input', photoFiles(18));
  await mapIdle(page);
  assert.equal(there(), 18);
});

test('a stopped upload is resumed without choosing the files again', options, async () => {
  const { page, mock } = await setUp({ upload_ms: 40 });
  await uploadPart(page, mock, 4, 12);
  await page.click('text=Stop');
  await page.waitForSelector('#upload-resume');
  await page.unroute('**/api/v1/uploads');
  await page.click('#upload-resume');
  await mapIdle(page);
  assert.equal(only(mock).files.size, 12);
});

test('a stopped upload to a flight that has a map can be resumed, too', options, async () => {
  const { page, mock, flight } = await setUpReady('Meadow', { job_ms: 300 }, { locale: 'en-GB' });
  const release = mock.holdUploads();
  await page.setInputFiles('#files-input', photoFiles(20));
  await page.click('text=Add to this flight');
  await page.click('#upload button:has-text("Stop")');
  await page.waitForSelector('#upload-resume');
  assert.match((await page.textContent('#waiting')) ?? '', /of 20 files (is|are) on the server/);
  release();
  await page.click('#upload-resume');
  await until(() => flight.job?.state === 'successful', 'a map is made with them');
  await page.waitForSelector('#waiting', { state: 'detached' });
});

test('an upload whose flight is deleted goes on when that is taken back', options, async () => {
  const { page, mock } = await setUp({ upload_ms: 40 });
  await uploadPart(page, mock, 4, 12);
  await page.click('#flight-delete');
  await page.waitForSelector('.note-action');
  assert.equal(mock.flights.size, 0);
  await page.unroute('**/api/v1/uploads');
  await page.click('.note-action');
  await page.waitForSelector('.flights li');
  await page.click('.flight-link');
  await mapIdle(page);
  assert.equal(only(mock).files.size, 12);
});

test('an upload whose flight is deleted for good keeps none of its files', options, async () => {
  const { page, mock } = await setUp({ upload_ms: 40, trash_days: 0 });
  await uploadPart(page, mock, 4, 12);
  const holds = () => page.evaluate(async () => (await import(new URL('src/upload/drop_zone.js', location.href).href)).holdsUploads());
  assert.equal(await holds(), true);
  await page.click('#flight-delete');
  await page.click('#remove-confirm');
  await page.waitForFunction(() => document.body.dataset.view === 'home');
  assert.equal(await holds(), false, 'a new language comes at once again');
});

test('what another browser was to send is not claimed to be all', options, async () => {
  const { page, mock } = await setUp();
  const flight = mock.addFlight('Meadow');
  for (const { name, buffer } of photoFiles(3)) flight.files.set(name, buffer.length);
  await page.goto(`${mock.url}#/flights/${flight.id}`);
  await page.waitForSelector('#start-job');
  assert.match((await page.textContent('#waiting')) ?? '', /3 files are on the server/);
  assert.doesNotMatch((await page.textContent('#waiting')) ?? '', /All/);
});

test('a server that is away for long fails no file; that it is away is said at once, and when it is tried again', options, async () => {
  const { page, mock } = await setUp({ upload_ms: 10 }, { errors: /ERR_CONNECTION_REFUSED|ERR_ABORTED/ });
  // Time runs fast here: the page waits as it would for minutes.
  await page.clock.install();
  let is_away = false;
  let tries = 0;
  await page.route('**/api/v1/**', (route) => {
    if (is_away && route.request().url().includes('/uploads')) tries += 1;
    return is_away ? route.abort('connectionrefused') : route.continue();
  });
  const release = mock.holdUploads();
  await page.setInputFiles('#files-input', photoFiles(10));
  await page.waitForSelector('#upload-progress');
  await stopClock(page);
  is_away = true;
  await page.click('#upload-pause');
  await page.click('#upload-pause');
  await until(() => tries >= 4);
  await page.clock.runFor(1000);
  await page.waitForSelector('#upload-trouble');
  await page.clock.resume();
  assert.match((await page.textContent('#upload-trouble')) ?? '', /cannot be reached.*Retrying/);
  await assertAccessible(page, 'upload without a server');
  for (let i = 0; i < 30; i += 1) await page.clock.runFor(10_000);
  assert.equal(await page.locator('#upload-failures .callout').count(), 0, 'five minutes later no file has failed');
  assert.match((await page.textContent('#upload-trouble')) ?? '', /Retrying/);
  // Whoever sees the server come back need not wait for the next try: no time passes.
  await stopClock(page);
  await allAsked(page);
  const before = tries;
  await page.evaluate(() => /** @type {HTMLElement|null} */ (document.querySelector('#upload-retry-now'))?.click());
  await until(() => tries >= before + 4, 'asked for, files are not tried at once');
  is_away = false;
  release();
  await until(async () => {
    await page.clock.runFor(1000);
    return only(mock).files.size === 10;
  });
});

test('nothing is sent, nor offered to be gone on with, before it is known what the server has', options, async () => {
  const { page, mock } = await setUp({}, { errors: /status of 500/ });
  let is_ill = true;
  await page.route('**/files', (route) => (is_ill ? route.fulfill({ status: 500, body: '' }) : route.continue()));
  await page.setInputFiles('#files-input', photoFiles(3));
  await page.waitForSelector('#upload-trouble');
  assert.ok(await page.isHidden('#upload-pause'));
  assert.doesNotMatch((await page.textContent('#upload')) ?? '', /Paused/);
  assert.equal(only(mock).files.size, 0);
  is_ill = false;
  await until(() => only(mock).files.size === 3, 'it goes on by itself');
});

test('a token that ends during an upload is asked for, and the upload goes on with the next one', options, async () => {
  const { page, mock } = await setUp({}, { errors: /status of 401/ });
  let has_ended = false;
  await page.route('**/api/v1/**', (route) => {
    const is_good = !has_ended || route.request().headers().authorization === 'Bearer sq_next' || new URL(route.request().url()).searchParams.get('token') === 'sq_next';
    return is_good ? route.fallback() : route.fulfill({ status: 401, contentType: 'application/problem+json', json: { title: 'Unauthorized', status: 401, code: 'unauthorized' } });
  });
  const release = mock.holdUploads();
  await page.setInputFiles('#files-input', photoFiles(8));
  await page.waitForSelector('#upload-progress');
  await page.evaluate(() => document.body.setAttribute('data-stays', ''));
  await until(() => mock.heldUploads() === 4);
  has_ended = true;
  release();
  await page.fill('#token-input', 'sq_next');
  await page.press('#token-input', 'Enter');
  await mapIdle(page);
  assert.equal(only(mock).files.size, 8);
  assert.equal(await page.locator('body[data-stays]').count(), 1, 'the page is not loaded anew, which would lose the files');
});

test('an upload goes on where what sends files could not be had at first', options, async () => {
  const { page, mock } = await setUp({}, { errors: /ERR_FAILED/ });
  let times = 0;
  await page.route(/\/vendor\/tus\.mjs/, (/** @type {any} */ route) => ((times += 1) === 1 ? route.abort() : route.continue()));
  await page.setInputFiles('#files-input', photoFiles(6));
  await mapIdle(page);
  assert.equal(only(mock).files.size, 6);
});

test('pausing does not move the bar back', options, async () => {
  const { page, mock } = await setUp();
  const release = mock.holdUploads();
  await page.setInputFiles('#files-input', photoFiles(4, 3_000_000));
  const bar = () => page.evaluate(() => /** @type {HTMLProgressElement} */ (document.querySelector('#upload-progress')).value);
  await page.waitForFunction(() => /** @type {HTMLProgressElement} */ (document.querySelector('#upload-progress'))?.value > 0.2);
  const before = await bar();
  await page.click('#upload-pause');
  assert.ok((await bar()) >= before, `${await bar()} after ${before}`);
  await until(() => mock.heldUploads() === 0);
  await page.evaluate(() => {
    const shown = /** @type {HTMLProgressElement} */ (document.querySelector('#upload-progress'));
    new MutationObserver(() => {
      /** @type {any} */ (window).lowest = Math.min(shown.value, /** @type {any} */ (window).lowest ?? 1);
    }).observe(shown, { attributes: true });
  });
  await page.click('#upload-pause');
  release();
  await mapIdle(page);
  const lowest = await page.evaluate(() => /** @type {any} */ (window).lowest);
  assert.ok(lowest >= before, `${lowest} after ${before}`);
});

test('a flight whose parts of the page do not come can be opened again', options, async () => {
  const { page, mock } = await setUp({}, { errors: /ERR_FAILED/ });
  const flight = mock.seedReady('Meadow');
  await page.route('**/src/open_parts.js', (/** @type {any} */ route) => route.abort());
  await page.evaluate((/** @type {string} */ id) => { location.hash = `#/flights/${id}`; }, flight.id);
  await page.waitForSelector('#open-retry');
  await page.unroute('**/src/open_parts.js');
  await page.click('#open-retry');
  await mapIdle(page);
});
