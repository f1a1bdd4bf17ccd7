// The list of flights on the page, in Chromium against the mock server; and tags of flights: on the list, as its filter, in the open
// flight, and flights that are to be kept.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { holdAnswer, kPhone, mapIdle, openMap, twoFrames, until } from './support/browser.js';
import { allAsked, assertAccessible, openReady, options, usePages } from './support/pages.js';
import { hasTags, tagCounts } from '../../web/src/home/flight_list.js';
import { typedTags } from '../../web/src/flight/flight_tags.js';
import { parseRoute, routeHash } from '../../web/src/shared/router.js';

const { setUp, setUpFlight, setUpReady } = usePages();

test('names are shown as text, never as markup', options, async () => {
  const { page, mock } = await setUp();
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
});

test('a long list is searched and sorted', options, async () => {
  const { page, mock } = await setUp();
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
  assert.match(await page.textContent('#flights-message'), /No flights match/);
  await assertAccessible(page, 'searched list');
});

test('a click that begins before a flight changes in the list and ends after it opens the flight', options, async () => {
  const { page, mock } = await setUp();
  const flight = mock.seedReady('Before');
  await page.reload();
  await page.hover('.flight-name');
  await page.mouse.down();
  flight.name = 'After';
  await page.evaluate(() => document.dispatchEvent(new Event('visibilitychange')));
  await page.waitForSelector('.flight-name:has-text("After")');
  await page.mouse.up();
  await mapIdle(page);
  assert.equal(await page.textContent('#flight-title'), 'After');
});

test('a button of a flight counts while the flight changes in the list', options, async () => {
  const { page, mock } = await setUp();
  const flight = mock.seedReady('Meadow');
  await page.reload();
  await page.hover('.flights li');
  await page.hover('.flights li .row-actions button:nth-child(2)');
  await page.mouse.down();
  flight.files.set('DJI_0100.JPG', 1000);
  await page.evaluate(() => document.dispatchEvent(new Event('visibilitychange')));
  await page.waitForSelector('.flight-facts:has-text("20 photos")');
  await page.mouse.up();
  await page.waitForSelector('.note-action');
  await until(() => mock.deleted.size === 1, 'it is deleted');
});

test('a flight is taken out of the trash by a click that begins before another leaves it', options, async () => {
  const { page, mock } = await setUp();
  const [first, second] = ['Meadow', 'Brook'].map((name) => mock.seedReady(name));
  for (const flight of [first, second]) {
    mock.flights.delete(flight.id);
    mock.deleted.set(flight.id, flight);
  }
  await page.reload();
  await page.click('#trash-fold summary');
  await page.locator('#trash li:has-text("Meadow") button').first().hover();
  await page.mouse.down();
  mock.deleted.delete(second.id);
  await page.evaluate(() => document.dispatchEvent(new Event('visibilitychange')));
  await page.waitForFunction(() => document.querySelectorAll('#trash li').length === 1);
  await page.mouse.up();
  await page.waitForSelector('.flights li:has-text("Meadow")');
});

test('a flight that is gone does not come back with an answer from before', options, async () => {
  const { page, mock } = await setUp();
  const flight = mock.seedReady('Meadow');
  await page.reload();
  await page.waitForSelector('.flights li');
  const look = () => page.evaluate(() => document.dispatchEvent(new Event('visibilitychange')));
  const { isHeld, release } = await holdAnswer(page, '**/api/v1/flights?*');
  await look();
  await until(isHeld);
  mock.flights.delete(flight.id);
  await look();
  await page.waitForSelector('.flights li', { state: 'detached' });
  release();
  await allAsked(page);
  await twoFrames(page);
  assert.equal(await page.locator('.flights li').count(), 0);
});

test('a flight is renamed by keyboard', options, async () => {
  const { page, flight } = await setUpReady('Old name');
  await page.focus('#flight-rename');
  await page.keyboard.press('Enter');
  await page.waitForSelector('#rename-input');
  await assertAccessible(page, 'dialog');
  await page.keyboard.type('New name');
  await page.keyboard.press('Enter');
  await page.waitForFunction(() => document.querySelector('#flight-title')?.textContent === 'New name');
  assert.equal(flight.name, 'New name');
});

test('the skip link leads to the panel of what is open', options, async () => {
  const { page, flight } = await setUpReady('Meadow');
  await page.focus('.skip');
  await page.keyboard.press('Enter');
  await page.waitForFunction(() => document.activeElement?.id === 'panel-body');
  assert.equal(new URL(page.url()).hash, `#/flights/${flight.id}`);
  assert.equal(await page.textContent('#flight-title'), 'Meadow');
});

test('a step back leaves no dialog of a flight over the list', options, async () => {
  const { page } = await setUpFlight('Meadow');
  await page.reload();
  await page.click('.flight-link');
  await page.click('#flight-rename');
  await page.waitForSelector('#rename-input');
  await page.goBack();
  await page.waitForSelector('.flights li');
  await page.waitForSelector('dialog', { state: 'detached' });
});

test('a deleted flight is in the trash at once, whatever happens to the page, and comes back from there', options, async () => {
  const { page, mock, flight } = await setUpReady('Meadow');
  await page.click('#flight-delete');
  await page.waitForSelector('.note-action');
  assert.equal(mock.flights.size, 0);
  assert.equal(mock.deleted.size, 1);
  // The tab is closed while the note is there: nothing more is deleted by that.
  const context = page.context();
  await page.close({ runBeforeUnload: true });
  assert.equal(mock.deleted.size, 1);
  const again = await context.newPage();
  await again.goto(mock.url);
  const key = `skyquilt.upload.${flight.id}`;
  await again.evaluate((/** @type {string} */ name) => localStorage.setItem(name, '[]'), key);
  await again.click('#trash-fold summary');
  assert.match((await again.textContent('#trash')) ?? '', /Meadow.*30 days left/);
  await assertAccessible(again, 'trash');
  await again.click('#trash button:has-text("Restore")');
  await again.waitForSelector('.flights li');
  assert.equal(await again.evaluate((/** @type {string} */ name) => localStorage.getItem(name), key), '[]', 'it could be taken back');
  assert.equal(mock.flights.size, 1);
  await again.waitForSelector('#trash-fold', { state: 'detached' });

  await again.hover('.flights li');
  await again.click('.flights li .row-actions button:nth-child(2)');
  await again.waitForSelector('#trash-fold');
  await again.click('#trash-fold summary');
  await again.click('#trash button:has-text("Delete permanently")');
  await assertAccessible(again, 'question before the last step');
  await again.keyboard.press('Escape');
  assert.equal(mock.deleted.size, 1);
  await again.click('#trash button:has-text("Delete permanently")');
  await again.click('#remove-confirm');
  await again.waitForSelector('#trash-fold', { state: 'detached' });
  assert.equal(await again.evaluate((/** @type {string} */ name) => localStorage.getItem(name), key), null, 'the browser forgets what was to be sent');
  assert.equal(mock.deleted.size, 0);
  assert.equal(mock.flights.size, 0);
});

test('the second half of a double click deletes nothing more', options, async () => {
  const { page, mock } = await setUp();
  for (const name of ['Brook', 'Meadow']) mock.seedReady(name);
  await page.reload();
  await page.dblclick('.flights li:first-child .row-actions button:nth-child(2)');
  await page.waitForSelector('.note-action');
  await page.waitForFunction(() => document.querySelectorAll('.flights li').length === 1);
  await allAsked(page);
  assert.equal(await page.locator('.note').count(), 1);
});

test('a server without a trash is asked before it deletes', options, async () => {
  const { page, mock } = await setUp({ trash_days: 0 });
  const key = `skyquilt.upload.${mock.seedReady('Meadow').id}`;
  await page.evaluate((name) => localStorage.setItem(name, '[]'), key);
  await page.reload();
  await page.hover('.flights li');
  await page.click('.flights li .row-actions button:nth-child(2)');
  await page.waitForSelector('#remove-confirm');
  await page.keyboard.press('Escape');
  assert.equal(mock.flights.size, 1);
  await page.click('.flights li .row-actions button:nth-child(2)');
  await page.click('#remove-confirm');
  await page.waitForFunction(() => document.querySelectorAll('.flights li').length === 0);
  assert.equal(mock.flights.size, 0);
  assert.equal(await page.locator('.note-action').count(), 0);
  assert.equal(await page.evaluate((name) => localStorage.getItem(name), key), null, 'nor does the browser keep what was to be sent');
});

test('the first view is light, and the map library comes only with the first map', options, async () => {
  const { page, mock, transferred } = await setUp();
  await page.waitForLoadState('networkidle');
  assert.ok(transferred() < 400_000, `${transferred()} bytes for the first view`);
  await openReady({ page, mock }, 'Meadow');
});

test('the server away and back again: the list says so and recovers', options, async () => {
  const { page, mock } = await setUp({}, { errors: /ERR_FAILED/ });
  mock.seedReady('Meadow');
  await page.route('**/api/v1/flights?*', (route) => route.abort());
  await page.reload();
  await page.waitForFunction(() => /could not be loaded/.test(document.querySelector('#flights-message')?.textContent ?? ''));
  await page.unroute('**/api/v1/flights?*');
  await page.waitForSelector('.flights li', { timeout: 15_000 });
});

const laptop = { viewport: { width: 1440, height: 900 } };

test('chosen tags are all asked for, and those that no flight has can be taken back', () => {
  const flights = /** @type {any[]} */ ([{ tags: ['maize', 'north'] }, { tags: ['maize'] }, {}]);
  assert.deepEqual(flights.map((flight) => hasTags(flight, ['maize', 'north'])), [true, false, false]);
  assert.deepEqual(flights.map((flight) => hasTags(flight, [])), [true, true, true]);
  assert.deepEqual(tagCounts(flights, ['gone']), [['maize', 2], ['north', 1], ['gone', 0]]);
});

test('tags are kept in the address, whatever is in them', () => {
  const tags = ['Größe & Art', 'a+b=c', '100 %', '#1?'];
  assert.deepEqual(parseRoute(routeHash({ view: 'home', tags })), { view: 'home', tags });
  assert.equal(routeHash({ view: 'home', tags: [] }), '#/');
  assert.deepEqual(parseRoute('#/?tag=%E0%A4'), { view: 'home', tags: ['\ufffd'] });
});

test('typed tags are parted at commas and have no spaces around them', () => {
  assert.deepEqual(typedTags(' maize,  north   side ,, maize '), ['maize', 'north side']);
  assert.deepEqual(typedTags(' , '), []);
});

/** @param {any} mock */
function seed(mock) {
  for (const [name, ...tags] of [['Brook', 'maize', 'north'], ['Quarry', 'stone'], ['Dam'], ['Field', 'maize']]) mock.seedReady(name).tags = tags;
}

test('tags are on the list, filter it, and stay in the address through an open flight and a reload', options, async () => {
  const { page, mock } = await setUp({}, laptop);
  seed(mock);
  await page.reload();
  await page.waitForFunction(() => document.querySelectorAll('.flights li').length === 4);
  const names = () => page.locator('.flight-name').allTextContents();
  assert.deepEqual(await page.locator('#tag-filter .tag-word').allTextContents(), ['maize', 'north', 'stone']);
  assert.deepEqual(await page.locator('.flights li:has-text("Brook") .tag').allTextContents(), ['maize', 'north']);
  await page.click('#tag-filter [data-tag="maize"]');
  assert.deepEqual((await names()).sort(), ['Brook', 'Field']);
  assert.equal(await page.getAttribute('#tag-filter [data-tag="maize"]', 'aria-pressed'), 'true');
  assert.equal(await page.evaluate(() => document.activeElement?.getAttribute('data-tag')), 'maize', 'the focus stays');
  assert.equal(new URL(page.url()).hash, '#/?tag=maize');
  await page.waitForFunction(() => document.querySelectorAll('.overview-mark').length <= 2);
  await page.keyboard.press('Tab');
  await page.keyboard.press('Enter');
  assert.deepEqual(await names(), ['Brook']);
  await assertAccessible(page, 'a list that tags filter');
  await page.click('.flight-link');
  await mapIdle(page);
  await page.click('.back-link');
  await page.waitForSelector('.flights li');
  assert.deepEqual(await names(), ['Brook']);
  await page.reload();
  await page.waitForSelector('.flights li');
  assert.deepEqual(await names(), ['Brook']);
  await page.click('#home-link');
  await page.waitForFunction(() => document.querySelectorAll('.flights li').length === 4);
  assert.equal(await page.locator('[aria-pressed="true"]').count(), 0);
});

test('a tag is added by keyboard and taken off by its cross', options, async () => {
  const { page, mock } = await setUp({}, laptop);
  seed(mock);
  const flight = mock.seedReady('New');
  await page.reload();
  await page.click('.flight-link:has-text("New")');
  await mapIdle(page);
  await page.focus('#tag-add');
  await page.keyboard.press('Enter');
  assert.deepEqual(await page.locator('#tag-proposals option').evaluateAll((list) => list.map((one) => one.getAttribute('value'))), ['maize', 'north', 'stone']);
  await assertAccessible(page, 'a tag is being typed');
  await page.keyboard.type('north, Größe');
  await page.keyboard.press('Enter');
  await page.waitForFunction(() => document.querySelectorAll('#flight-tags .tag').length === 2 && document.activeElement?.id === 'tag-add');
  assert.deepEqual(flight.tags, ['north', 'Größe']);
  await page.keyboard.press('Enter');
  await page.keyboard.type('never');
  await page.keyboard.press('Escape');
  await page.click('.tag:has-text("north") .tag-remove');
  await page.waitForFunction(() => document.querySelectorAll('#flight-tags .tag').length === 1);
  assert.deepEqual(flight.tags, ['Größe']);
  assert.equal(await page.locator('#flight-keep').count(), 0, 'this server deletes no old flights');
});

test('tags that could not be saved stay in their field, and are sent again by Enter alone', options, async () => {
  const { page, flight } = await setUpReady('Meadow', {}, { errors: /ERR_FAILED/ });
  let tries = 0;
  const address = `**/flights/${flight.id}`;
  await page.route(address, (route) => {
    if (route.request().method() !== 'PATCH') return route.continue();
    tries += 1;
    return route.abort();
  });
  await page.click('#tag-add');
  await page.keyboard.type('north,Größe');
  await page.keyboard.press('Enter');
  await page.waitForFunction(() => /** @type {HTMLInputElement|null} */ (document.querySelector('#tag-input'))?.value === 'north, Größe');
  await page.click('#flight-title');
  await allAsked(page);
  assert.deepEqual([tries, await page.inputValue('#tag-input')], [1, 'north, Größe'], 'a click elsewhere is no try');
  await page.unroute(address);
  await page.press('#tag-input', 'Enter');
  await page.waitForFunction(() => document.querySelectorAll('#flight-tags .tag').length === 2);
  assert.deepEqual(flight.tags, ['north', 'Größe']);
});

test('a flight that was left gives the page its name no more, not by a tag that is saved late either', options, async () => {
  const { page, flight } = await setUpReady('Meadow');
  assert.equal(await page.getAttribute('#panel', 'aria-label'), 'Meadow');
  let save = () => {};
  const gate = new Promise((resolve) => { save = () => resolve(undefined); });
  await page.route(`**/flights/${flight.id}`, async (route) => {
    if (route.request().method() === 'PATCH') await gate;
    await route.continue();
  });
  await page.click('#tag-add');
  await page.keyboard.type('north');
  await page.keyboard.press('Enter');
  await page.click('.back-link');
  await page.waitForSelector('.flights li');
  const saved = page.waitForResponse((response) => response.request().method() === 'PATCH');
  save();
  await saved;
  await allAsked(page);
  await twoFrames(page);
  assert.deepEqual([await page.title(), await page.getAttribute('#panel', 'aria-label')], ['Skyquilt', 'Flights']);
});

test('a tag that is being typed when the map comes is taken whole', options, async () => {
  const { page, mock } = await setUp();
  const flight = mock.seedReady('Meadow');
  await page.reload();
  const { isHeld, release } = await holdAnswer(page, '**/report');
  await page.click('.flight-link');
  await until(isHeld);
  await page.click('#tag-add');
  await page.keyboard.type('no');
  release();
  await page.waitForSelector('#note-add');  // what of a flight comes last
  await twoFrames(page);
  await page.keyboard.type('rth');
  await page.keyboard.press('Enter');
  await page.waitForSelector('#flight-tags .tag');
  assert.deepEqual(flight.tags, ['north']);
});

test('a tag that is being typed when a job ends is taken whole', options, async () => {
  const { page, flight } = await setUpReady('Again', { job_ms: 1500 }, laptop);
  await page.click('#processing-details summary');
  await page.click('#run-again');
  await page.click('#options-submit');
  await page.waitForSelector('#options-dialog', { state: 'detached' });
  await page.click('#tag-add');
  await page.keyboard.type('nor');
  await page.waitForFunction(() => document.querySelector('.flight-view .work')?.childElementCount === 0);
  assert.equal(flight.job?.state, 'successful');
  await page.keyboard.type('th');
  await page.keyboard.press('Enter');
  await page.waitForFunction(() => document.querySelectorAll('#flight-tags .tag').length === 1 && document.activeElement?.id === 'tag-add');
  assert.deepEqual(flight.tags, ['north']);
});

test('a button of the open flight counts when a job ends while it is pressed', options, async () => {
  const { page } = await setUpReady('Again', { job_ms: 1500 }, laptop);
  await page.click('#processing-details summary');
  await page.click('#run-again');
  await page.click('#options-submit');
  await page.waitForSelector('#options-dialog', { state: 'detached' });
  await page.hover('#flight-rename');
  await page.mouse.down();
  await page.waitForFunction(() => document.querySelector('.flight-view .work')?.childElementCount === 0);
  await page.mouse.up();
  await page.waitForSelector('#rename-input');
});

/** Storage as in a browser that may keep nothing, from the next loading on. @param {any} page */
const keepNothing = (page) => page.addInitScript(() => {
  const get = () => { throw new DOMException('Nothing is kept here.', 'SecurityError'); };
  for (const name of ['localStorage', 'sessionStorage']) Object.defineProperty(window, name, { get });
});

test('in a browser that may keep nothing the page works, and what is chosen counts until it is left', options, async () => {
  const { page, mock, flight } = await setUpFlight('Meadow');
  for (const name of ['Brook', 'Quarry', 'Roof', 'Dam', 'Field']) mock.seedReady(name);
  await keepNothing(page);
  await page.reload();
  await page.waitForSelector('.flights li');
  await page.selectOption('#flight-order', 'name');
  await page.evaluate((/** @type {string} */ id) => { location.hash = `#/flights/${id}`; }, flight.id);
  await mapIdle(page);
  const before = await page.textContent('#coordinates');
  await page.click('.coordinates');
  assert.notEqual(await page.textContent('#coordinates'), before);
  const units = await page.evaluate(async () => {
    const { chosenUnits, keepUnits } = await import(new URL('src/shared/units.js', location.href).href);
    return ['imperial', 'metric'].map((kind) => {
      keepUnits(kind);
      return chosenUnits();
    });
  });
  assert.deepEqual(units, ['imperial', 'metric']);
});

test('a token that is typed, or comes with a link, opens the server where the browser may keep nothing', options, async () => {
  const { page, mock, flight } = await setUpFlight('Meadow', { has_tokens: true }, { errors: /status of 401/ });
  await keepNothing(page);
  let good = 'sq_typed';
  await page.route('**/api/v1/**', (/** @type {any} */ route) => {
    const is_good = route.request().headers().authorization === `Bearer ${good}` || new URL(route.request().url()).searchParams.get('token') === good;
    return is_good ? route.fallback() : route.fulfill({ status: 401, contentType: 'application/problem+json', json: { title: 'Unauthorized', status: 401, code: 'unauthorized' } });
  });
  const address = `${mock.url}?x=1#/flights/${flight.id}`;
  await page.goto(address);
  await page.fill('#token-input', good);
  await page.press('#token-input', 'Enter');
  await mapIdle(page);
  assert.equal(page.url(), address, 'the address does not keep the token');
  // Another link, pasted where the page is open.
  good = 'sq_other';
  await Promise.all([page.waitForEvent('load'), page.evaluate((/** @type {string} */ id) => { location.hash = `#/flights/${id}?token=sq_other`; }, flight.id)]);
  await mapIdle(page);
  assert.equal(page.url(), address);
});

test('a long name without blanks leaves what takes its deletion back on the screen of a phone', options, async () => {
  const { page } = await setUpReady('20260512_'.padEnd(150, 'Befliegung_'), {}, kPhone);
  await page.click('#flight-delete');
  const [undo, close] = [await page.locator('.note-action').boundingBox(), await page.locator('.note .icon-button').boundingBox()];
  assert.ok(undo.x > 0 && close.x > undo.x && close.x + close.width <= kPhone.viewport.width, JSON.stringify([undo, close]));
});

test('where old flights go to the trash, one is marked to be kept', options, async () => {
  const { page, flight } = await setUpReady('Old', { keep_days: 90 }, kPhone);
  await page.waitForSelector('#flight-keep');
  assert.match((await page.textContent('#flight-keep-hint')) ?? '', /90 days/);
  await page.focus('#flight-keep');
  await page.keyboard.press('Space');
  await page.waitForFunction(() => document.activeElement?.id === 'flight-keep' && /** @type {HTMLInputElement} */ (document.activeElement).checked);
  await until(() => flight.keep === true, 'the server keeps it');
  await assertAccessible(page, 'a flight that is kept, on a phone');
});

test('who only reads sees the tags and no way to change them', options, async () => {
  const { page, mock, flight } = await setUpFlight('Theirs', { scope: 'read', keep_days: 90 }, laptop);
  flight.tags = ['maize'];
  await openMap(page, `${mock.url}#/flights/${flight.id}`);
  assert.deepEqual(await page.locator('#flight-tags .tag').allTextContents(), ['maize']);
  assert.equal(await page.locator('#tag-add, .tag-remove, #flight-keep').count(), 0);
});

test('a trash that who looks may not see is not asked for with each movement', options, async () => {
  const { page, mock } = await setUp({}, { errors: /status of 403/ });
  mock.seedReady('Meadow');
  await page.goto('about:blank');  // what the first loading still asks does not count
  let asked = 0;
  await page.route('**/api/v1/trash', (/** @type {any} */ route) => {
    asked += 1;
    return route.fulfill({ status: 403, contentType: 'application/problem+json', json: { title: 'Forbidden', status: 403 } });
  });
  await page.goto(mock.url);
  await until(() => asked === 1);
  await page.evaluate(() => {
    for (let i = 0; i < 5; i += 1) dispatchEvent(new Event('scroll'));
  });
  await allAsked(page);
  assert.equal(asked, 1);
});
