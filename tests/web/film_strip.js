// One first visit as a stranger makes it, from dropping photos to a link that somebody else opens: a picture after every step
// in one sheet, and the clicks that it took. Fails where it takes more than nine, or the link does not open the map.
//   node tests/web/film_strip.js [SHEET.jpg]
import { spawnSync } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { launchBrowser, mapIdle, openPage } from './support/browser.js';
import { binary, findPhotos, realPhotos, startServer } from './support/real_server.js';

const kClicksAllowed = 9;
const kPatience_ms = 600_000;
const out = process.argv[2] ?? join(dirname(fileURLToPath(import.meta.url)), 'gallery', 'first_visit.jpg');
const work = mkdtempSync(join(tmpdir(), 'skyquilt-visit-'));
const data = join(work, 'data');

/** @returns {string[]} */
function photosToDrop() {
  const real = realPhotos('brighton_beach');
  if (real.length > 0) return real;
  const made = spawnSync(binary, ['simulate', '-o', join(work, 'flight'), '--photos', '12', '--size', '1600x1200', '--no-world'], { encoding: 'utf8' });
  if (made.status !== 0) throw new Error(made.stderr);
  return findPhotos(join(work, 'flight'));
}

const token = spawnSync(binary, ['token', 'add', 'visitor', '--data', data, '--scope', 'upload'], { encoding: 'utf8' }).stdout.match(/sq_\S+/)?.[0] ?? '';
const server = await startServer(data);
const browser = await launchBrowser();
/** @type {{text: string, picture: string}[]} */
const frames = [];
let clicks = 0;

/** @param {any} page @param {string} text */
async function frame(page, text) {
  await page.waitForTimeout(500);
  frames.push({ text: `${frames.length + 1}. ${text}`, picture: (await page.screenshot({ type: 'jpeg', quality: 80 })).toString('base64') });
}

/** @param {any} page @param {string} selector */
async function click(page, selector) {
  clicks += 1;
  await page.click(selector);
}

try {
  const { page, context } = await openPage(browser, `${server.url}?token=${token}`, { permissions: ['clipboard-read', 'clipboard-write'] });
  await page.waitForSelector('#files-input', { state: 'attached' });
  await frame(page, 'The page of a new server');
  // Photos dragged onto the page: no click.
  await page.setInputFiles('#files-input', photosToDrop());
  await page.waitForFunction(() => Number(document.getElementById('preview-note')?.textContent?.match(/\d+/)?.[0]) >= 4, null, { timeout: kPatience_ms });
  await mapIdle(page);
  await frame(page, 'Photos dropped: a preview while they travel');
  await page.waitForSelector('#report', { timeout: kPatience_ms });
  await mapIdle(page);
  await frame(page, 'The map, made by itself');
  const map = await page.locator('#map').boundingBox();
  clicks += 1;
  await page.mouse.click(map.x + map.width * 0.62, map.y + map.height * 0.5);
  await page.waitForSelector('#photo-card:not([hidden])');
  await frame(page, `Click ${clicks}: the photos of a point`);
  await click(page, '#photo-open');
  await page.waitForSelector('.viewer-mark:not([hidden])');
  await frame(page, `Click ${clicks}: the photo itself`);
  await page.keyboard.press('Escape');
  await click(page, '#tool-distance');
  for (const [x, y] of [[0.45, 0.45], [0.65, 0.6]]) {
    clicks += 1;
    await page.mouse.click(map.x + map.width * x, map.y + map.height * y);
  }
  await frame(page, `Clicks 3 to ${clicks}: a distance`);
  await click(page, '#flight-share');
  await page.waitForSelector('#share-make');
  await frame(page, `Click ${clicks}: share`);
  await click(page, '#share-make');
  await page.waitForSelector('#share-made input');
  const link = await page.inputValue('#share-made input');
  await click(page, '#share-made button');
  await frame(page, `Clicks ${clicks - 1} and ${clicks}: a link, copied`);
  const guests = await browser.newContext({ viewport: { width: 1366, height: 768 } });
  const guest = await guests.newPage();
  await guest.goto(link);
  await guest.waitForSelector('#report', { timeout: kPatience_ms });
  await mapIdle(guest);
  await frame(guest, 'What the other one sees');
  await guests.close();
  const sheet = await (await browser.newContext({ viewport: { width: 1500, height: 900 } })).newPage();
  await sheet.setContent(`<style>body{margin:12px;font:15px sans-serif;display:grid;grid-template-columns:repeat(3,1fr);gap:12px}
    figure{margin:0}img{width:100%;border:1px solid #999}figcaption{padding:4px 0}</style>
    ${frames.map(({ text, picture }) => `<figure><img src="data:image/jpeg;base64,${picture}"><figcaption>${text}</figcaption></figure>`).join('')}`);
  await sheet.waitForTimeout(500);
  writeFileSync(out, await sheet.screenshot({ type: 'jpeg', quality: 75, fullPage: true }));
  await context.close();
  console.log(`${clicks} clicks, ${frames.length} pictures in ${out}`);
  if (clicks > kClicksAllowed) throw new Error(`a first visit takes ${clicks} clicks, more than ${kClicksAllowed}`);
} finally {
  await browser.close();
  await server.stop();
  rmSync(work, { recursive: true, force: true });
}
