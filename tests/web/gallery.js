// Renews the gallery: every state of the page, on laptop, phone and 4K screens, light and dark, against the mock.
//   node tests/web/gallery.js [FOLDER] [ONLY-NAMES-CONTAINING]
import { mkdirSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { launchBrowser, mapIdle, openPage } from './support/browser.js';
import { startMockServer } from './support/mock_server.js';
import { photoFiles } from './support/photo_files.js';

const out = process.argv[2] ?? join(dirname(fileURLToPath(import.meta.url)), 'gallery');
const only = process.argv[3] ?? '';
const screens = {
  laptop: { viewport: { width: 1366, height: 768 } },
  phone: { viewport: { width: 390, height: 844 }, deviceScaleFactor: 2, isMobile: true, hasTouch: true },
  '4k': { viewport: { width: 3840, height: 2160 } },
};

/** @type {Record<string, (page: any, flight: any, other: any, mock: any) => Promise<void>>} */
const states = {
  async home(page) {
    await page.waitForSelector('.flights li');
    await page.waitForTimeout(400);
  },
  async map(page, flight) {
    await openFlight(page, flight);
  },
  async photo(page, flight) {
    await openFlight(page, flight);
    await page.locator('#map canvas').focus();
    await page.keyboard.press('Enter');
    await page.waitForSelector('#photo-card:not([hidden])');
    await mapIdle(page);
  },
  async layers(page, flight) {
    await openFlight(page, flight);
    await page.click('#tool-layers');
    await page.check('#show-path');
    await page.selectOption('#colour-by', 'error');
    await page.waitForTimeout(500);
  },
  async measure(page, flight) {
    await openFlight(page, flight);
    await page.click('#tool-area');
    const box = await page.locator('#map').boundingBox();
    for (const [x, y] of [[0.35, 0.3], [0.6, 0.28], [0.62, 0.42], [0.4, 0.45]]) await page.mouse.click(box.x + box.width * x, box.y + box.height * y);
    await page.waitForTimeout(400);
  },
  async compare(page, flight, other) {
    await page.goto(`${new URL('/', page.url()).href}#/flights/${flight.id}/compare/${other.id}`);
    await mapIdle(page);
    await mapIdle(page, '#map-above');
  },
  async report(page, flight) {
    await openFlight(page, flight);
    await page.evaluate(() => document.querySelector('.coverage')?.closest('figure')?.scrollIntoView());
    await page.waitForTimeout(200);
  },
  async uploading(page) {
    const photos = photoFiles(36, 1_200_000);
    await page.setInputFiles('#files-input', [{ ...photos[0], name: 'DJI_0000_refused.JPG' }, ...photos.slice(1), { name: 'notes.docx', mimeType: '', buffer: Buffer.from('x') }]);
    await page.waitForSelector('#verdict', { timeout: 20_000 });
    await page.waitForSelector('#upload .callout', { timeout: 20_000 });
    await page.waitForTimeout(400);
  },
  async processing(page) {
    await page.setInputFiles('#files-input', photoFiles(3));
    await page.waitForSelector('#job');
    await page.waitForTimeout(3000);
  },
  async error(page, _flight, _other, mock) {
    const doomed = mock.addFlight('A doomed flight');
    await page.evaluate((/** @type {string} */ id) => (location.hash = `#/flights/${id}`), doomed.id);
    await page.waitForSelector('#waiting');
    await page.setInputFiles('#files-input', photoFiles(2));
    await page.waitForSelector('#failure', { timeout: 20_000 });
  },
};

/** @param {any} page @param {any} flight */
async function openFlight(page, flight) {
  await page.goto(`${new URL('/', page.url()).href}#/flights/${flight.id}`);
  await mapIdle(page);
}

mkdirSync(out, { recursive: true });
const browser = await launchBrowser();
try {
  for (const [screen, options] of Object.entries(screens)) {
    for (const colorScheme of ['light', 'dark']) {
      for (const [state, reach] of Object.entries(states)) {
        // The dark scheme and the large screen are told by a few.
        const few = ['home', 'map', 'report', 'error'];
        if (colorScheme === 'dark' && (screen === '4k' || !few.includes(state))) continue;
        if (screen === '4k' && !['home', 'map'].includes(state)) continue;
        const name = `${state}-${screen}-${colorScheme}`;
        if (!name.includes(only)) continue;
        const mock = await startMockServer({ job_ms: state === 'error' ? 2000 : 9000, upload_ms: state === 'uploading' ? 2500 : 20 });
        const flight = mock.seedReady('Brook meadow');
        const other = mock.seedReady('Brook meadow, two weeks later', 24);
        const { page, context } = await openPage(browser, mock.url, { ...options, colorScheme });
        await reach(page, flight, other, mock);
        await page.screenshot({ path: join(out, `${name}.jpg`), quality: 65, type: 'jpeg' });
        await context.close();
        await mock.close();
      }
    }
  }
  if ('empty'.includes(only)) {
    const mock = await startMockServer();
    const { page, context } = await openPage(browser, mock.url, screens.laptop);
    await page.waitForSelector('#flights-message:not([hidden])');
    await page.screenshot({ path: join(out, 'empty-laptop-light.jpg'), quality: 65, type: 'jpeg' });
    await context.close();
    await mock.close();
  }
} finally {
  await browser.close();
}
