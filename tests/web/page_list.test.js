// The list of flights on the page, in Chromium against the mock server.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { mapIdle } from './support/browser.js';
import { assertAccessible, assertQuiet, openReady, options, usePages } from './support/pages.js';

const { setUp, setUpReady } = usePages();

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
  assert.match(await page.textContent('#flights-message'), /No flights match/);
  await assertAccessible(page, 'searched list');
  await assertQuiet(opened);
});

test('a flight is renamed by keyboard', options, async () => {
  const opened = await setUpReady('Old name');
  const { page, flight } = opened;
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

test('a deleted flight is in the trash at once, whatever happens to the page, and comes back from there', options, async () => {
  const opened = await setUp();
  const { page, mock } = opened;
  const flight = await openReady({ page, mock }, 'Meadow');
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
  await again.click('#trash-fold summary');
  assert.match((await again.textContent('#trash')) ?? '', /Meadow.*30 days left/);
  await assertAccessible(again, 'trash');
  await again.click('#trash button:has-text("Restore")');
  await again.waitForSelector('.flights li');
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
  assert.equal(mock.deleted.size, 0);
  assert.equal(mock.flights.size, 0);
});

test('a server without a trash is asked before it deletes', options, async () => {
  const opened = await setUp({ trash_days: 0 });
  const { page, mock } = opened;
  mock.seedReady('Meadow');
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
  await assertQuiet(opened);
});

test('the first view is light, and the map library comes only with the first map', options, async () => {
  const opened = await setUp();
  const { page, mock } = opened;
  await page.waitForLoadState('networkidle');
  assert.ok(opened.transferred() < 400_000, `${opened.transferred()} bytes for the first view`);
  await openReady({ page, mock }, 'Meadow');
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
