// axe over every view of the page, in Chromium against the mock server.
import { test } from 'node:test';
import { kPhone, openMap, openPhotoCard } from './support/browser.js';
import { assertAccessible, options, usePages } from './support/pages.js';
import { photoFiles } from './support/photo_files.js';

const { setUp } = usePages();

for (const colorScheme of /** @type {const} */ (['light', 'dark'])) {
  for (const [screen, context] of Object.entries({ laptop: {}, phone: kPhone })) {
    test(`axe finds no fault in any view on a ${screen} in the ${colorScheme} scheme`, options, async () => {
      const { page, mock } = await setUp({ upload_ms: 400, job_ms: 20_000 }, { ...context, colorScheme, reducedMotion: 'reduce', errors: /422/ });
      await page.click('summary');
      await assertAccessible(page, 'home without flights');
      const flight = mock.seedReady('Meadow');
      await page.reload();
      await page.waitForSelector('.overview-mark');
      await assertAccessible(page, 'home');
      await openMap(page, `${mock.url}#/flights/${flight.id}`);
      await page.waitForSelector('#report');
      await assertAccessible(page, 'map');
      await page.click('#flight-download');
      await assertAccessible(page, 'downloads');
      await page.keyboard.press('Escape');
      await page.click('#flight-qgis');
      await page.waitForSelector('#qgis-file');
      await assertAccessible(page, 'QGIS');
      await page.keyboard.press('Escape');
      await page.click('#flight-move');
      await page.click('#place-centre');
      await page.keyboard.type('46.8');
      await page.waitForSelector('.place-fault');
      await assertAccessible(page, 'placing the map');
      await page.keyboard.press('Escape');
      await openPhotoCard(page);
      await page.click('#tool-layers');
      await page.selectOption('#colour-by', 'error');
      await assertAccessible(page, 'map with cards');
      await page.goto(`${mock.url}#/`);
      await page.setInputFiles('#files-input', [...photoFiles(9), { ...photoFiles(1)[0], name: 'refused.JPG' }]);
      await page.waitForSelector('#upload-progress');
      await assertAccessible(page, 'upload');
      await page.waitForSelector('#upload-failures .callout');
      await assertAccessible(page, 'failed upload');
      await page.click('text=Continue without them');
      await page.waitForSelector('#job-progress');
      await assertAccessible(page, 'processing');
    });
  }
}
