// From photos to the map on the page, in Chromium against the mock server: uploads, jobs, revisions.
import assert from 'node:assert/strict';
import { mkdirSync, mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { mapIdle, screenshotPixels, until } from './support/browser.js';
import { allAsked, assertAccessible, options, usePages } from './support/pages.js';
import { photoFiles } from './support/photo_files.js';

const { setUp, setUpReady, cleanUp } = usePages();

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
  const { page, mock } = await setUp({ upload_ms: 60 }, { is_drawn: true });
  await page.waitForSelector('#flights-message:not([hidden])');
  const release = mock.holdUploads();
  await dropFiles(page, photoFiles(18));
  await page.waitForSelector('#upload-progress');
  await page.waitForSelector('#verdict');
  assert.match(await page.textContent('#verdict'), /18 photos · FC300S · 43\d\.\d\sft across · flown in 51\ss.*Every photo has a position/);
  release();
  await page.waitForSelector('#job-progress');
  assert.match(await page.evaluate(() => location.hash), /^#\/flights\/f\d+/);
  await mapIdle(page);
  const [sent] = mock.flights.values();
  assert.equal(sent.files.size, 18);
  assert.match(sent.name, /^Bern, \S/, 'named by place and date, and nobody was asked for the place');

  // The mosaic's own colours fill the middle of the map; the plain ground lies around it.
  const box = await page.locator('#map').boundingBox();
  const middle = await screenshotPixels(page, { x: box.x + box.width * 0.3, y: box.y + box.height * 0.3, width: box.width * 0.4, height: box.height * 0.4 });
  assert.ok(middle.colours > 60, `only ${middle.colours} colours in the middle of the map`);
  const pond = middle.share(62, 96, 104, 40);
  assert.ok(pond > 0.01 && pond < 0.4, `the pond covers ${pond} of the middle`);
  assert.deepEqual((await screenshotPixels(page, { x: box.x + 2, y: box.y + 2, width: 20, height: 20 })).at(10, 10), [0xdf, 0xe4, 0xe0]);

  // The ground first: nothing lies over it until it is asked for.
  assert.equal(await page.evaluate(() => /** @type {any} */ (window).skyquilt.map.getLayoutProperty('cameras', 'visibility')), 'none');
  await page.click('#tool-layers');
  await page.check('#show-footprints');
  await page.click('#tool-layers');
  await mapIdle(page);

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
  await page.waitForSelector('.flights li', { state: 'detached' });
  await page.click('.note-action');
  await page.waitForSelector('.flights li');
  assert.equal(mock.flights.size, 1);
  await page.hover('.flights li');
  await page.click('.flights li .row-actions button:nth-child(2)');
  await page.waitForFunction(() => document.querySelectorAll('.flights li').length === 0);
  await page.click('.note .icon-button');
  assert.equal(mock.flights.size, 0);
});

test('a chosen folder is searched to the bottom; refused and unusable files are named, the rest goes on', options, async () => {
  const { page, mock } = await setUp({}, { errors: /422|503/ });
  const folder = mkdtempSync(join(tmpdir(), 'skyquilt-web-'));
  cleanUp(async () => rmSync(folder, { recursive: true, force: true }));
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
  await page.click('text=Continue without them');
  await mapIdle(page);
  const flight = [...mock.flights.values()][0];
  assert.equal(flight.name, 'Meadow');
  assert.deepEqual([...flight.files.keys()].sort(), ['a.jpg', 'flaky.jpg']);
});

test('a reload in the middle of a job returns to it; cancelling keeps the photos', options, async () => {
  const { page } = await setUp({ job_ms: 20_000 });
  await page.setInputFiles('#files-input', photoFiles(3));
  await page.waitForSelector('#job-progress');
  await page.reload();
  await page.waitForSelector('#job-progress');
  await page.waitForFunction(() => /%/.test(document.querySelector('#job .big-number')?.textContent ?? ''));
  await page.click('#job-cancel');
  await page.waitForSelector('#start-job');
  assert.match(await page.textContent('#waiting'), /Cancelled/);
});

test('who runs the server sees which worker has which part of a large flight, and which stand aside', options, async () => {
  const { page, mock } = await setUp({ job_ms: 20_000 });
  const flight = mock.addFlight('large');
  await page.evaluate((id) => (location.hash = `#/flights/${id}`), flight.id);
  await page.waitForSelector('#waiting');
  await page.setInputFiles('#files-input', photoFiles(2));
  await page.waitForSelector('#job-parts:not([hidden])');
  assert.match(await page.textContent('#job-parts summary'), /2 parts at work/);
  await page.click('#job-parts summary');
  assert.match(await page.textContent('#job-parts li:nth-child(2)'), /Looking at photos 12 · worker-b-9 · since .*2026.* · attempt 2/);
  assert.match(await page.textContent('#job-aside'), /worker-c-4 takes no work until .*2026.*The disk is full/);
  const told = await page.textContent('#job .big-number');
  await page.waitForFunction((before) => document.querySelector('#job .big-number')?.textContent !== before, told);
  assert.equal(await page.locator('#job-parts[open]').count(), 1, 'it stays open while the job goes on');
  await page.click('#job-cancel');
  await page.waitForSelector('#start-job');
});

test('a failed job says why and can be started again', options, async () => {
  const { page, mock } = await setUp({ job_ms: 600 });
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
});

test('a paused upload waits and goes on', options, async () => {
  const { page, mock } = await setUp();
  await page.clock.install();
  const release = mock.holdUploads();
  await page.setInputFiles('#files-input', photoFiles(12));
  await page.waitForSelector('#upload-pause');
  await page.click('#upload-pause');
  await page.waitForFunction(() => document.querySelector('#upload-pause')?.textContent?.includes('Resume'));
  await until(() => mock.heldUploads() === 0, 'the page does not give up what it sends');
  release();
  await page.clock.runFor(60_000);
  await allAsked(page);
  assert.equal([...mock.flights.values()][0].files.size, 0);
  await page.click('#upload-pause');
  await mapIdle(page);
  assert.equal([...mock.flights.values()][0].files.size, 12);
});

test('a new revision of a map takes the place of the old one', options, async () => {
  const { page, flight } = await setUpReady('Meadow', { job_ms: 800 });
  await page.setInputFiles('#files-input', photoFiles(20));
  await page.click('text=Add to this flight');
  await page.waitForSelector('#job');
  await page.waitForSelector('#job', { state: 'detached' });
  await mapIdle(page);
  await page.waitForFunction(() => Object.keys(/** @type {any} */ (window).skyquilt.map.getStyle().sources).filter((id) => id.startsWith('mosaic')).join() === 'mosaic-2');
  assert.match(await page.textContent('#report'), /20 \/ 21/);
});

test('photos that come while a map is being made wait for its end, and are in the next one, as it is asked for until then', options, async () => {
  const { page, flight } = await setUpReady('Meadow', { job_ms: 600_000 }, { locale: 'en-GB', errors: /status of 409/ });
  await page.click('#processing-details summary');
  await page.click('#run-again');
  await page.click('#options-submit');
  await page.waitForSelector('#job-progress');
  const first = flight.job;
  flight.refuses_jobs = { status: 409, detail: 'A map of this flight is being made already.' };
  await page.setInputFiles('#files-input', photoFiles(4));
  await page.click('text=Add to this flight');
  await page.waitForFunction(() => /When it has ended, the next one is begun/.test(document.querySelector('#upload-trouble')?.textContent ?? ''));
  assert.doesNotMatch((await page.textContent('#upload-trouble')) ?? '', /server responds/);
  assert.equal(flight.job, first);
  await page.click('#upload #options-open');
  await page.click('#options-dialog .option-more summary');
  await page.fill('#option-quality', '95');
  await page.click('#options-submit');
  await page.waitForSelector('#options-dialog', { state: 'detached' });
  flight.refuses_jobs = null;
  await until(() => flight.job !== first, 'a map is made with them');
  assert.equal(flight.job.options.quality, 95);
});

test('files that are chosen again are judged, and told of, once', options, async () => {
  const { page, mock } = await setUp();
  mock.holdUploads();
  const flight = mock.addFlight('Meadow');
  const found = await page.evaluate(async (/** @type {string} */ id) => {
    const { UploadSession } = await import(new URL('src/upload/uploads.js', location.href).href);
    const session = new UploadSession(id);
    const verdicts = new Set();
    session.addEventListener('change', () => session.verdict && verdicts.add(session.verdict));
    for (let i = 0; i < 2; i += 1) await session.add({ chosen: [{ name: 'log.txt', file: new File(['x'], 'log.txt') }], ignored: [{ name: 'letter.docx', reason: '' }], folder: '' });
    while (verdicts.size < 2) await new Promise(requestAnimationFrame);
    return [session.verdict.logs, session.ignored.length, session.queue.items.length];
  }, flight.id);
  assert.deepEqual(found, [1, 1, 1]);
});

test('of two verdicts of the server the one on more files stays, whichever comes first', options, async () => {
  const { page } = await setUp();
  const shown = await page.evaluate(async () => {
    const { UploadSession } = await import(new URL('src/upload/uploads.js', location.href).href);
    const answers = [];
    const { fetch } = window;
    window.fetch = (address, init) => (String(address).endsWith('/verdict') ? new Promise((resolve) => answers.push(resolve)) : fetch(address, init));
    const session = new UploadSession('f00000001');
    for (const done of [3, 12]) {
      session.queue.items = Array.from({ length: 20 }, (_, i) => ({ name: `${i}.jpg`, state: i < done ? 'done' : 'waiting', was_there: false, bytes: 1, sent_bytes: 0 }));
      session.queue.dispatchEvent(new Event('change'));
      while (answers.length === 0) await new Promise(requestAnimationFrame);
    }
    while (answers.length < 2) await new Promise(requestAnimationFrame);
    answers[1](Response.json({ photos_readable: 12 }));
    while (!session.server_verdict) await new Promise(requestAnimationFrame);
    answers[0](Response.json({ photos_readable: 3 }));
    for (let i = 0; i < 10; i += 1) await new Promise(requestAnimationFrame);
    return session.server_verdict.photos_readable;
  });
  assert.equal(shown, 12);
});
