// The bare map in a frame of a page of another site, in Chromium against the mock server.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { frameOn, mapIdle, startOuterPage } from '../support/browser.js';
import { assertAccessible, assertQuiet, options, usePages } from '../support/pages.js';

const { setUp, cleanUp } = usePages();

test('a map in a frame has its name, scale and makers, moves, and opens the page', options, async () => {
  const opened = await setUp();
  const { page, mock } = opened;
  const flight = mock.seedReady('Meadow <1>');
  flight.attribution = 'Survey <b>Office</b>';
  await page.goto(`${mock.url}#/flights/${flight.id}`);
  await mapIdle(page);
  await page.click('#flight-share');
  await page.click('#share-make');
  await page.waitForSelector('#share-made input');
  const snippet = await page.locator('#share-made input').nth(1).inputValue();
  assert.match(snippet, /^<iframe src="http:\/\/127\.0\.0\.1:\d+\/embed\/\w+#token=\w+" title="Meadow &lt;1&gt;"/);
  await assertAccessible(page, 'share dialog');
  const outer = await startOuterPage(snippet);
  cleanUp(outer.close);
  await page.goto(outer.url);
  const frame = await frameOn(page);
  await frame.waitForSelector('#map[data-map-state="idle"]', { timeout: 60_000 });
  assert.equal(await frame.textContent('.embed-name'), 'Meadow <1>');
  assert.match((await frame.textContent('.maplibregl-ctrl-scale')) ?? '', /\d+\s*(m|ft)/);
  assert.match((await frame.textContent('.maplibregl-ctrl-attrib')) ?? '', /Survey <b>Office<\/b>/, 'text, and no markup');
  assert.equal(await frame.locator('.panel, #flight-delete, #token-dialog').count(), 0);
  const zoom = () => frame.evaluate(() => /** @type {any} */ (window).skyquilt.map.getZoom());
  const before = await zoom();
  await frame.click('.tool >> nth=0');
  await frame.waitForFunction((was) => /** @type {any} */ (window).skyquilt.map.getZoom() > was + 0.5 && !/** @type {any} */ (window).skyquilt.map.isMoving(), before);
  // Who scrolls the page does not zoom the map.
  const zoomed = await zoom();
  await frame.evaluate(() => {
    const { map } = /** @type {any} */ (window).skyquilt;
    Object.assign(window, { held_back: new Promise((resolve) => map.once('cooperativegestureprevented', () => resolve(undefined))) });
  });
  await page.mouse.move(300, 300);
  await page.mouse.wheel(0, 300);
  await frame.evaluate(() => /** @type {any} */ (window).held_back);
  assert.equal(await zoom(), zoomed);
  assert.match(String(await frame.getAttribute('.embed-caption', 'href')), new RegExp(`#/flights/${flight.id}\\?token=${flight.shares[0].token}$`));
  opened.foreign_requests = opened.foreign_requests.filter((url) => !url.startsWith(outer.url));
  await assertQuiet(opened);
  await page.goto(`${mock.url}embed/${flight.id}`);
  await mapIdle(page);
  await assertAccessible(page, 'bare map');
});

test('the link made for a share carries its token in the frame, and the place that was shown', options, async () => {
  const opened = await setUp({ has_tokens: true });
  const { page, mock } = opened;
  const flight = mock.seedReady('Meadow');
  const [lon, lat] = [flight.place.lon, flight.place.lat];
  await page.goto(`${mock.url}#/flights/${flight.id}?at=19.50/${lat.toFixed(7)}/${lon.toFixed(7)}`);
  await mapIdle(page);
  await page.click('#flight-share');
  await page.click('#share-make');
  await page.waitForSelector('#share-made input');
  const snippet = await page.locator('#share-made input').nth(1).inputValue();
  const [share] = flight.shares;
  const address = /** @type {RegExpMatchArray} */ (snippet.match(/src="([^"]+)"/))[1].replaceAll('&amp;', '&');
  assert.equal(address, `${mock.url}embed/${flight.id}#token=${share.token}&at=19.50/${lat.toFixed(7)}/${lon.toFixed(7)}`);
  // What somebody typed on the page itself is not used in the frame.
  await page.evaluate(() => localStorage.setItem('skyquilt-token', 'sq_admin'));
  const asked = page.waitForRequest((request) => request.url().endsWith(`/tiles/${flight.id}.json`) && request.headers().authorization === `Bearer ${share.token}`);
  await page.goto(address);
  await asked;
  await mapIdle(page);
  assert.ok(Math.abs((await page.evaluate(() => /** @type {any} */ (window).skyquilt.map.getZoom())) - 19.5) < 0.01);
  assert.equal(await page.evaluate(() => sessionStorage.getItem('skyquilt-token')), null, 'the token is kept nowhere');
  const without = page.waitForRequest((request) => request.url().endsWith(`/tiles/${flight.id}.json`) && !request.headers().authorization);
  await page.goto(`${mock.url}?away`);
  await page.goto(`${mock.url}embed/${flight.id}`);
  await without;
  await mapIdle(page);
  await assertQuiet(opened);
});

test('what cannot be shown is said in the frame, and nobody is asked for a token there', options, async () => {
  const opened = await setUp();
  const { page, mock } = opened;
  const flight = mock.addFlight('Meadow');
  await page.goto(`${mock.url}embed/${flight.id}`);
  await page.waitForSelector('#note:not([hidden])');
  assert.match((await page.textContent('#note')) ?? '', /There is no map here/);
  await page.route('**/tiles/*.json', (route) => route.fulfill({ status: 401, contentType: 'application/problem+json', body: '{"title":"Unauthorized","status":401}' }));
  await page.reload();
  await page.waitForFunction(() => document.getElementById('note')?.textContent?.includes('expired or was revoked'));
  assert.equal(await page.locator('#token-dialog').count(), 0);
  await assertAccessible(page, 'bare map that is not shared');
  await assertQuiet(opened, [/40[14]/]);
});
