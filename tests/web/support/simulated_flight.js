// A simulated flight of six photos in a folder of its own and a browser, for tests against the real server; and its map,
// made by requests.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { basename, join } from 'node:path';
import { after, before } from 'node:test';
import { launchBrowser, missingForBrowser } from './browser.js';
import { binary, findPhotos, missingBinary } from './real_server.js';

const missing = missingForBrowser() || missingBinary();
export const options = { skip: missing || false, timeout: 400_000 };

/** For the test file that calls this. @param {string[]} [arguments_] of `skyquilt simulate` @returns {{folder: string, browser: any}} once the tests run */
export function useSimulatedFlight(arguments_ = []) {
  const used = { folder: '', browser: /** @type {any} */ (null) };
  before(async () => {
    if (missing) return;
    used.folder = mkdtempSync(join(tmpdir(), 'skyquilt-flight-'));
    const made = spawnSync(binary, ['simulate', '-o', join(used.folder, 'flight'), '--photos', '6', '--size', '800x600', ...arguments_], { encoding: 'utf8' });
    assert.equal(made.status, 0, made.stderr);
    used.browser = await launchBrowser();
  });
  after(async () => {
    await used.browser?.close();
    if (used.folder) rmSync(used.folder, { recursive: true, force: true });
  });
  return used;
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
