// What the page says of a flight, in Chromium against the mock server: what will happen, what became of it, when it was
// taken, and what may be done with it.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { holdAnswer, mapIdle, openMap, savedBy, twoFrames, until } from './support/browser.js';
import { allAsked, assertAccessible, options, stopClock, usePages } from './support/pages.js';
import { photoFiles } from './support/photo_files.js';

const { setUp, setUpFlight, setUpReady } = usePages();

test('the server is asked what it makes of the first photos, and its doubts are amber', options, async () => {
  const { page, mock } = await setUp({ upload_ms: 60 });
  const flight = mock.addFlight('Meadow');
  flight.verdict = { ...flight.verdict, left_out: [{ name: 'DJI_0002.JPG', reason: 'The photo is cut off.' }], warnings: ['No photo says how high it was above the ground: 91 m is assumed.'] };
  await page.goto(`${mock.url}#/flights/${flight.id}`);
  await page.waitForSelector('#waiting');
  await page.route('**/api/v1/uploads', (route) => (flight.files.size >= 6 ? undefined : route.continue()));
  await page.setInputFiles('#files-input', photoFiles(18));
  await page.waitForSelector('#server-verdict.verdict-amber');
  const text = (await page.textContent('#server-verdict')) ?? '';
  assert.match(text, /from the first \d+ photos/);
  assert.match(text, /91 m is assumed/);
  assert.match(text, /1 photo will be left out.*DJI_0002\.JPG: The photo is cut off/);
  assert.equal(await page.locator('#upload .good').count(), 0, 'nothing on the page calls it good');
  await assertAccessible(page, 'verdict of the server');
  await page.click('text=Stop');
  await page.waitForSelector('#waiting ~ * #server-verdict.verdict-amber');
  assert.match((await page.textContent('#server-verdict')) ?? '', /6\.007.acres · about 21.s to process/);
});

test('a map with photos left out or placed by record alone is amber and says so; a whole one is green', options, async () => {
  for (const is_whole of [false, true]) {
    const { page, mock, flight } = await setUpFlight('Meadow', { is_whole });
    await page.reload();
    await page.waitForSelector('.flights .chip');
    assert.equal(await page.textContent('.flights .chip'), is_whole ? 'Ready to use' : 'Usable, with limits');
    assert.equal(await page.locator('.flights .chip-amber').count(), is_whole ? 0 : 1);
    await page.goto(`${mock.url}#/flights/${flight.id}`);
    await page.waitForSelector('#result-verdict');
    assert.equal(await page.getAttribute('#result-verdict', 'class'), `result-verdict result-${is_whole ? 'good' : 'amber'}`);
    const text = (await page.textContent('#result-verdict')) ?? '';
    if (is_whole) assert.match(text, /Ready to use.*All 18 photos are aligned/);
    else assert.match(text, /1 of 19 photos was left out.*2 photos were placed by their recorded position only/);
    // What was noted of single photos, and how it was made, are for who looks for it.
    assert.doesNotMatch(await page.innerText('#report .callout'), /152\sft/);
    assert.equal(await page.innerText('#photo-notes'), '1 note on a single photo');
    assert.equal(await page.innerText('#processing-details'), 'Processing details');
    await page.click('#photo-notes summary');
    assert.match(await page.innerText('#photo-notes'), /DJI_0001\.JPG: the recorded position is 152\sft/);  // the browser speaks American English
    await page.evaluate(async () => (await import(new URL('src/shared/units.js', location.href).href)).keepUnits('metric'));
    assert.match(await page.innerText('#photo-notes'), /DJI_0001\.JPG: the recorded position is 46\sm/);
    await mapIdle(page);
    await assertAccessible(page, 'result');
  }
});

test('of a map that was made before anything judged it, nothing is claimed', options, async () => {
  const { page, mock, flight } = await setUpFlight('Meadow');
  await page.route('**/report', async (route) => {
    const { quality, ...report } = await (await route.fetch()).json();
    await route.fulfill({ json: report });
  });
  await page.goto(`${mock.url}#/flights/${flight.id}`);
  await page.waitForSelector('#report .facts');
  assert.match(await page.innerText('#result-verdict'), /^Accuracy not known\. This map was made before accuracy was judged\./);
  assert.doesNotMatch((await page.textContent('#report'))?.replace((await page.textContent('#result-verdict')) ?? '', '') ?? '', /aligned\.|accuracy/);
});

test('of two answers about a flight the one that was asked for later counts', options, async () => {
  const { page, mock } = await setUp();
  const flight = mock.addFlight('Before');
  /** @type {(() => void)[]} */
  const tell = [];
  const events = [0, 1].map(() => new Promise((resolve) => tell.push(() => resolve(undefined))));
  await page.route('**/api/v1/events?*', async (route) => {
    const event = events.shift();
    if (!event) {
      await route.fallback();
      return;
    }
    await event;
    await route.fulfill({ contentType: 'text/event-stream', body: 'retry: 50\nevent: map\ndata: {}\n\n' });
  });
  await page.goto(`${mock.url}#/flights/${flight.id}`);
  await page.waitForSelector('#waiting');
  const { isHeld, release } = await holdAnswer(page, `**/api/v1/flights/${flight.id}`);
  tell[0]();
  await until(isHeld);
  flight.name = 'After';
  tell[1]();
  await page.waitForSelector('#flight-title:has-text("After")');
  release();
  await allAsked(page);
  await twoFrames(page);
  assert.equal(await page.textContent('#flight-title'), 'After');
});

test('events that a proxy refuses are asked for again a few times, and none of a flight that is gone', options, async () => {
  const { page, mock } = await setUp({}, { errors: /status of (404|502)|EventSource/ });
  await page.clock.install();
  let asked = 0;
  /** @type {() => void} */
  let refuse = () => {};
  /** The first answer comes when the page's time stands still. @param {any} flight */
  const open = async (flight) => {
    asked = 0;
    const gate = new Promise((resolve) => { refuse = () => resolve(undefined); });
    await page.route('**/api/v1/events?*', async (route) => {
      asked += 1;
      await gate;
      await route.fulfill({ status: 502, contentType: 'text/event-stream', body: '' });
    });
    await page.goto(`${mock.url}#/flights/${flight.id}`);
    await page.waitForSelector(`#flight-title:has-text("${flight.name}")`);
    await until(() => asked === 1);
    await stopClock(page);
  };
  const [kept, gone] = [mock.addFlight('Meadow'), mock.addFlight('Brook')];
  await open(kept);
  refuse();
  for (const [before, pause_ms] of [2000, 10_000, 30_000, 120_000].entries()) {
    await until(async () => {
      await page.clock.runFor(pause_ms / 4);
      return asked > before + 1;
    });
    assert.equal(asked, before + 2);
  }
  await page.clock.runFor(130_000);
  await allAsked(page);
  assert.equal(asked, 5, 'a few times');
  await page.clock.resume();
  await page.unroute('**/api/v1/events?*');
  await open(gone);
  let is_refused = false;
  page.on('response', (answer) => (is_refused ||= answer.url().endsWith(gone.id) && answer.status() === 404));
  mock.flights.delete(gone.id);
  refuse();
  await until(async () => {
    await page.clock.runFor(1000);
    return is_refused;
  });
  await page.clock.runFor(130_000);
  await allAsked(page);
  assert.equal(asked, 1);
});

test('flights show when they were flown, by the clock of the place', options, async () => {
  // Whoever reads it is half a day away.
  const { page, mock, flight } = await setUpFlight('Meadow', {}, { timezoneId: 'Pacific/Auckland', locale: 'en-GB' });
  const other = mock.seedReady('Brook');
  flight.captured = { first: '2015-10-27T19:50:02-04:00', last: '2015-10-27T20:10:02-04:00' };
  other.captured = null;
  await page.reload();
  await page.waitForSelector('.flights li');
  const facts = await page.locator('.flight-facts').allTextContents();
  // The one whose photos know no time lies by its upload.
  assert.deepEqual(facts.map((text) => text.replaceAll('\u00a0', ' ')), ['uploaded 12 May 2026', '19 photos · 1.73 cm/px · ±2.3 m', '27 Oct 2015', '19 photos · 1.73 cm/px · ±2.3 m']);
  await page.goto(`${mock.url}#/flights/${flight.id}`);
  await page.waitForSelector('#report');
  assert.match((await page.textContent('.flight-head .flight-facts')) ?? '', /27 Oct 2015/);
  assert.match((await page.textContent('#report')) ?? '', /Captured27 Oct 2015, 19:50\s*–\s*20:10 \(UTC−4\)/);
  await mapIdle(page);
  await page.goto(`${mock.url}#/flights/${other.id}`);
  await page.waitForSelector('#report');
  await mapIdle(page);
  await page.click('#tool-compare');
  assert.match((await page.textContent('#compare-chooser')) ?? '', /Meadow27 Oct 2015/);
  await page.click('.choice');
  await page.waitForSelector('#compare-bar');
  assert.match((await page.textContent('#compare-bar')) ?? '', /uploaded 12 May 2026.*27 Oct 2015/);
});

test('a guest who only reads is offered nothing that would be refused', options, async () => {
  const { page, mock, flight } = await setUpFlight('Meadow', { has_tokens: true, scope: 'read' });
  await page.goto(`${mock.url}?token=sq_read`);
  await page.waitForSelector('#reads-only');
  await page.waitForSelector('.flights li');
  for (const id of ['#new-flight', '#drop-zone']) assert.ok(await page.locator(id).isHidden(), id);
  assert.equal(await page.locator('.flights .row-actions button').count(), 0);
  await assertAccessible(page, 'home of a guest');
  await page.setInputFiles('#files-input', photoFiles(2));
  await page.waitForSelector('.note-error');
  assert.match((await page.textContent('.note-error')) ?? '', /view-only/);
  assert.equal(mock.flights.size, 1);
  await page.goto(`${mock.url}#/flights/${flight.id}`);
  await page.waitForSelector('#report');
  await mapIdle(page);
  for (const id of ['flight-share', 'flight-add', 'flight-rename', 'flight-delete']) assert.equal(await page.locator(`#${id}`).count(), 0, id);
  // What goes to other programs carries what they need to read it.
  assert.match(await page.locator('.address input').first().inputValue(), /\/\{z\}\/\{x\}\/\{y\}\?rev=1&token=sq_read$/);
  assert.match((await savedBy(page, 'text=Settings for QGIS')).text, /&amp;token=sq_read"/);
});

test('addresses for other programs never carry a token that may change things: one is made for them', options, async () => {
  const { page, mock, flight } = await setUpFlight('Meadow', { has_tokens: true, scope: 'upload' });
  await page.goto(`${mock.url}?token=sq_upload#/flights/${flight.id}`);
  await page.waitForSelector('#links-make');
  await mapIdle(page);
  assert.equal(await page.locator('.address').count(), 0);
  await assertAccessible(page, 'links that need a token');
  await page.click('#links-make');
  await page.waitForSelector('.address');
  for (const address of await page.locator('.address input').all()) assert.match(await address.inputValue(), new RegExp(`token=${flight.shares[0].token}$`));
  assert.ok(!(await page.innerHTML('#map-addresses')).includes('sq_upload'));
});

test('the panel says what counts first, and what to do with the map', options, async () => {
  const { page, mock, flight } = await setUpFlight('Meadow', { is_whole: true });
  // The camera's name is in the first bytes of a photo.
  await page.route('**/files/DJI_0001.JPG*', (route) => route.fulfill({ body: photoFiles(1)[0].buffer, contentType: 'image/jpeg' }));
  await openMap(page, `${mock.url}#/flights/${flight.id}`);
  await page.waitForFunction(() => /CameraFC300S/.test(document.querySelector('#report')?.textContent ?? ''));
  const terms = await page.locator('#report > .facts dt').allTextContents();
  assert.deepEqual(terms, ['Captured', 'Area', 'Resolution', 'Absolute accuracy', 'Relative accuracy', 'Camera', 'Photos placed']);
  assert.match((await page.innerText('#result-verdict')).replace(/\s+/g, ' '), /^Ready to use\. All 18 photos are aligned\./);
  assert.match(await page.innerText('#report > .facts'), /±7\.5.ft \(1σ\), by 18 GNSS positions/);  // the browser speaks American English
  assert.equal(await page.locator('#processing-details').getAttribute('open'), null);
  assert.deepEqual(await page.locator('.flight-actions > *').evaluateAll((all) => all.map(({ id }) => id)), ['flight-share', 'flight-download', 'flight-qgis']);
  await page.click('#flight-download');
  assert.deepEqual(await page.locator('.download span').allTextContents(), ['GeoTIFF in UTM', 'Report (PDF)', 'Google Earth', 'GeoTIFF in Web Mercator',
    'MBTiles', 'PMTiles', 'Positions of the photos', 'All files']);
  await page.keyboard.press('Escape');
  await page.click('#flight-qgis');
  assert.equal(await page.getAttribute('#qgis-file', 'href'), `/connect/${flight.id}/qgis.qlr`);
  assert.match(await page.innerText('#qgis-body'), /Drag it.*QGIS/);
});

test('QGIS is given a token of its own where the server asks for one', options, async () => {
  const { page, flight } = await setUpReady('Meadow', { has_tokens: true });
  await page.click('#flight-qgis');
  await page.click('#qgis-body #links-make');
  await page.waitForSelector('#qgis-file');
  assert.equal(await page.getAttribute('#qgis-file', 'href'), `/connect/${flight.id}/qgis.qlr?token=${flight.shares[0].token}`);
});

test('of an imported map nothing is offered that takes its photos', options, async () => {
  const { page, mock } = await setUp({ is_whole: true });
  const [imported, own] = [mock.seedReady('Imported', 0), mock.seedReady('Own')];
  for (const flight of [imported, own]) flight.error = { code: 'internal', message: 'The job stopped.' };
  for (const flight of [imported, own]) {
    await page.goto(`${mock.url}#/flights/${flight.id}`);
    await page.waitForSelector('#failure');
    await mapIdle(page);
    await page.waitForSelector('#report');
    const is_own = flight === own ? 1 : 0;
    assert.equal(await page.locator('#start-job').count(), is_own, flight.name);
    assert.equal(await page.locator('#flight-move').count(), is_own, flight.name);
    assert.equal(await page.locator('#flight-download').count(), 1);
  }
});

test('heights can be downloaded where the map has them', options, async () => {
  const { page, mock, flight } = await setUpFlight('Village', { has_heights: true });
  await page.goto(`${mock.url}#/flights/${flight.id}`);
  await page.click('#flight-download');
  await page.waitForSelector('.download[href*="contours.dxf"] small:has-text("7")');
  assert.deepEqual((await page.locator('.download span').allTextContents()).slice(8), ['Surface model (DSM)', 'Terrain model (DTM)', 'Contours', 'Contours']);
  assert.match((await page.locator('#heights-zero').textContent()) ?? '', /count from take-off/);
});

test('a report that could not be had is asked for again where somebody wants it', options, async () => {
  const { page, mock, flight } = await setUpFlight('Meadow', {}, { errors: /status of 503/ });
  let is_away = true;
  await page.route('**/report', (/** @type {any} */ route) => (is_away ? route.fulfill({ status: 503, contentType: 'application/problem+json', json: { title: 'Away', status: 503 } }) : route.fallback()));
  await page.goto(`${mock.url}#/flights/${flight.id}`);
  await page.waitForSelector('#report-retry');
  is_away = false;
  await page.click('#report-retry');
  await page.waitForSelector('#report .facts');
});
