// A stranger's first visit, in Chromium on a laptop and a phone, in English and German, light and dark: photos dropped, the map
// waited for, everything opened that can be. At every step no word is cut or lies over another, no control is covered, nothing
// scrolls sideways, no English stands on the German page, and list, head and report say one and the same of the map.
// The server is the mock; one visit more is of the real one, with a simulated flight. With
//   SKYQUILT_VISIT=brighton  or another folder of SKYQUILT_DATA, or `made` for the simulated flight, all visits are of the real one
//   SKYQUILT_PICTURES=FOLDER a picture of every step is kept there
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { mkdirSync, mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { loadFlightWords } from '../../../web/src/shared/flight_strings.js';
import { kLanguages } from '../../../web/src/shared/language.js';
import { loadPageWords } from '../../../web/src/shared/strings.js';
import { atRest, holdRequests, kPhone, mapIdle, openPhotoCard } from '../support/browser.js';
import { faultsOf, foreignWords } from '../support/page_faults.js';
import { options, usePages } from '../support/pages.js';
import { photoFiles } from '../support/photo_files.js';
import { binary, findPhotos, missingBinary, realPhotos, startServer } from '../support/real_server.js';

const { SKYQUILT_PICTURES: pictures = '', SKYQUILT_VISIT: visited = '' } = process.env;
const screens = {
  laptop: { viewport: { width: 1366, height: 768 } },
  phone: { ...kPhone, deviceScaleFactor: 2 },
};
const kPatience_ms = 600_000;
/** Of the real server besides. */
const kRealVisit = 'phone-de-dark';
const { setUp, openAt, cleanUp } = usePages();

const wordsIn = async (/** @type {import('../../../web/src/shared/language.js').Language} */ tag) => ({ ...(await loadPageWords(tag)), ...(await loadFlightWords(tag)) });
const english = await wordsIn('en');
const foreign = new Map(await Promise.all(/** @type {['en', 'de']} */ (Object.keys(kLanguages)).map(
  async (tag) => /** @type {[string, any]} */ ([tag, tag === 'en' ? undefined : foreignWords(english, await wordsIn(tag))]))));

/** What is given to a real server: a real flight's photos where they are here and asked for. @param {string} folder for those that are made */
function photosOf(folder) {
  const found = visited === 'made' ? [] : realPhotos(visited === 'brighton' ? 'brighton_beach' : visited);
  if (visited && found.length > 0) return found;
  if (visited && visited !== 'made') console.log(`# ${visited} is not here: a simulated flight in its place`);
  const made = spawnSync(binary, ['simulate', '-o', folder, '--photos', '12', '--size', '800x600', '--noise', 'xmp', '--no-world'], { encoding: 'utf8' });
  assert.equal(made.status, 0, made.stderr);
  return findPhotos(folder);
}

/** A page of the real server in a data folder of its own, or of the mock. @param {object} context @param {boolean} is_real */
async function openVisit(context, is_real) {
  const drawn = { is_drawn: Boolean(pictures), ...context };
  if (!is_real) {
    const opened = await setUp({ upload_ms: 30 }, drawn);
    await opened.page.route('**/control', (/** @type {any} */ route) => route.fulfill({ json: { reference_system: '', points: [] }, headers: { ETag: '"0"' } }));
    return { ...opened, photos: photoFiles(18), holdUploads: opened.mock.holdUploads };
  }
  const folder = mkdtempSync(join(tmpdir(), 'skyquilt-visit-'));
  cleanUp(async () => rmSync(folder, { recursive: true, force: true }));
  const server = await startServer(join(folder, 'data'));
  cleanUp(server.stop);
  const opened = await openAt(server.url, drawn);
  return { ...opened, photos: photosOf(join(folder, 'flight')), holdUploads: () => holdRequests(opened.page, '**/api/v1/uploads**') };
}

/** What is opened on the map, in turn, and closed again by closeAll. @type {[string, (page: any) => Promise<void>][]} */
const views = [
  ['download', async (page) => {
    await page.click('#flight-download');
    await page.waitForSelector('.download small:has-text(",")');
  }],
  ['export', async (page) => {
    await page.click('#flight-download');
    await page.click('#export-open');
    await page.waitForSelector('#export-form');
    await page.selectOption('#export-crs', 'epsg');
  }],
  ['share', async (page) => {
    await page.click('#flight-share');
    await page.waitForSelector('#share-make');
  }],
  ['link', async (page) => {
    await page.click('#flight-share');
    await page.click('#share-make');
    await page.waitForSelector('#share-made input');
    await page.waitForSelector('.shares li');
  }],
  ['network', async (page) => {
    await page.click('#flight-share');
    await page.click('#share-open-network');
    await page.waitForSelector('#share-network');
    await page.click('#share-make');
    await page.waitForSelector('#share-made .qr-code');
  }],
  ['qgis', async (page) => {
    await page.click('#flight-qgis');
    await page.waitForSelector('#qgis-file');
  }],
  ['options', async (page) => {
    if (!(await page.locator('#run-again').isVisible())) await page.click('#processing-details summary');
    await page.click('#run-again');
    await page.click('.option-more summary');
  }],
  ['coarse', async (page) => {
    await page.click('#run-again');
    await page.fill('#option-resolution_cm', '500');
    await page.click('#options-submit');
    await page.waitForSelector('#coarse-dialog[open]');
  }],
  ['rename', (page) => page.click('#flight-rename')],
  ['note', async (page) => {
    await page.click('#note-add');
    await page.fill('#note-name', 'Well 3');
    await page.click('#note-centre');
    await page.click('#note-save');
    await page.waitForSelector('#note-list li');
    await page.click('#note-list .note-edit');
  }],
  ['control', async (page) => {
    await page.click('#control summary');
    await page.waitForSelector('#control-add');
  }],
  ['control-list', async (page) => {
    await page.click('#control-import-open');
    await page.waitForSelector('dialog[open]');
  }],
  ['control-point', async (page) => {
    await page.click('#control-add');
    await page.waitForSelector('dialog[open]');
  }],
  ['place', async (page) => {
    await page.click('#flight-move');
    await page.waitForSelector('#place-card:not([hidden])');
    await page.click('#place-centre');
  }],
  ['layers', async (page) => {
    await page.click('#tool-layers');
    await page.selectOption('#colour-by', 'error');
  }],
  ['photo', async (page) => {
    await page.click('#tool-layers');
    await openPhoto(page);
  }],
  ['viewer', async (page) => {
    await openPhoto(page);
    await page.click('#photo-open');
    await page.waitForSelector('.viewer-mark:not([hidden])');
  }],
  ['distance', (page) => measure(page, 'distance')],
  ['area', (page) => measure(page, 'area')],
];

/** Whatever is open. @param {any} page */
async function closeAll(page) {
  const dialogs = page.locator('dialog[open]');
  for (let open = await dialogs.count(); open > 0; open = await dialogs.count()) {
    await page.keyboard.press('Escape');
    await page.waitForFunction((/** @type {number} */ n) => document.querySelectorAll('dialog[open]').length < n, open);
  }
  await page.keyboard.press('Escape');
}

/** By the keyboard, at a photo's place in the middle of the window. @param {any} page */
async function openPhoto(page) {
  await page.waitForFunction(() => {
    const { map } = /** @type {any} */ (window).skyquilt;
    const [camera] = map.querySourceFeatures('cameras');  // none while they are drawn in other colours
    if (camera) map.jumpTo({ center: camera.geometry.coordinates });
    return Boolean(camera);
  });
  await mapIdle(page);
  await openPhotoCard(page);
}

/** @param {any} page @param {'distance'|'area'} kind */
async function measure(page, kind) {
  await page.keyboard.press('Escape');
  await page.click(`#tool-${kind}`);
  await page.waitForFunction(() => /** @type {any} */ (window).skyquilt.map.getCanvas().clientHeight === document.querySelector('#map')?.clientHeight);
  const box = await page.locator('#map').boundingBox();
  for (const [x, y] of [[0.3, 0.3], [0.6, 0.4], [0.4, 0.7]]) await page.mouse.click(box.x + box.width * x, box.y + box.height * y);
  await page.waitForFunction(() => /\d/.test(document.querySelector('#measure-result')?.textContent ?? ''));
}

/** What the head, the report and the list say of the map. @param {any} page */
async function assertOneStatus(page) {
  const text = async (/** @type {string} */ selector) => ((await page.textContent(selector)) ?? '').trim();
  const head = { status: await text('.flight-facts .chip'), facts: await text('.flight-facts') };
  const verdict = (await text('#result-verdict strong')).replace(/\.$/, '');
  assert.equal(head.status, verdict, 'head and report');
  const accuracy = (/** @type {string} */ said) => said.match(/±[\d.,]+\s(?:c?m|ft)/)?.[0] ?? 'unknown';
  const report = await text('#report .facts');
  const photos = await page.locator('#report .facts').first().textContent();
  assert.equal(accuracy(head.facts), accuracy(report), 'accuracy of head and report');
  await page.evaluate(() => (location.hash = '#/'));
  await page.waitForSelector('.flights li .chip');
  const row = await text('.flights li');
  assert.equal(await text('.flights li .chip'), verdict, 'list and report');
  assert.equal(accuracy(row), accuracy(report), 'accuracy of list and report');
  const gsd = row.match(/[\d.,]+\s\S?m\/px/)?.[0];
  if (gsd) assert.ok(photos?.includes(gsd), `${gsd} in the list, "${photos}" in the report`);
}

test('what is planted is found', options, async () => {
  const { page } = await setUp({}, { locale: 'de-DE' });
  await page.waitForSelector('#choose-files');
  assert.deepEqual(await faultsOf(page, foreign.get('de')), []);
  await page.evaluate(([sentence, made, title]) => {
    const kSmall = 'position: fixed; z-index: 99; top: 0; width: 4em; height: 2em; overflow: hidden; white-space: nowrap;';
    const plant = (/** @type {string} */ tag, /** @type {object} */ values, style = '') => document.body.append(Object.assign(document.createElement(tag), values, { style: kSmall + style }));
    plant('p', { id: 'cut', textContent: 'Donaudampfschifffahrt' });
    plant('p', { id: 'told', textContent: 'Donaudampfschifffahrt', title: 'Donaudampfschifffahrt' });
    plant('button', { id: 'below', textContent: 'a' });
    plant('p', { id: 'wide', textContent: 'Donaudampfschifffahrt' }, 'top: 8em; left: 40em; width: auto');
    plant('p', { id: 'over', textContent: 'Kapitän', ariaHidden: 'true' }, 'top: 8em; left: 44em; width: 3em; overflow: visible; pointer-events: none');
    plant('div', { id: 'lid' }, 'top: 12em; left: 42em; z-index: 100');
    plant('p', { id: 'lidded', textContent: 'Donaudampfschifffahrt' }, 'top: 12em; left: 40em; width: auto');
    plant('p', { id: 'sentence', textContent: sentence }, 'width: auto');
    plant('p', { id: 'made', textContent: made }, 'width: auto');
    plant('button', { id: 'named', title }, 'top: 4em; background: none');
    plant('div', {}, 'position: static; width: 200vw; height: 1px');
  }, [english.flights.none, english.quality.limits.left_out(17, 40), english.flights.search]);
  const found = (await faultsOf(page, foreign.get('de'))).join('\n');
  for (const [fault, times] of /** @type {[RegExp, number][]} */ ([[/^cut: p#cut/gm, 1], [/^cut: p#told/gm, 0], [/^covered: button#below.* by p#made/gm, 1],
    [/^English: .* in p#sentence/gm, 1], [/^English: .* in p#made/gm, 1], [/^English: title=.* of button#named/gm, 1], [/^words over words: p#wide.* and p#over/gm, 1], [/^half covered: p#lidded.* by div#lid/gm, 1], [/^half covered: p#wide/gm, 0], [/^scrolls sideways: html/gm, 1]])) {
    assert.equal(found.match(fault)?.length ?? 0, times, `${fault} in\n${found}`);
  }
});

for (const [screen, context] of Object.entries(screens)) {
  for (const [locale, language] of /** @type {const} */ ([['en-GB', 'en'], ['de-DE', 'de']])) {
    for (const colorScheme of /** @type {const} */ (['light', 'dark'])) {
      const kind = `${screen}-${language}-${colorScheme}`;
      for (const is_real of visited ? [true] : kind === kRealVisit ? [false, true] : [false]) {
        const visit = `${kind}${is_real ? '-real' : ''}`;
        const skip = options.skip || (is_real && missingBinary()) || false;
        test(`nothing is cut, covered or contradicts another on a first visit: ${visit}`, { skip, timeout: kPatience_ms }, async () => {
          const { page, photos, holdUploads } = await openVisit({ ...context, locale, colorScheme, reducedMotion: 'reduce' }, is_real);
          /** @type {string[]} */
          const faults = [];
          let steps = 0;
          const look = async (/** @type {string} */ step) => {
            await atRest(page);
            for (const fault of await faultsOf(page, foreign.get(language))) faults.push(`${step}: ${fault}`);
            steps += 1;
            if (!pictures) return;
            mkdirSync(pictures, { recursive: true });
            await page.screenshot({ path: join(pictures, `${visit}-${String(steps).padStart(2, '0')}-${step}.png`) });
          };
          await page.waitForSelector('#flights-message:not([hidden])');
          await look('empty');
          const release = await holdUploads();
          await page.setInputFiles('#files-input', photos);
          await page.waitForSelector('#upload-progress');
          await look('uploading');
          release();
          await page.waitForSelector('#job-progress', { timeout: kPatience_ms }).then(() => look('processing'), () => undefined);
          await page.waitForSelector('#report', { timeout: kPatience_ms });
          await mapIdle(page);
          await look('map');
          for (const [step, open] of views) {
            await open(page);
            await look(step);
            await closeAll(page);
          }
          await page.reload();
          await page.waitForSelector('#report');
          await assertOneStatus(page);
          await look('list');
          assert.deepEqual(faults, []);
        });
      }
    }
  }
}
