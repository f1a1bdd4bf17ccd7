// A shared flight against the real server: the bare map in a frame of another site, exports, and the end of both.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { frameOn, mapIdle, startOuterPage } from '../support/browser.js';
import { findPhotos } from '../support/real_server.js';
import { addToken, options, useSimulatedFlight } from '../support/real_flights.js';

const used = useSimulatedFlight();

test('a map is embedded by its share and exported by the guest; revoked, neither; the page itself is in no frame', options, async () => {
  const token = addToken(join(used.folder, 'data'), 'upload');
  const { server, page } = await used.openServer('data');
  const guests = await used.browser.newContext({ acceptDownloads: true });
  try {
    await page.fill('#token-input', token);
    await page.keyboard.press('Enter');
    await page.waitForSelector('#token-dialog', { state: 'detached' });
    await page.setInputFiles('#files-input', findPhotos(join(used.folder, 'flight')));
    await page.waitForSelector('#report', { timeout: 240_000 });
    await mapIdle(page);
    await page.click('#flight-share');
    await page.selectOption('#share-days', '7');
    await page.click('#share-make');
    await page.waitForSelector('#share-made input');
    const link = await page.locator('#share-made input').first().inputValue();
    const snippet = await page.locator('#share-made input').nth(1).inputValue();

    const guest = await guests.newPage();
    const bare = await startOuterPage(snippet);
    const whole = await startOuterPage(`<iframe src="${server.url}" width="800" height="500"></iframe>`);
    try {
      await guest.goto(bare.url);
      const frame = await frameOn(guest);
      await frame.waitForSelector('#map[data-map-state="idle"]', { timeout: 60_000 });
      const shown = await frame.evaluate(() => /** @type {any} */ (window).skyquilt.map.areTilesLoaded());
      assert.ok(shown);
      const refusal = guest.waitForEvent('console', { predicate: (message) => /frame-ancestors 'none'/.test(message.text()), timeout: 30_000 });
      await guest.goto(whole.url);
      await refusal;
      assert.ok(!guest.frames().some((one) => one.url().startsWith(server.url)), 'the browser shows the whole page in no frame');

      await guest.goto(link);
      await guest.waitForSelector('#flight-download');
      await guest.click('#flight-download');
      await guest.click('#export-open');
      await guest.selectOption('#export-crs', 'epsg');
      await guest.fill('#export-epsg', '2193');  // of New Zealand
      await guest.click('#export-start');
      await guest.waitForSelector('#export-refusal');
      assert.match((await guest.textContent('#export-refusal')) ?? '', /EPSG:2193/);
      await guest.selectOption('#export-crs', 'utm');
      await guest.fill('#export-resolution', '50');
      await guest.click('#export-start');
      await guest.waitForSelector('#exports li a', { timeout: 60_000 });
      const [download] = await Promise.all([guest.waitForEvent('download'), guest.click('#exports li a')]);
      const file = join(used.folder, 'export.tif');
      await download.saveAs(file);
      assert.match(readFileSync(file).subarray(0, 4).toString('latin1'), /^(II\*|II\+|MM)/);
      if (!spawnSync('gdalinfo', ['--version']).error) assert.match(spawnSync('gdalinfo', [file], { encoding: 'utf8' }).stdout, /UTM zone[^]*Pixel Size = \(0\.5\d*,-0\.5/);

      await page.locator('.shares li button').first().click();
      await page.waitForFunction(() => document.querySelectorAll('.shares li').length === 0);
      await guest.goto(bare.url);
      const ended = await frameOn(guest);
      await ended.waitForSelector('#note:not([hidden])');
      assert.match((await ended.textContent('#note')) ?? '', /expired or was revoked/);
      assert.equal(await ended.locator('#token-dialog').count(), 0);
    } finally {
      await bare.close();
      await whole.close();
    }
  } finally {
    await guests.close();
  }
});
