// Renews the gallery: every state of the page, on laptop, phone and 4K screens, light and dark, against the real server
// and real photos where they are at hand (SKYQUILT_DATA or ../shared/data), else simulated ones.
//   node tests/web/gallery.js [FOLDER] [ONLY-NAMES-CONTAINING,...]
import { spawnSync } from 'node:child_process';
import { mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { basename, dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { holdRequests, kPhone, launchBrowser, mapIdle, openMap, openPage, openPhotoCard } from './support/browser.js';
import { binary, findPhotos, realPhotos, startServer } from './support/real_server.js';

const out = process.argv[2] ?? join(dirname(fileURLToPath(import.meta.url)), 'gallery');
const only = (process.argv[3] ?? '').split(',');
const isWanted = (/** @type {string} */ name) => only.some((part) => name.includes(part));
/** Is any picture of it wanted? @param {string} state */
const isStateWanted = (state) => only.some((part) => state.includes(part.split('-')[0]));
const screens = {
  laptop: { viewport: { width: 1366, height: 768 } },
  phone: { ...kPhone, deviceScaleFactor: 2 },
  '4k': { viewport: { width: 3840, height: 2160 } },
};
const kPatience_ms = 600_000;

const work = mkdtempSync(join(tmpdir(), 'skyquilt-gallery-'));

/** @param {string} set @param {number} photos @returns {string[]} */
function photosOf(set, photos) {
  const real = realPhotos(set);
  if (real.length > 0) return real;
  return simulated(set, ['--photos', String(photos), '--size', '1600x1200']);
}

/** @param {string} name @param {string[]} words */
function simulated(name, words) {
  const folder = join(work, name);
  const made = spawnSync(binary, ['simulate', '-o', folder, '--no-world', '--noise', 'xmp', ...words], { encoding: 'utf8' });
  if (made.status !== 0) throw new Error(made.stderr);
  return findPhotos(folder);
}

/** A flight by the API, without the page. */
async function makeFlight(url, name, photos, options = {}, headers = {}) {
  const post = (path, value) => fetch(`${url}${path}`, { method: 'POST', headers: { 'Content-Type': 'application/json', ...headers }, body: JSON.stringify(value) });
  const { id } = await (await post('api/v1/flights', { name })).json();
  for (const path of photos) {
    await fetch(`${url}api/v1/flights/${id}/files/${encodeURIComponent(basename(path))}`, { method: 'PUT', body: readFileSync(path), headers });
  }
  await post(`api/v1/flights/${id}/jobs`, { options });
  for (;;) {
    const flight = await (await fetch(`${url}api/v1/flights/${id}`, { headers })).json();
    if (flight.job.finished_at) return flight;
    await new Promise((resolve) => setTimeout(resolve, 500));
  }
}

/** @param {any} page @param {any} flight */
async function openFlight(page, flight) {
  await openMap(page, `${new URL('/', page.url()).href}#/flights/${flight.id}`);
}

/** Chooses the photos on the page; from the ninth on their uploads wait until released. */
async function dropHeld(page, photos) {
  const release = await holdRequests(page, '**/api/v1/uploads', 8);
  const text = join(work, 'notes.docx');
  writeFileSync(text, 'x');
  await page.setInputFiles('#files-input', [...photos, text]);
  return release;
}

/** @type {Record<string, (page: any, made: any) => Promise<void>>} */
const states = {
  async home(page) {
    await page.waitForSelector('.flights li');
    await page.waitForTimeout(1500);
  },
  async map(page, { beach }) {
    await openFlight(page, beach);
  },
  async photo(page, { beach }) {
    await openFlight(page, beach);
    await openPhotoCard(page);
    await page.waitForTimeout(800);
    await mapIdle(page);
  },
  async viewer(page, made) {
    await states.photo(page, made);
    await page.click('#photo-open');
    await page.waitForSelector('.viewer-mark:not([hidden])');
    await page.waitForTimeout(800);
  },
  async options(page, { beach }) {
    await openFlight(page, beach);
    await page.click('#processing-details summary');
    await page.click('#run-again');
    await page.click('.option-more summary');
  },
  async layers(page, { beach }) {
    await openFlight(page, beach);
    await page.click('#tool-layers');
    await page.check('#show-path');
    await page.selectOption('#colour-by', 'error');
    await page.waitForTimeout(500);
  },
  async measure(page, { beach }) {
    await openFlight(page, beach);
    await page.click('#tool-area');
    const box = await page.locator('#map').boundingBox();
    for (const [x, y] of [[0.42, 0.58], [0.6, 0.55], [0.62, 0.7], [0.46, 0.75]]) await page.mouse.click(box.x + box.width * x, box.y + box.height * y);
    await page.waitForTimeout(400);
  },
  async place(page, { beach }) {
    await openFlight(page, beach);
    await page.click('#flight-move');
    await page.waitForSelector('#place-card:not([hidden])');
    await mapIdle(page);
    const [west, south, east, north] = beach.bounds;
    const box = await page.locator('#map').boundingBox();
    for (const [i, [x, y]] of [[0.35, 0.35], [0.7, 0.6]].entries()) {
      const place = [west + x * (east - west), south + y * (north - south)];
      const spot = await page.evaluate((/** @type {number[]} */ p) => /** @type {any} */ (window).skyquilt.map.project(p), place);
      await page.mouse.click(box.x + spot.x, box.y + spot.y);
      await page.fill(`#place-is-${i + 1}`, `${(place[1] + 0.00004).toFixed(7)}, ${(place[0] + 0.00003).toFixed(7)}`);
      await page.keyboard.press('Enter');
    }
    await mapIdle(page);
  },
  async compare(page, { beach, by_pose }) {
    await openMap(page, `${new URL('/', page.url()).href}#/flights/${beach.id}/compare/${by_pose.id}`);
    await mapIdle(page, '#map-above');
  },
  async report(page, { beach }) {
    await openFlight(page, beach);
    await page.evaluate(() => document.querySelector('.coverage')?.closest('figure')?.scrollIntoView());
    await page.waitForTimeout(400);
  },
  async uploading(page, { photos }) {
    await dropHeld(page, photos);
    await page.waitForFunction(() => Number(document.getElementById('preview-note')?.textContent?.match(/\d+/)?.[0]) >= 8, null, { timeout: kPatience_ms });
    await mapIdle(page);
  },
  async processing(page, { photos }) {
    (await dropHeld(page, photos))();
    await page.waitForFunction(() => Number(/** @type {HTMLProgressElement|null} */ (document.getElementById('job-progress'))?.value) > 0.2, null, { timeout: kPatience_ms });
    await mapIdle(page);
  },
  async error(page, { failed }) {
    await page.evaluate((/** @type {string} */ id) => (location.hash = `#/flights/${id}`), failed.id);
    await page.waitForSelector('#failure');
    await page.waitForTimeout(300);
  },
};
// Other flights, each only made where its picture is asked for.
/** @type {Record<string, () => string[]>} */
const flights_of = {
  seneca: () => photosOf('seneca_40', 24),
  caliterra: () => photosOf('caliterra_75', 24),
  hundreds: () => simulated('hundreds', ['--photos', '300', '--size', '640x480']),
};
const kManyFlights = 36;

// The other language, the dark scheme and the large screen are told by a few.
const languages = (/** @type {string} */ state, /** @type {string} */ screen, /** @type {string} */ scheme) =>
  scheme === 'light' && screen !== '4k' && ['home', 'map', 'options'].includes(state) ? ['en', 'de'] : ['en'];
const shows = (/** @type {string} */ state, /** @type {string} */ screen, /** @type {string} */ scheme) => {
  if (state in flights_of || state === 'many') return scheme === 'light' && screen !== '4k';
  if (screen === '4k') return scheme === 'light' && ['home', 'map', 'report'].includes(state);
  return scheme === 'light' || ['empty', 'home', 'map', 'uploading', 'report', 'error'].includes(state);
};

/** @param {any} browser @param {string} url @param {string} state @param {(page: any) => Promise<void>} reach */
async function shoot(browser, url, state, reach, after = async () => {}) {
  for (const [screen, options] of Object.entries(screens)) {
    for (const colorScheme of ['light', 'dark']) {
      for (const locale of languages(state, screen, colorScheme)) {
        const name = `${state}-${screen}-${colorScheme}${locale === 'en' ? '' : `-${locale}`}`;
        if (!shows(state, screen, colorScheme) || !isWanted(name)) continue;
        const { page, context, console_errors } = await openPage(browser, url, { ...options, colorScheme, locale, reducedMotion: 'reduce' });
        page.on('dialog', (/** @type {any} */ dialog) => dialog.accept());
        await reach(page);
        await page.screenshot({ path: join(out, `${name}.jpg`), quality: 70, type: 'jpeg' });
        await context.close();
        await after();
        console.log(name, ...console_errors);
      }
    }
  }
}

/** What who has a link to one flight of a server with tokens sees. */
async function shootGuest(browser, photos) {
  const data = join(work, 'guarded');
  const added = spawnSync(binary, ['token', 'add', 'owner', '--data', data, '--scope', 'upload'], { encoding: 'utf8' });
  const owner = { Authorization: `Bearer ${/** @type {RegExpMatchArray} */ (added.stdout.match(/sq_\S+/))[0]}` };
  const guarded = await startServer(data);
  try {
    const flight = await makeFlight(guarded.url, 'Brighton Beach', photos, {}, owner);
    const shared = await fetch(`${guarded.url}api/v1/flights/${flight.id}/shares`, { method: 'POST', headers: { 'Content-Type': 'application/json', ...owner }, body: '{}' });
    const { page: address } = await shared.json();
    await shoot(browser, new URL(address, guarded.url).href, 'guest', (page) => mapIdle(page));
  } finally {
    await guarded.stop();
  }
}

/** The map without the page, for the README. */
async function shootMapAlone(browser, url, flight) {
  const { page, context } = await openPage(browser, url, { viewport: { width: 1500, height: 900 } });
  await openFlight(page, flight);
  const box = await page.locator('#map').boundingBox();
  await page.mouse.move(box.x + 20, box.y + 20);
  await mapIdle(page);
  await page.addStyleTag({ content: '.tools, .coordinates { visibility: hidden }' });
  await page.screenshot({ path: join(out, 'brighton_beach.jpg'), quality: 80, type: 'jpeg', clip: box });
  await context.close();
}

mkdirSync(out, { recursive: true });
const photos = photosOf('brighton_beach', 18);
const browser = await launchBrowser();
const server = await startServer(join(work, 'data'));
try {
  await shoot(browser, server.url, 'empty', (page) => page.waitForSelector('#flights-message:not([hidden])'));
  const failed = await makeFlight(server.url, 'Notes instead of photos', [fileURLToPath(import.meta.url)]);
  const by_pose = await makeFlight(server.url, 'Brighton Beach, by recorded poses alone', photos, { method: 'imu' });
  await makeFlight(server.url, 'Seneca', flights_of.seneca());
  const beach = await makeFlight(server.url, 'Brighton Beach', photos);
  const kept = new Set([failed.id, by_pose.id, beach.id]);
  for (const [state, reach] of Object.entries(states)) {
    await shoot(browser, server.url, state, (page) => reach(page, { photos, beach, by_pose, failed }), async () => {
      if (state !== 'uploading' && state !== 'processing') return;
      const { flights } = await (await fetch(`${server.url}api/v1/flights`)).json();
      for (const { id, state: now } of flights) {
        if (!kept.has(id) && now !== 'ready') await fetch(`${server.url}api/v1/flights/${id}`, { method: 'DELETE' });
      }
    });
  }
  for (const [state, photos_of] of Object.entries(flights_of)) {
    if (!isStateWanted(state)) continue;
    const flight = await makeFlight(server.url, state, photos_of());
    await shoot(browser, server.url, state, (page) => openFlight(page, flight));
  }
  if (isStateWanted('many')) {
    const sites = ['North field', 'Orchard', 'Quarry', 'River bank', 'Solar park', 'Vineyard'];
    for (let i = 0; i < kManyFlights; i += 1) {
      const made = simulated(`many-${i}`, ['--photos', '8', '--size', '480x360', '--seed', String(i + 1)]);
      const moved = spawnSync('exiftool', ['-n', '-q', '-overwrite_original', `-GPSLatitude+=${0.07 * (i % 6)}`, `-GPSLongitude+=${0.09 * Math.floor(i / 6)}`, ...made]);
      if (moved.status !== 0) throw new Error('exiftool (libimage-exiftool-perl) is needed');
      await makeFlight(server.url, `${sites[i % sites.length]} ${1 + Math.floor(i / sites.length)}`, made);
    }
    await shoot(browser, server.url, 'many', states.home);
  }
  if (isWanted('brighton_beach')) await shootMapAlone(browser, server.url, beach);
  if (isStateWanted('guest')) await shootGuest(browser, photos);
} finally {
  await browser.close();
  await server.stop();
  rmSync(work, { recursive: true, force: true });
}
