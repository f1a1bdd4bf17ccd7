// How heavy and how quick the page is, in Chromium against the real server with a map of six simulated photos:
//   node tests/bench/page/first_view.js [ROUNDS] [OUT]
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { spawnSync } from 'node:child_process';
import { tmpdir } from 'node:os';
import { basename, join } from 'node:path';
import { launchBrowser, openPage } from '../../web/support/browser.js';
import { binary, findPhotos, startServer } from '../../web/support/real_server.js';

const rounds = Number(process.argv[2] ?? 5);
const work = mkdtempSync(join(tmpdir(), 'skyquilt-page-'));
const median = (/** @type {number[]} */ values) => values.sort((a, b) => a - b)[Math.floor(values.length / 2)];

spawnSync(binary, ['simulate', '-o', join(work, 'flight'), '--photos', '6', '--size', '800x600', '--no-world']);
const server = await startServer(join(work, 'data'));
const browser = await launchBrowser();
const json = { 'Content-Type': 'application/json' };
try {
  const flights = `${server.url}api/v1/flights`;
  const { id } = await (await fetch(flights, { method: 'POST', headers: json, body: '{"name":"bench"}' })).json();
  for (const path of findPhotos(join(work, 'flight'))) {
    await fetch(`${flights}/${id}/files/${basename(path)}`, { method: 'PUT', body: readFileSync(path) });
  }
  await fetch(`${flights}/${id}/jobs`, { method: 'POST', headers: json, body: '{}' });
  while ((await (await fetch(`${flights}/${id}`)).json()).state !== 'ready') await new Promise((resolve) => setTimeout(resolve, 300));
  const table = [];
  for (const [name, hash, ready] of [['list of flights', '', '.flights li'], ['map of a flight', `#/flights/${id}`, '#map[data-map-state="idle"]']]) {
    const bytes = [];
    const times = [];
    for (let i = 0; i < rounds; i += 1) {
      const began = performance.now();
      const { page, context, transferred, foreign_requests } = await openPage(browser, server.url + hash);
      await page.waitForSelector(ready);
      times.push(performance.now() - began);
      await page.waitForLoadState('networkidle');
      bytes.push(transferred());
      if (foreign_requests.length > 0) throw new Error(`asked elsewhere: ${foreign_requests}`);
      await context.close();
    }
    table.push(`${name}: ${(median(bytes) / 1000).toFixed(0)} kB transferred, drawn after ${(median(times) / 1000).toFixed(2)} s (median of ${rounds}, empty cache)`);
  }
  console.log(table.join('\n'));
  if (process.argv[3]) writeFileSync(process.argv[3], `${table.join('\n')}\n`);
} finally {
  await browser.close();
  await server.stop();
  rmSync(work, { recursive: true, force: true });
}
