// Sharing a flight on the page, in Chromium against the mock server: its links, and the bare map in a frame of a page of another site.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { isLoopback } from '../../../web/src/sharing/share_dialog.js';
import { frameOn, mapIdle, openMap, startOuterPage } from '../support/browser.js';
import { kNetworkAddress } from '../support/mock_server.js';
import { assertAccessible, options, usePages } from '../support/pages.js';

const { setUp, setUpFlight, setUpReady, cleanUp } = usePages();

test('a link is made for as long as chosen, listed, and revoked', options, async () => {
  const { page, mock, flight } = await setUpReady('Meadow', { has_tokens: true });
  await page.click('#flight-share');
  await page.selectOption('#share-days', '7');
  await page.click('#share-make');
  await page.waitForSelector('#share-made input');
  assert.equal(await page.evaluate(() => document.activeElement?.id), 'share-make', 'the keyboard goes on there');
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
  await page.waitForFunction(() => document.activeElement?.matches('.shares li button'));
  assert.deepEqual(flight.shares.map(({ id }) => id), [share.id]);
  await page.keyboard.press('Escape');
  await page.waitForSelector('#share-dialog', { state: 'detached' });
});

test('a link that was just made stays while another is revoked, and goes with its own', options, async () => {
  const { page, flight } = await openShare({ has_tokens: true });
  await page.click('#share-make');
  await page.waitForSelector('#share-made input');
  const first = await page.inputValue('#share-made input');
  await page.click('#share-make');
  await page.waitForFunction((before) => /** @type {HTMLInputElement|null} */ (document.querySelector('#share-made input'))?.value !== before, first);
  const second = await page.inputValue('#share-made input');
  await page.locator('.shares li button').nth(1).click();
  await page.waitForFunction(() => document.querySelectorAll('.shares li').length === 1);
  assert.equal(await page.inputValue('#share-made input'), second, 'it is shown only once');
  await page.locator('.shares li button').click();
  await page.waitForFunction(() => document.querySelectorAll('.shares li').length === 0);
  assert.equal(await page.locator('#share-made input').count(), 0);
  assert.deepEqual(flight.shares, []);
});

/** A flight of a server, and its share dialog; no map is drawn. @param {object} [server_options] */
async function openShare(server_options) {
  let flight;
  const { page, mock } = await setUp(server_options, {}, (started) => `#/flights/${(flight = started.seedReady('Meadow')).id}`);
  await page.click('#flight-share');
  await page.waitForSelector('#share-make');
  return { page, mock, flight };
}

test('what is said while a dialog is open stands in it, can be clicked, and stays when it is closed', options, async () => {
  const { page } = await openShare();
  const said = await page.evaluate(async () => {
    const { showNote } = await import(new URL('src/shared/announce.js', location.href).href);
    for (const text of ['One note.', 'Another note.']) showNote(text, { duration_ms: 600_000 });
    return document.querySelector('#share-dialog #live')?.textContent;
  });
  assert.equal(said, 'Another note.');
  await page.click('#share-dialog .note:has-text("One note.") button');
  assert.deepEqual(await page.locator('.note-text').allTextContents(), ['Another note.']);
  await page.keyboard.press('Escape');
  await page.waitForSelector('#share-dialog', { state: 'detached' });
  await page.click('body > #toasts .note button');
  assert.equal(await page.locator('.note-text').count(), 0);
  assert.equal(await page.locator('body > #live').count(), 1);
});

test('on a server of this computer alone a link says so, and how others see the map', options, async () => {
  const { page, mock, flight } = await openShare();
  assert.match(await page.textContent('#share-who'), /this computer only/);
  await page.click('#share-make');
  await page.waitForSelector('#share-made input');
  assert.match(await page.textContent('#share-made label'), /this computer only/);
  assert.equal(await page.inputValue('#share-made input'), `${mock.url}#/flights/${flight.id}?token=${flight.shares[0].token}`);
  assert.doesNotMatch(await page.textContent('#share-dialog'), /skyquilt (serve|token)/, 'the page names no commands');
  await assertAccessible(page, 'share dialog of a local server');
  await page.click('#share-file');
  await page.waitForSelector('#download-dialog .download');
  assert.equal(await page.locator('#share-dialog').count(), 0);
});

test('on a server of this computer alone others on the network are let in, and a phone reads the link', options, async () => {
  const { page, flight } = await openShare();
  await page.click('#share-open-network');
  await page.waitForSelector('#share-network');
  assert.match(await page.textContent('#share-network'), new RegExp(`${kNetworkAddress}.*until Skyquilt is ended`));
  assert.equal(await page.locator('#share-local, #share-open').count(), 0, 'nobody who comes by the network may change anything');
  await page.click('#share-make');
  await page.waitForSelector('#share-made .qr-code');
  const link = `${kNetworkAddress}/#/flights/${flight.id}?token=${flight.shares[0].token}`;
  assert.equal(await page.inputValue('#share-made input'), link);
  assert.ok(((await page.getAttribute('#share-made .qr-code path', 'd'))?.match(/M/g) ?? []).length > 400, 'a code of that many letters');
  await assertAccessible(page, 'share dialog of a server that was opened');
});

test('on an open server a link is one that others reach and that only reads, and what the server itself allows is said', options, async () => {
  const { page, flight } = await openShare({ addresses: ['http://192.168.1.20:8080/maps', 'http://10.0.0.3:8080/maps'] });
  assert.doesNotMatch(await page.textContent('#share-body'), /this computer/);
  assert.match(await page.textContent('#share-open'), /asks nobody for a token.*change and delete/);
  await page.click('#share-make');
  await page.waitForSelector('#share-made input');
  const { token } = flight.shares[0];
  assert.equal(await page.inputValue('#share-made input'), `http://192.168.1.20:8080/maps/#/flights/${flight.id}?token=${token}`);
  assert.match(await page.locator('#share-made input').nth(1).inputValue(), new RegExp(`src="http://192\\.168\\.1\\.20:8080/maps/embed/${flight.id}#token=${token}"`));
});

test('a link that is over says so to its reader, in German too', options, async () => {
  const { page, mock, flight } = await setUpFlight('Wiese', { has_tokens: true }, { locale: 'de-CH', errors: /status of 401/ });
  await page.route('**/*', (route) => {
    const { authorization } = route.request().headers();
    if (authorization !== 'Bearer sq_share_over') return route.continue();
    return route.fulfill({ status: 401, contentType: 'application/problem+json', json: { title: 'Unauthorized', status: 401, code: 'unauthorized', detail: 'This server asks for a token.' } });
  });
  await page.goto(`${mock.url}?from=mail#/flights/${flight.id}?token=sq_share_over`);
  await page.waitForSelector('#token-dialog');
  assert.equal(await page.textContent('#token-dialog .dialog-title'), 'Dieser Link gilt nicht mehr');
  assert.match(await page.textContent('#token-dialog'), /abgelaufen oder wurde widerrufen/);
  await assertAccessible(page, 'link that is over');
  await page.keyboard.press('Escape');
  await page.waitForSelector('.callout-error');
  assert.match(await page.textContent('.callout-error'), /abgelaufen oder wurde widerrufen/);
  assert.doesNotMatch(await page.textContent('body'), /asks for a token|Token angenommen/);
});

test('links that cannot be listed are not called on their way', options, async () => {
  const { page } = await setUpReady('Meadow', {}, { errors: /status of 503/ });
  await page.route('**/shares', (route) => route.fulfill({ status: 503, contentType: 'application/problem+json', json: { title: 'Unavailable', status: 503, code: 'unavailable', detail: 'Not now.' } }));
  await page.click('#flight-share');
  await page.waitForSelector('#share-body .callout-error');
  assert.equal(await page.textContent('#share-body'), 'Not now.');
});

test('this computer is known by its names', () => {
  for (const host of ['localhost', 'maps.localhost', '127.0.0.1', '127.1.2.3', '[::1]']) assert.ok(isLoopback(host), host);
  for (const host of ['192.168.1.20', 'localhost.example.org', '[fd00::1]', '127.example.org']) assert.ok(!isLoopback(host), host);
});

test('a shared link shows the flight, sends its token and keeps it out of the address', options, async () => {
  const { page, mock, flight } = await setUpFlight('Meadow', { has_tokens: true });
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
});

test('a map in a frame has its name, scale and makers, moves, and opens the page', options, async () => {
  const { page, mock, flight, foreign_requests } = await setUpFlight('Meadow <1>');
  flight.attribution = 'Survey <b>Office</b>';
  await openMap(page, `${mock.url}#/flights/${flight.id}`);
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
  assert.deepEqual(foreign_requests.splice(0).filter((url) => !url.startsWith(outer.url)), []);
  await openMap(page, `${mock.url}embed/${flight.id}`);
  await assertAccessible(page, 'bare map');
});

test('the link made for a share carries its token in the frame, and the place that was shown', options, async () => {
  const { page, mock, flight } = await setUpFlight('Meadow', { has_tokens: true });
  const [lon, lat] = [flight.place.lon, flight.place.lat];
  await openMap(page, `${mock.url}#/flights/${flight.id}?at=19.50/${lat.toFixed(7)}/${lon.toFixed(7)}`);
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
});

test('what cannot be shown is said in the frame, and nobody is asked for a token there', options, async () => {
  const { page, mock } = await setUp({}, { errors: /40[14]/ });
  const flight = mock.addFlight('Meadow');
  await page.goto(`${mock.url}embed/${flight.id}`);
  await page.waitForSelector('#note:not([hidden])');
  assert.match((await page.textContent('#note')) ?? '', /There is no map here/);
  await page.route('**/tiles/*.json', (route) => route.fulfill({ status: 401, contentType: 'application/problem+json', body: '{"title":"Unauthorized","status":401}' }));
  await page.reload();
  await page.waitForFunction(() => document.getElementById('note')?.textContent?.includes('expired or was revoked'));
  assert.equal(await page.locator('#token-dialog').count(), 0);
  await assertAccessible(page, 'bare map that is not shared');
});

test('what the browser does not let onto the clipboard is copied as of old, and the focus stays', options, async () => {
  const { page } = await setUpReady('Meadow');
  await page.evaluate(() => {
    Object.defineProperty(navigator, 'clipboard', { value: { writeText: async () => { throw new DOMException('Write permission denied.', 'NotAllowedError'); } } });
    document.execCommand = (command) => command === 'copy';
  });
  const copy = page.locator('#map-addresses .address button').first();
  await copy.press('Enter');
  await page.waitForFunction(() => document.getElementById('live')?.textContent === 'Copied.');
  assert.equal(await page.locator('.note-error').count(), 0);
  assert.ok(await copy.evaluate((/** @type {Element} */ button) => button === document.activeElement));
  // A while later it is said again.
  await page.evaluate(() => {
    const later_ms = performance.now() + 60_000;
    performance.now = () => later_ms;
  });
  await copy.press('Enter');
  await page.waitForFunction(() => document.getElementById('live')?.textContent === 'Copied.\u00a0');
});
