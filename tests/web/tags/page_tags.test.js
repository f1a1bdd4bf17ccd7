// Tags of flights on the page, in Chromium against the mock server: on the list, as its filter, in the open flight; and
// flights that are to be kept.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { hasTags, tagCounts } from '../../../web/src/home/flight_list.js';
import { typedTags } from '../../../web/src/flight/flight_tags.js';
import { parseRoute, routeHash } from '../../../web/src/shared/router.js';
import { mapIdle } from '../support/browser.js';
import { assertAccessible, assertQuiet, openReady, options, usePages } from '../support/pages.js';

const { setUp } = usePages();
const laptop = { viewport: { width: 1440, height: 900 } };
const phone = { viewport: { width: 390, height: 844 }, isMobile: true, hasTouch: true };

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
  const opened = await setUp({}, laptop);
  const { page, mock } = opened;
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
  await assertQuiet(opened);
});

test('a tag is added by keyboard and taken off by its cross', options, async () => {
  const opened = await setUp({}, laptop);
  const { page, mock } = opened;
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
  await assertQuiet(opened);
});

test('a tag that is being typed when a job ends is taken whole', options, async () => {
  const opened = await setUp({ job_ms: 1500 }, laptop);
  const { page, mock } = opened;
  const flight = await openReady({ page, mock }, 'Again');
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
  await assertQuiet(opened);
});

test('where old flights go to the trash, one is marked to be kept', options, async () => {
  const opened = await setUp({ keep_days: 90 }, phone);
  const { page, mock } = opened;
  const flight = await openReady({ page, mock }, 'Old');
  await page.waitForSelector('#flight-keep');
  assert.match((await page.textContent('#flight-keep-hint')) ?? '', /90 days/);
  await page.focus('#flight-keep');
  await page.keyboard.press('Space');
  await page.waitForFunction(() => document.activeElement?.id === 'flight-keep' && /** @type {HTMLInputElement} */ (document.activeElement).checked);
  assert.equal(flight.keep, true);
  await assertAccessible(page, 'a flight that is kept, on a phone');
  await assertQuiet(opened);
});

test('who only reads sees the tags and no way to change them', options, async () => {
  const opened = await setUp({ scope: 'read', keep_days: 90 }, laptop);
  const { page, mock } = opened;
  const flight = mock.seedReady('Theirs');
  flight.tags = ['maize'];
  await page.goto(`${mock.url}#/flights/${flight.id}`);
  await mapIdle(page);
  assert.deepEqual(await page.locator('#flight-tags .tag').allTextContents(), ['maize']);
  assert.equal(await page.locator('#tag-add, .tag-remove, #flight-keep').count(), 0);
  await assertQuiet(opened);
});
