// From an empty folder to what is handed over, on the real server with a simulated flight: a stranger drops in, and has a
// report as PDF and a GeoTIFF in UTM after nine clicks at most. SKYQUILT_PICTURES=FOLDER keeps a picture after each.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { mkdirSync, mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { atRest, mapIdle } from '../support/browser.js';
import { options, usePages } from '../support/pages.js';
import { binary, findPhotos, missingBinary, startServer } from '../support/real_server.js';

const { SKYQUILT_PICTURES: pictures = '' } = process.env;
const kMaxClicks = 9;
const { openAt, cleanUp } = usePages();

const prints = ['weasyprint', 'chromium', 'chromium-browser', 'google-chrome', 'google-chrome-stable', 'wkhtmltopdf'].some(
  (name) => spawnSync('which', [name]).status === 0);

for (const [name, context] of /** @type {[string, object][]} */ ([
  ['laptop-en-light', { viewport: { width: 1366, height: 768 }, locale: 'en-GB' }],
  ['phone-de-dark', { viewport: { width: 390, height: 844 }, deviceScaleFactor: 2, isMobile: true, hasTouch: true, locale: 'de-DE', colorScheme: 'dark' }],
])) {
  test(`from an empty folder to a PDF and a GeoTIFF in UTM in nine clicks: ${name}`, { ...options, timeout: 300_000, skip: options.skip || missingBinary() || (prints ? false : 'no program that prints') }, async () => {
    const folder = mkdtempSync(join(tmpdir(), 'skyquilt-deliver-'));
    cleanUp(async () => rmSync(folder, { recursive: true, force: true }));
    const made = spawnSync(binary, ['simulate', '-o', join(folder, 'flight'), '--photos', '12', '--size', '800x600', '--noise', 'xmp', '--no-world'], { encoding: 'utf8' });
    assert.equal(made.status, 0, made.stderr);
    const server = await startServer(join(folder, 'data'));
    cleanUp(server.stop);
    const { page, console_errors, foreign_requests } = await openAt(server.url, { is_drawn: Boolean(pictures), acceptDownloads: true, ...context });
    page.setDefaultTimeout(120_000);
    let clicks = 0;
    const picture = async () => {
      if (!pictures) return;
      mkdirSync(join(pictures, name), { recursive: true });
      await atRest(page);
      await page.screenshot({ path: join(pictures, name, `deliverables-${String(clicks).padStart(2, '0')}.png`) });
    };
    const click = async (/** @type {string} */ selector) => {
      await page.locator(selector).first().click();
      clicks += 1;
      await picture();
    };
    const fetched = async (/** @type {string} */ format) => {
      await page.waitForSelector('#exports li:first-child[data-state="successful"] a');
      await picture();
      const [download] = await Promise.all([page.waitForEvent('download'), click('#exports li:first-child[data-state="successful"] a')]);
      const path = join(folder, format);
      await download.saveAs(path);
      return { name: download.suggestedFilename(), bytes: readFileSync(path) };
    };

    await picture();
    const [chooser] = await Promise.all([page.waitForEvent('filechooser'), click('#choose-files')]);
    await chooser.setFiles(findPhotos(join(folder, 'flight')));
    await page.waitForSelector('#flight-download');
    await mapIdle(page);
    await click('#flight-download');
    await click('#download-report');
    const pdf = await fetched('report');
    assert.equal(pdf.bytes.subarray(0, 5).toString('latin1'), '%PDF-');
    assert.match(pdf.name, /\.pdf$/);
    await click('dialog[open] .dialog-actions button');
    await click('#flight-download');
    await click('#download-utm');
    const tiff = await fetched('utm');
    assert.equal(tiff.bytes.subarray(0, 2).toString('latin1'), 'II');
    assert.match(tiff.name, /\.tif$/);
    assert.ok(clicks <= kMaxClicks, `${clicks} clicks`);
    assert.deepEqual(foreign_requests, []);
    assert.deepEqual(console_errors, []);
  });
}
