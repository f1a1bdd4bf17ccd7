// A shared flight against the real server: the bare map in a frame of another site, exports, and the end of both.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { launchBrowser, mapIdle, missingForBrowser, openPage } from '../support/browser.js';
import { frameOn, startOuterPage } from '../support/outer_page.js';
import { binary, findPhotos, missingBinary, startServer } from '../support/real_server.js';

const missing = missingForBrowser() || missingBinary();
const options = { skip: missing || false, timeout: 400_000 };

let browser;
let folder = '';

before(async () => {
  if (missing) return;
  folder = mkdtempSync(join(tmpdir(), 'skyquilt-share-'));
  const made = spawnSync(binary, ['simulate', '-o', join(folder, 'flight'), '--photos', '6', '--size', '800x600'], { encoding: 'utf8' });
  assert.equal(made.status, 0, made.stderr);
  browser = await launchBrowser();
});
after(async () => {
  await browser?.close();
  if (folder) rmSync(folder, { recursive: true, force: true });
});

test('a map is embedded by its share and exported by the guest; revoked, neither; the page itself is in no frame', options, async () => {
  const data = join(folder, 'data');
  const added = spawnSync(binary, ['token', 'add', 'own', '--data', data, '--scope', 'upload'], { encoding: 'utf8' });
  const token = /** @type {RegExpMatchArray} */ (added.stdout.match(/sq_\S+/))[0];
  const server = await startServer(data);
  const { page } = await openPage(browser, server.url);
  const guests = await browser.newContext({ acceptDownloads: true });
  try {
    await page.fill('#token-input', token);
    await page.keyboard.press('Enter');
    await page.waitForSelector('#token-dialog', { state: 'detached' });
    await page.setInputFiles('#files-input', findPhotos(join(folder, 'flight')));
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
      const file = join(folder, 'export.tif');
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
    await page.context().close();
    await server.stop();
  }
});
