// How heavy and how quick the page is, in Chromium against the real server with a map of six simulated photos, or of those in
// a folder; on this machine, and over a line of 4 Mbit/s and 100 ms:
//   node tests/bench/page/first_view.js [ROUNDS] [OUT] [PHOTOS]
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { spawnSync } from 'node:child_process';
import { tmpdir } from 'node:os';
import { basename, join } from 'node:path';
import { launchBrowser, openPage } from '../../web/support/browser.js';
import { binary, findPhotos, startServer } from '../../web/support/real_server.js';

/** In the page: the picture of the whole map that stands in for it is decoded, in its place and in sight. */
const hasPoster = () => {
  const poster = /** @type {HTMLImageElement|null} */ (document.querySelector('.poster'));
  const box = poster?.getBoundingClientRect();
  return Boolean(poster && box && poster.complete && poster.naturalWidth > 0 && !poster.hidden && box.width > 0 && getComputedStyle(poster).opacity === '1');
};

/** In the page: the few coarse tiles that show all of the map have come, or all tiles. */
const isSeen = () => {
  const map = /** @type {any} */ (window).skyquilt?.map;
  const coarse = map?.getStyle()?.layers.find((/** @type {{id: string}} */ { id }) => id.endsWith('-coarse'))?.id;
  return coarse ? map.isSourceLoaded(coarse) : document.getElementById('map')?.dataset.mapState === 'idle';
};

const rounds = Number(process.argv[2] ?? 5);
const work = mkdtempSync(join(tmpdir(), 'skyquilt-page-'));
const median = (/** @type {number[]} */ values) => values.sort((a, b) => a - b)[Math.floor(values.length / 2)];

const given = process.argv[4];
if (!given) spawnSync(binary, ['simulate', '-o', join(work, 'flight'), '--photos', '6', '--size', '800x600', '--no-world']);
const server = await startServer(join(work, 'data'));
const browser = await launchBrowser();
const json = { 'Content-Type': 'application/json' };
try {
  const flights = `${server.url}api/v1/flights`;
  const { id } = await (await fetch(flights, { method: 'POST', headers: json, body: '{"name":"bench"}' })).json();
  for (const path of findPhotos(given ?? join(work, 'flight'))) {
    await fetch(`${flights}/${id}/files/${basename(path)}`, { method: 'PUT', body: readFileSync(path) });
  }
  await fetch(`${flights}/${id}/jobs`, { method: 'POST', headers: json, body: '{}' });
  while ((await (await fetch(`${flights}/${id}`)).json()).state !== 'ready') await new Promise((resolve) => setTimeout(resolve, 300));
  const table = [];
  for (const [line, conditions] of /** @type {const} */ ([['this machine', null], ['4 Mbit/s and 100 ms', { offline: false, latency: 100, downloadThroughput: 500_000, uploadThroughput: 500_000 }]])) {
    for (const [name, hash, ready] of [['list of flights', '', '.flights li'], ['map of a flight, its poster', `#/flights/${id}`, hasPoster], ['map of a flight, its coarse tiles', `#/flights/${id}`, isSeen], ['map of a flight, all tiles', `#/flights/${id}`, '#map[data-map-state="idle"]'], ['bare map, its poster', `embed/${id}`, hasPoster], ['bare map, its coarse tiles', `embed/${id}`, isSeen]]) {
      const bytes = [];
      const times = [];
      for (let i = 0; i < rounds; i += 1) {
        const { page, context, foreign_requests, console_errors } = await openPage(browser, 'about:blank');
        const session = await context.newCDPSession(page);
        await session.send('Network.enable');
        if (conditions) await session.send('Network.emulateNetworkConditions', conditions);
        let came = 0;
        session.on('Network.loadingFinished', ({ encodedDataLength }) => (came += encodedDataLength));
        const began = performance.now();
        await page.goto(server.url + hash, { waitUntil: 'commit' });
        if (typeof ready === 'string') await page.waitForSelector(ready);
        else await page.waitForFunction(ready);
        await page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve))));  // painted
        times.push(performance.now() - began);
        await page.waitForLoadState('networkidle');
        bytes.push(came);
        const foreign = foreign_requests.filter((url) => !url.startsWith(server.url));
        if (foreign.length > 0) throw new Error(`asked elsewhere: ${foreign}`);
        if (console_errors.length > 0) throw new Error(`the console said: ${console_errors}`);
        await context.close();
      }
      table.push(`${line}: ${name}: ${(median(bytes) / 1000).toFixed(0)} kB transferred, drawn after ${(median(times) / 1000).toFixed(2)} s (median of ${rounds}, empty cache)`);
    }
  }
  console.log(table.join('\n'));
  if (process.argv[3]) writeFileSync(process.argv[3], `${table.join('\n')}\n`);
} finally {
  await browser.close();
  await server.stop();
  rmSync(work, { recursive: true, force: true });
}
