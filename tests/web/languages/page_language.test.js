// The page in German and in English: chosen by the browser, switched by hand, one language fetched; nothing cut, nothing
// without a name, and English where the words do not come.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { kPhone, openMap, openPhotoCard } from '../support/browser.js';
import { assertAccessible, options, usePages } from '../support/pages.js';
import { photoFiles } from '../support/photo_files.js';

const { setUp, setUpFlight, setUpReady } = usePages();
const german = { locale: 'de-DE' };

/** @param {any} page @returns {string[]} the languages whose words it fetches from now on */
function fetchedLanguages(page) {
  /** @type {string[]} */
  const fetched = [];
  page.on('request', (/** @type {any} */ request) => {
    const tag = new URL(request.url()).pathname.match(/^\/src\/languages\/(\w+)\//)?.[1];
    if (tag && !fetched.includes(tag)) fetched.push(tag);
  });
  return fetched;
}

/**
 * What is wider than the room it has: words that run out of their box, and controls that lie over each other.
 * @param {any} page
 * @returns {Promise<string[]>}
 */
const misfits = (page) =>
  page.evaluate(() => {
    const name = (/** @type {Element} */ element) => `${element.tagName.toLowerCase()}#${element.id}.${element.className} "${element.textContent?.trim().slice(0, 40)}"`;
    const isShown = (/** @type {Element} */ element) => element.checkVisibility() && element.getBoundingClientRect().width > 1;
    const found = [];
    if (document.documentElement.scrollWidth > innerWidth) found.push(`the page is ${document.documentElement.scrollWidth} wide`);
    const [head, last] = ['#panel-head', '#new-flight'].map((selector) => /** @type {Element} */ (document.querySelector(selector)).getBoundingClientRect());
    if (last.width > 0 && last.right > head.right - 10) found.push(`the head lacks ${last.right - head.right + 10} pixels`);
    const top = document.querySelector('dialog[open]') ?? document.body;
    const elements = [...top.querySelectorAll('button, a, h1, h2, h3, label, legend, dt, dd, p, li, summary, strong, .chip')].filter(isShown);
    for (const element of elements) {
      if (element.closest('.code-box, .maplibregl-ctrl, .overview-mark, .visually-hidden, .filmstrip, .flight-name')) continue;
      if (getComputedStyle(element).display !== 'inline' && element.scrollWidth > element.clientWidth + 1) found.push(`${name(element)}: ${element.scrollWidth} in ${element.clientWidth}`);
    }
    const controls = [...top.querySelectorAll('button, select, input:not([type=file]):not([type=range])')].filter((one) => isShown(one) && !one.closest('.flights, .maplibregl-map, .sheet-closed .panel-body, .address-row'));
    for (const [i, one] of controls.entries()) {
      const a = one.getBoundingClientRect();
      for (const other of controls.slice(i + 1)) {
        const b = other.getBoundingClientRect();
        const is_beside = one.parentElement === other.parentElement;
        if (is_beside && a.left < b.right - 1 && b.left < a.right - 1 && a.top < b.bottom - 1 && b.top < a.bottom - 1) found.push(`${name(one)} over ${name(other)}`);
      }
    }
    return found;
  });

test('a German browser gets the page in German: numbers, dates, plurals, and no English file', options, async () => {
  const { page, mock, flight } = await setUpFlight('Wiese', { has_tokens: true }, { ...german, timezoneId: 'Europe/Berlin' });
  mock.seedReady('Acker', 1);
  const fetched = fetchedLanguages(page);
  await page.reload();
  await page.waitForSelector('.flights li');
  assert.equal(await page.getAttribute('html', 'lang'), 'de');
  assert.deepEqual(fetched, ['de']);
  assert.match(await page.textContent('.flights'), /12\.05\.2026.*19 Fotos · 1,73\scm\/px/s);
  assert.equal(await page.textContent('#new-flight'), 'Neuer Flug');
  assert.equal(await page.getAttribute('#home-link', 'aria-label'), 'Skyquilt, alle Flüge');
  await openMap(page, `${mock.url}#/flights/${flight.id}`);
  await page.waitForSelector('#report');
  const report = await page.textContent('#report');
  assert.match(report, /Fläche2,43\sha/);
  assert.match(report, /Bodenauflösung1,73\scm\/px/);
  assert.match(report, /12\.05\.2026, 09:31 \(UTC\+2\)/);
  assert.match(report, /1 von 19 Fotos wurde nicht verwendet/);
  assert.match(report, /2 Fotos sind nur nach der aufgezeichneten Lage platziert/);
  assert.match(report, /1 Foto nicht verwendet/);
  assert.match((await page.textContent('#photo-notes')) ?? '', /DJI_0001\.JPG: die aufgezeichnete Position liegt 46\sm/);
  // What the server says in a sentence of its own is marked as English for who listens.
  assert.equal(await page.getAttribute('#report .warnings li', 'lang'), 'en');
  await page.click('#flight-share');
  await page.waitForSelector('#share-days');
  assert.deepEqual(await page.locator('#share-days option').allTextContents(), ['1 Tag', '7 Tage', '30 Tage', 'ein Jahr', 'bis zum Widerruf']);
  await page.keyboard.press('Escape');
  await page.click('#flight-download');
  await page.click('#export-open');
  await page.click('#export-start');
  await page.waitForSelector('#exports a');
  assert.match(await page.textContent('#exports'), /verfügbar bis \d\d\.\d\d\.\d{4}, \d\d:\d\d/);
});

test('an error of the server says in German what its code means, then its own sentence', options, async () => {
  const { page, mock, flight } = await setUpFlight('doomed Wiese', { job_ms: 800 }, german);
  flight.ready = false;
  await page.goto(`${mock.url}#/flights/${flight.id}`);
  await page.click('#start-job');
  await page.waitForSelector('#failure');
  assert.match(await page.textContent('#failure'), /Die Karte konnte nicht erstellt werden.*Verarbeitung nicht möglich\. Im Wortlaut: No photo has a GPS position\./s);
});

test('the language is switched on the page, and stays', options, async () => {
  const { page, flight } = await setUpReady('Wiese', {}, german);
  assert.deepEqual(await page.locator('#language option').allTextContents(), ['English', 'Deutsch']);
  assert.equal(await page.inputValue('#language'), 'de');
  const fetched = fetchedLanguages(page);
  await Promise.all([page.waitForEvent('load'), page.selectOption('#language', 'en')]);
  await page.waitForSelector('#report');
  assert.equal(await page.getAttribute('html', 'lang'), 'en');
  assert.match(await page.textContent('#report'), /Resolution1\.73\scm\/px/);
  assert.ok(page.url().endsWith(`#/flights/${flight.id}`), 'the same flight is open');
  await page.reload();
  await page.waitForSelector('#report');
  assert.equal(await page.inputValue('#language'), 'en');
  assert.deepEqual(fetched, ['en']);
});

test('switching while files are sent breaks no upload: the page changes when it is opened again', options, async () => {
  const { page, mock } = await setUp({}, german);
  const release = mock.holdUploads();
  await page.setInputFiles('#files-input', photoFiles(3));
  await page.waitForSelector('#upload-progress');
  await page.selectOption('#language', 'en');
  await page.waitForSelector('.note');
  assert.match(await page.textContent('.note'), /wenn Sie die Seite neu öffnen/);
  release();
  await page.waitForSelector('#report');
  assert.equal([...mock.flights.values()][0].files.size, 3);
  await page.reload();
  await page.waitForSelector('#report');
  assert.equal(await page.getAttribute('html', 'lang'), 'en');
});

test('where the words of a language cannot be had the page is English, with English numbers', options, async () => {
  const { page, mock, flight } = await setUpFlight('Wiese', {}, { ...german, errors: /./ });
  await page.route('**/src/languages/de/*.js', (/** @type {any} */ route) => route.fulfill({ status: 503, body: '' }));
  await page.goto(`${mock.url}?again#/flights/${flight.id}`);
  await page.waitForSelector('#report');
  assert.equal(await page.getAttribute('html', 'lang'), 'en');
  assert.match(await page.textContent('#report'), /Resolution1\.73\scm\/px/);
  assert.equal(await page.inputValue('#language'), 'en');
});

test('where only the words of a flight cannot be had, these are English', options, async () => {
  const { page, mock, flight } = await setUpFlight('Wiese', {}, { ...german, errors: /./ });
  await page.route('**/src/languages/de/flight.js', (/** @type {any} */ route) => route.fulfill({ status: 503, body: '' }));
  await page.goto(`${mock.url}?again#/flights/${flight.id}`);
  await page.waitForSelector('#report');
  assert.equal(await page.getAttribute('html', 'lang'), 'de');
  assert.match(await page.textContent('#report'), /Resolution1,73\scm\/px/);
});

test('a browser of another language gets English; the bare map has the language of its reader', options, async () => {
  const french = await setUp({}, { locale: 'fr-FR' });
  assert.equal(await french.page.getAttribute('html', 'lang'), 'en');
  assert.equal(await french.page.textContent('#new-flight'), 'New flight');
  const { page, mock } = await setUp({}, german);
  const fetched = fetchedLanguages(page);
  await openMap(page, `${mock.url}embed/${mock.seedReady('Wiese').id}`);
  assert.equal(await page.getAttribute('html', 'lang'), 'de');
  assert.deepEqual(fetched, ['de']);
  assert.equal(await page.getAttribute('.embed-caption', 'title'), 'In Skyquilt öffnen');
  assert.equal(await page.locator('.tool').first().getAttribute('aria-label'), 'Vergrößern');
});

for (const [screen, context] of Object.entries({ laptop: {}, phone: kPhone })) {
  test(`in German nothing is cut and axe finds no fault on a ${screen}`, options, async () => {
    const { page, mock } = await setUp({ upload_ms: 400, job_ms: 20_000, has_tokens: true }, { ...german, ...context, reducedMotion: 'reduce', errors: /422/ });
    const check = async (/** @type {string} */ where) => {
      assert.deepEqual(await misfits(page), [], where);
      await assertAccessible(page, where);
    };
    const escape = () => page.keyboard.press('Escape');
    await page.click('summary');
    await check('home without flights');
    const flight = mock.seedReady('Wiese am Bach');
    await page.reload();
    await page.waitForSelector('.overview-mark');
    await check('home');
    await openMap(page, `${mock.url}#/flights/${flight.id}`);
    await page.waitForSelector('#report');
    for (const fold of await page.locator('#report summary').all()) await fold.click();
    await check('report');
    await page.click('#flight-download');
    await check('downloads');
    await page.click('#export-open');
    await page.waitForSelector('#export-form');
    await page.selectOption('#export-crs', 'epsg');
    await check('export');
    await escape();
    await page.click('#flight-share');
    await page.click('#share-make');
    await page.waitForSelector('.shares li');
    await check('share');
    await escape();
    await page.click('#flight-qgis');
    await page.click('#qgis-dialog #links-make');
    await page.waitForSelector('#qgis-file');
    await check('QGIS');
    await escape();
    await page.click('#flight-move');
    await page.click('#place-centre');
    await page.keyboard.type('46.8');
    await page.waitForSelector('.place-fault');
    await check('placing the map');
    await escape();
    await openPhotoCard(page);
    await check('photo card');
    await page.goto(`${mock.url}#/`);
    await page.setInputFiles('#files-input', [...photoFiles(9), { ...photoFiles(1)[0], name: 'refused.JPG' }]);
    await page.waitForSelector('#upload-failures .callout');
    await check('failed upload');
    await page.click('text=Ohne diese Dateien fortfahren');
    await page.waitForSelector('#job-progress');
    await check('processing');
  });
}
