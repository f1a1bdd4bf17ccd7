// What the tests against the real server share: a folder and a browser for the file, servers and pages that go with each case,
// simulated flights, and maps of them made on the page or by requests.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { basename, join } from 'node:path';
import { after, afterEach, before } from 'node:test';
import { launchBrowser, mapIdle, missingForBrowser, openPage } from './browser.js';
import { binary, findPhotos, missingBinary, startServer } from './real_server.js';

const missing_here = missingForBrowser() || missingBinary();
/** For node:test. @param {string} [missing] what these cases want beside a browser and the program @param {number} [timeout] */
export const optionsOf = (missing = '', timeout = 400_000) => ({ skip: missing_here || missing || false, timeout });
export const options = optionsOf();

/** Runs the program, which must succeed; what it said. @param {string[]} words */
export function run(...words) {
  const done = spawnSync(binary, words, { encoding: 'utf8' });
  assert.equal(done.status, 0, done.stderr);
  return done.stdout;
}

/** A new token of a data folder. @param {string} data @param {string} scope @returns {string} */
export const addToken = (data, scope) => /** @type {RegExpMatchArray} */ (run('token', 'add', scope, '--data', data, '--scope', scope).match(/sq_\S+/))[0];

/** Takes from photos what they recorded of their places. @param {string[]} photos */
export function stripPlaces(photos) {
  const stripped = spawnSync('exiftool', ['-q', '-overwrite_original', '-XMP:all=', '-GPS:all=', ...photos], { encoding: 'utf8' });
  assert.equal(stripped.status, 0, stripped.stderr);
}
export const missing_exiftool = spawnSync('exiftool', ['-ver']).error ? 'no exiftool (apt install libimage-exiftool-perl)' : '';

/** For the test file that calls this; what it answers is there once the tests run. @param {string} [missing] as of optionsOf */
export function useRealServer(missing = '') {
  /** @type {any[]} */
  let contexts = [];
  /** @type {any[]} */
  let servers = [];
  const used = {
    folder: '',
    browser: /** @type {any} */ (null),
    /** A server over a folder of this name; it ends well with the case, unless the case ends it. @param {string} name @param {string} [listen] @param {string[]} [words] */
    async serve(name, listen, words) {
      const server = await startServer(join(used.folder, name), listen, words);
      servers.push(server);
      const stop = (/** @type {string} */ signal) => {
        servers = servers.filter((one) => one !== server);
        return server.stop(signal);
      };
      return { url: server.url, stop };
    },
    /** openPage, until the case ends. @param {string} url @param {object} [page_options] */
    async open(url, page_options) {
      const opened = await openPage(used.browser, url, page_options);
      contexts.push(opened.context);
      return opened;
    },
    /** Both. @param {string} name @param {string[]} [words] */
    async openServer(name, words) {
      const server = await used.serve(name, '127.0.0.1:0', words);
      return { server, ...(await used.open(server.url)) };
    },
    /** @param {string} name @param {number} photos @param {string} size @param {string[]} words of `skyquilt simulate` @returns {{photos: string[], truth: any}} */
    simulate(name, photos, size, ...words) {
      run('simulate', '-o', join(used.folder, name), '--photos', String(photos), '--size', size, ...words);
      return { photos: findPhotos(join(used.folder, name)), truth: JSON.parse(readFileSync(join(used.folder, name, 'truth', 'poses.json'), 'utf8')) };
    },
  };
  before(async () => {
    if (missing_here || missing) return;
    used.folder = mkdtempSync(join(tmpdir(), 'skyquilt-real-'));
    used.browser = await launchBrowser();
  });
  afterEach(async () => {
    const [opened, running] = [contexts, servers];
    contexts = [];
    servers = [];
    const closed = await Promise.allSettled(opened.map((context) => context.close()));
    const ended = await Promise.allSettled(running.map((server) => server.stop()));
    assert.deepEqual(ended.map(({ value, reason }) => value ?? reason), running.map(() => 0), 'servers end well');
    assert.deepEqual(closed.filter(({ status }) => status === 'rejected'), []);
  }, { timeout: 60_000 });
  after(async () => {
    await used.browser?.close();
    if (used.folder) rmSync(used.folder, { recursive: true, force: true });
  });
  return used;
}

/** The same with a flight of six photos in its folder. @param {string[]} [words] of `skyquilt simulate` */
export function useSimulatedFlight(words = []) {
  const used = useRealServer();
  before(() => {
    if (!missing_here) used.simulate('flight', 6, '800x600', ...words);
  });
  return used;
}

/** What the API has below an address. @param {string} url of the server @param {string} path */
export const get = async (url, path) => (await fetch(`${url}api/v1/${path}`)).json();

/** Uploads the photos on the page and waits for their map. @param {any} page @param {string} url @param {string[]} photos @returns {Promise<string>} the flight's id */
export async function makeMap(page, url, photos) {
  await page.goto(url);
  await page.setInputFiles('#files-input', photos);
  await page.waitForSelector('#report', { timeout: 300_000 });
  await mapIdle(page);
  return /** @type {RegExpMatchArray} */ (page.url().match(/flights\/(\w+)/))[1];
}

/** Presses what moves the map, and waits for the one that comes of it. @param {any} page @param {string} url @param {string} id @param {string} button @returns {Promise<any>} the flight */
export async function moveMap(page, url, id, button) {
  const { revision } = await get(url, `flights/${id}`);
  await page.click(button);
  await page.waitForSelector('#job-heading:has-text("Moving the map")');
  await page.waitForFunction((/** @type {number} */ before) => document.getElementById('failure') || Object.values(/** @type {any} */ (window).skyquilt.map.getStyle().sources)
    .some((source) => source.tiles?.some((/** @type {string} */ tile) => Number(tile.match(/rev=(\d+)/)?.[1]) > before)), revision, { timeout: 400_000 });
  const flight = await get(url, `flights/${id}`);
  assert.equal(flight.job.state, 'successful', flight.job.error?.message);
  await mapIdle(page);
  return flight;
}

/**
 * Waits until no job of a flight is under way, and its map is there.
 * @param {string} address of the flight
 * @param {Record<string, string>} headers
 */
export async function mapReady(address, headers) {
  for (;;) {
    const flight = await (await fetch(address, { headers })).json();
    if (flight.state === 'ready' && !['accepted', 'running'].includes(flight.job?.state)) return;
    await new Promise((resolve) => setTimeout(resolve, 300));
  }
}

/**
 * @param {string} url of the server
 * @param {string} folder of useSimulatedFlight
 * @param {Record<string, string>} [headers]
 * @returns {Promise<string>} the flight's address in the API
 */
export async function stitchedFlight(url, folder, headers = {}) {
  const post = (/** @type {string} */ address, /** @type {object} */ body) =>
    fetch(address, { method: 'POST', headers: { ...headers, 'Content-Type': 'application/json' }, body: JSON.stringify(body) });
  const { id } = await (await post(`${url}api/v1/flights`, { name: 'Simulated' })).json();
  const address = `${url}api/v1/flights/${id}`;
  for (const path of findPhotos(join(folder, 'flight'))) await fetch(`${address}/files/${basename(path)}`, { method: 'PUT', headers, body: readFileSync(path) });
  await post(`${address}/jobs`, {});
  await mapReady(address, headers);
  return address;
}

/** The photo that the card opens is the server's first for the map's centre, marked at the server's pixel. */
export async function assertOpensAtItsPixel(page, url, id) {
  const { lng, lat } = await page.evaluate(() => /** @type {any} */ (window).skyquilt.map.getCenter());
  const { photos } = await (await fetch(`${url}api/v1/flights/${id}/at?lon=${lng}&lat=${lat}`)).json();
  assert.equal(await page.textContent('#photo-card .card-title'), photos[0].name);
  // And back: that pixel shows the place.
  const ground = await (await fetch(`${url}api/v1/flights/${id}/photos/${photos[0].name}/ground?x=${photos[0].x}&y=${photos[0].y}`)).json();
  assert.ok(Math.hypot((ground.lon - lng) * Math.cos((lat * Math.PI) / 180), ground.lat - lat) * 111_000 < 0.05, JSON.stringify({ ground, lng, lat }));
  await page.click('#photo-open');
  await page.waitForSelector('.viewer-mark:not([hidden])');
  const marked = await page.evaluate(() => {
    const box = (/** @type {string} */ selector) => /** @type {Element} */ (document.querySelector(selector)).getBoundingClientRect();
    const [image, mark] = [box('.viewer-image'), box('.viewer-mark')];
    const width = /** @type {HTMLImageElement} */ (document.querySelector('.viewer-image')).naturalWidth;
    const scale = image.width / width;
    return { x: (mark.x + mark.width / 2 - image.x) / scale - 0.5, y: (mark.y + mark.height / 2 - image.y) / scale - 0.5 };
  });
  assert.ok(Math.hypot(marked.x - photos[0].x, marked.y - photos[0].y) < 1, JSON.stringify({ marked, first: photos[0] }));
  await page.keyboard.press('Escape');
  await page.waitForSelector('#photo-viewer', { state: 'detached' });
}
