// From an empty folder to what is handed over, on the real server with simulated flights: a stranger drops in, and has a report as
// PDF and a GeoTIFF in UTM after nine clicks at most, of a flight with bands an index as GeoTIFF and zones for the tractor.
// SKYQUILT_PICTURES=FOLDER keeps a picture after each click; SKYQUILT_BANDS=FOLDER takes the photos there for the flight with bands.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { mkdirSync, mkdtempSync, readdirSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { atRest, kPhone, mapIdle } from '../support/browser.js';
import { options, usePages } from '../support/pages.js';
import { binary, missingBinary, startServer } from '../support/real_server.js';

const { SKYQUILT_PICTURES: pictures = '', SKYQUILT_BANDS: own_bands = '' } = process.env;
const kMaxClicks = 9;
const { openAt, cleanUp } = usePages();

const prints = ['weasyprint', 'chromium', 'chromium-browser', 'google-chrome', 'google-chrome-stable', 'wkhtmltopdf'].some(
  (name) => spawnSync('which', [name]).status === 0);
const wanting = options.skip || missingBinary();
const visitors = /** @type {[string, object][]} */ ([
  ['laptop-en-light', { viewport: { width: 1366, height: 768 }, locale: 'en-GB' }],
  ['phone-de-dark', { ...kPhone, deviceScaleFactor: 2, locale: 'de-DE', colorScheme: 'dark' }],
]);

/** @param {string} folder */
const photosIn = (folder) => readdirSync(folder).sort().map((name) => join(folder, name));

/**
 * An empty server, its page and a flight's photos to give it.
 * @param {string} name of the visit's pictures
 * @param {object} context
 * @param {string[]} flight as `simulate` makes it
 */
async function visit(name, context, flight) {
  const folder = mkdtempSync(join(tmpdir(), 'skyquilt-deliver-'));
  cleanUp(async () => rmSync(folder, { recursive: true, force: true }));
  const made = spawnSync(binary, ['simulate', '-o', join(folder, 'flight'), '--noise', 'xmp', '--no-world', ...flight], { encoding: 'utf8' });
  assert.equal(made.status, 0, made.stderr);
  const server = await startServer(join(folder, 'data'));
  cleanUp(server.stop);
  const { page } = await openAt(server.url, { is_drawn: Boolean(pictures), acceptDownloads: true, ...context });
  page.setDefaultTimeout(120_000);
  let clicks = 0;
  const picture = async () => {
    if (!pictures) return;
    mkdirSync(join(pictures, name), { recursive: true });
    await mapIdle(page).catch(() => undefined);
    await atRest(page);
    await page.screenshot({ path: join(pictures, name, `deliverables-${String(clicks).padStart(2, '0')}.png`) });
  };
  const click = async (/** @type {string} */ selector) => {
    await page.locator(selector).first().click();
    clicks += 1;
    await picture();
  };
  /** What a click brings. */
  const fetched = async (/** @type {string} */ selector) => {
    await page.waitForSelector(selector).catch(async (error) => {
      throw new Error(`${error.message}\n${await page.locator('dialog[open], .note-text').allTextContents()}`);
    });
    await picture();
    const [download] = await Promise.all([page.waitForEvent('download'), click(selector)]);
    const path = join(folder, download.suggestedFilename());
    await download.saveAs(path);
    return { name: download.suggestedFilename(), bytes: readFileSync(path) };
  };
  await picture();
  const [chooser] = await Promise.all([page.waitForEvent('filechooser'), click('#choose-files')]);
  await chooser.setFiles(own_bands && flight.includes('--bands') ? photosIn(own_bands) : photosIn(join(folder, 'flight', 'photos')));
  await page.waitForSelector('#flight-download');
  await mapIdle(page);
  const assertFew = () => assert.ok(clicks <= kMaxClicks, `${clicks} clicks`);
  return { page, picture, click, fetched, assertFew };
}

const kNewestExport = '#exports li:first-child[data-state="successful"] a';
const kClose = 'dialog[open] .dialog-actions button';

for (const [name, context] of visitors) {
  test(`from an empty folder to a PDF and a GeoTIFF in UTM in nine clicks: ${name}`, { ...options, timeout: 300_000, skip: wanting || (prints ? false : 'no program that prints') }, async () => {
    const { click, fetched, assertFew } = await visit(name, context, ['--photos', '12', '--size', '800x600']);
    await click('#flight-download');
    await click('#download-report');
    const pdf = await fetched(kNewestExport);
    assert.equal(pdf.bytes.subarray(0, 5).toString('latin1'), '%PDF-');
    assert.match(pdf.name, /\.pdf$/);
    await click(kClose);
    await click('#flight-download');
    await click('#download-utm');
    const tiff = await fetched(kNewestExport);
    assert.equal(tiff.bytes.subarray(0, 2).toString('latin1'), 'II');
    assert.match(tiff.name, /\.tif$/);
    assertFew();
  });

  test(`from the files of several bands to NDVI and zones in nine clicks: ${name}`, { ...options, timeout: 300_000, skip: wanting || false }, async () => {
    const { page, picture, click, fetched, assertFew } = await visit(`bands-${name}`, context, ['--photos', '6', '--size', '640x480', '--bands']);
    if (name.startsWith('phone')) {
      await click('#tool-layers');
      await page.selectOption('#index', 'ndvi');
    }
    await page.waitForSelector('#index-histogram rect');
    await picture();
    assert.equal(await page.inputValue('#index'), 'ndvi', 'a flight with bands opens with its first index');
    const [shown] = await page.locator('#index-colours option:checked').allTextContents();
    assert.equal(shown, name.includes('-de-') ? 'Rot nach Grün' : 'Red to green');
    assert.match((await page.textContent('#index-calibration')) ?? '', name.includes('-de-') ? /reflexionsgrad/i : /reflectance/i);
    await click('#index-geotiff');
    const tiff = await fetched(kNewestExport);
    assert.equal(tiff.bytes.subarray(0, 2).toString('latin1'), 'II');
    assert.match(tiff.name, /\.tif$/);
    await click(kClose);
    assert.equal((await fetched('#zones-shp')).bytes.subarray(0, 2).toString('latin1'), 'PK');
    assertFew();
  });
}
