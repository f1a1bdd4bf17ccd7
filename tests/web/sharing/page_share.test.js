// Sharing a flight on the page, in Chromium against the mock server.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { mapIdle } from '../support/browser.js';
import { assertAccessible, assertQuiet, openReady, options, usePages } from '../support/pages.js';

const { setUp } = usePages();

test('a link is made for as long as chosen, listed, and revoked', options, async () => {
  const opened = await setUp({ has_tokens: true });
  const { page, mock } = opened;
  const flight = await openReady({ page, mock }, 'Meadow');
  await page.click('#flight-share');
  await page.selectOption('#share-days', '7');
  await page.click('#share-make');
  await page.waitForSelector('#share-made input');
  const link = await page.inputValue('#share-made input');
  const [share] = flight.shares;
  assert.equal(link, `${mock.url}#/flights/${flight.id}?token=${share.token}`);
  assert.equal(Math.round((Date.parse(share.expires_at) - Date.parse(share.created_at)) / 86_400_000), 7);
  await page.selectOption('#share-days', 'null');
  await page.click('#share-make');
  await page.waitForFunction(() => document.querySelectorAll('.shares li').length === 2);
  assert.equal(flight.shares[0].expires_at, null);
  await assertAccessible(page, 'share dialog');
  await page.locator('.shares li button').first().click();
  await page.waitForFunction(() => document.querySelectorAll('.shares li').length === 1);
  assert.deepEqual(flight.shares.map(({ id }) => id), [share.id]);
  await page.keyboard.press('Escape');
  await page.waitForSelector('#share-dialog', { state: 'detached' });
  await assertQuiet(opened);
});

test('where nobody needs a token the address itself is the link', options, async () => {
  const opened = await setUp();
  const { page, mock } = opened;
  const flight = await openReady({ page, mock }, 'Meadow');
  await page.click('#flight-share');
  await page.waitForSelector('#share-body input');
  assert.equal(await page.inputValue('#share-body input'), `${mock.url}#/flights/${flight.id}`);
  assert.equal(await page.locator('#share-make').count(), 0);
  await assertQuiet(opened);
});

test('a shared link shows the flight, sends its token and keeps it out of the address', options, async () => {
  const opened = await setUp({ has_tokens: true });
  const { page, mock } = opened;
  const flight = mock.seedReady('Meadow');
  flight.may_change = false;
  const shown = page.waitForRequest((request) => request.url().endsWith(`/api/v1/flights/${flight.id}`) && request.headers().authorization === 'Bearer sq_given');
  // A load of its own, as from a mail. Not by about:blank: Chromium blocks, and reports, what that still asks of loopback.
  await page.goto(`${mock.url}?from=mail`);
  await page.goto(`${mock.url}#/flights/${flight.id}?token=sq_given`);
  await shown;
  await mapIdle(page);
  assert.equal(page.url(), `${mock.url}#/flights/${flight.id}`);
  for (const id of ['flight-share', 'flight-add', 'flight-rename', 'flight-delete']) assert.equal(await page.locator(`#${id}`).count(), 0, id);
  // Another link, pasted where the page is open.
  const again = page.waitForRequest((request) => request.headers().authorization === 'Bearer sq_other');
  await page.evaluate((id) => { location.hash = `#/flights/${id}?token=sq_other`; }, flight.id);
  await again;
  await mapIdle(page);
  await assertQuiet(opened);
});
