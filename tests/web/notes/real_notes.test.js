// Notes against the real server: two who write at once, a guest of a share who only reads, and the file they lie in.
import assert from 'node:assert/strict';
import { join } from 'node:path';
import { test } from 'node:test';
import { mapIdle } from '../support/browser.js';
import { addToken, mapReady, options, stitchedFlight, useSimulatedFlight } from '../support/real_flights.js';

const used = useSimulatedFlight(['--no-world']);

test('two write notes at once and keep both; a guest sees them and writes none', options, async () => {
  const token = addToken(join(used.folder, 'data'), 'upload');
  const bearer = { Authorization: `Bearer ${token}` };
  const server = await used.serve('data');
  const address = await stitchedFlight(server.url, used.folder, bearer);
  const post = (/** @type {string} */ path, /** @type {object} */ body) =>
    fetch(`${address}/${path}`, { method: 'POST', headers: { ...bearer, 'Content-Type': 'application/json' }, body: JSON.stringify(body) });
  const get = async (/** @type {string} */ path) => (await fetch(`${address}/${path}`, { headers: bearer })).json();
  const share = await (await post('shares', { expires_in_days: 1 })).json();

  const write = async (/** @type {any} */ page, /** @type {string} */ name) => {
    await page.click('#note-add');
    await page.fill('#note-name', name);
    await page.click('#note-save');
    await page.waitForSelector('#notes-state[data-state="saved"]');
  };
  const open = async (/** @type {string} */ bearer_token) => {
    const opened = await used.open(`${server.url}#/flights/${address.split('/').pop()}?token=${bearer_token}`);
    await mapIdle(opened.page);
    await opened.page.waitForSelector('#notes', { state: 'attached' });
    return opened;
  };
  const one = await open(token);
  const two = await open(token);
  await write(one.page, 'Well');
  await write(two.page, 'Gate');  // does not know of the well: both stay
  assert.deepEqual((await two.page.locator('.note-show').allTextContents()).sort(), ['Gate', 'Well']);
  const guest = await open(share.token);
  await guest.page.waitForFunction(() => document.querySelectorAll('.note-mark').length === 2);
  assert.equal(await guest.page.locator('#note-add, .note-edit, .note-remove').count(), 0);
  assert.deepEqual(guest.console_errors, []);
  const by_guest = await fetch(`${address}/notes`, { method: 'PUT', headers: { Authorization: `Bearer ${share.token}`, 'Content-Type': 'application/geo+json' }, body: '{"type":"FeatureCollection","features":[]}' });
  assert.equal(by_guest.status, 403);
  const { files } = await get('files');
  assert.ok(files.some(({ name }) => name === 'map_notes.geojson'));
  // A map that is made again says nothing of them, and they stay.
  await post('jobs', {});
  await mapReady(address, bearer);
  const report = await get('report');
  assert.ok(!JSON.stringify(report.warnings).includes('map_notes'), JSON.stringify(report.warnings));
  assert.equal((await get('notes')).features.length, 2);
});
