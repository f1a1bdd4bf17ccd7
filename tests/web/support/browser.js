// Chromium for tests and screenshots, through playwright-core; watches that a page stays on its host and is silent, waits for it, reads
// the colours that it shows, and puts it into a frame of another site.
import assert from 'node:assert/strict';
import { existsSync, readFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { createRequire } from 'node:module';
import { setTimeout } from 'node:timers/promises';
import { drawNothing } from './blind_canvas.js';
import { web_root } from './mock_server.js';

export const chromium_path = process.env.SKYQUILT_CHROMIUM ?? '/usr/bin/chromium';
const require = createRequire(`${web_root}/package.json`);

/** @returns {string} why browser tests cannot run here; '' when they can */
export function missingForBrowser() {
  if (!existsSync(chromium_path)) return `no Chromium at ${chromium_path} (apt install chromium)`;
  if (!existsSync(`${web_root}/vendor/maplibre-gl.mjs`)) return 'web/vendor is empty (npm ci && npm run vendor in web/)';
  try {
    require.resolve('playwright-core');
  } catch {
    return 'web/node_modules is missing (npm ci in web/)';
  }
  return '';
}

/** @returns {string} where a package of web/node_modules has a file */
export const packageFile = (/** @type {string} */ name) => require.resolve(name);

/** What each window would load beside the page: the pages of the address bar's suggestions, dearer than ours. */
const kNotWanted = ['WebUIOmniboxPopup', 'WebUIOmniboxAimPopup'];
/** What playwright turns off: of two lists Chromium takes the last. */
const kTurnedOff = ['AvoidUnnecessaryBeforeUnloadCheckSync', 'BoundaryEventDispatchTracksNodeRemoval', 'DestroyProfileOnBrowserClose', 'GlobalMediaControls', 'HttpsUpgrades', 'MediaRouter', 'OptimizationHints', 'PaintHolding', 'RenderDocument', 'ThirdPartyStoragePartitioning', 'Translate'];

export async function launchBrowser() {
  const { chromium } = require('playwright-core');
  return chromium.launch({
    executablePath: chromium_path,
    headless: true,
    args: [
      '--no-sandbox',
      '--disable-quic',
      '--no-first-run',
      '--disable-background-networking',
      '--disable-component-update',
      '--disable-sync',
      '--enable-unsafe-swiftshader',  // for maps alone: the page itself is put together without it, at a third of the cost
      `--disable-features=${[...kTurnedOff, ...kNotWanted].join()}`,
    ],
  });
}

/**
 * Opens a page and collects what a good page never does.
 * @param {any} browser
 * @param {string} url
 * @param {{is_drawn?: boolean, [option: string]: any}} [options] of the browser context; is_drawn: false where nobody looks at maps
 */
export async function openPage(browser, url, { is_drawn = true, ...options } = {}) {
  const context = await browser.newContext({ viewport: { width: 1366, height: 768 }, ...options });
  if (!is_drawn) await context.addInitScript(drawNothing);
  const page = await context.newPage();
  page.setDefaultTimeout(60_000);  // other tests may have the processor meanwhile
  const host = new URL(url).host;
  /** @type {string[]} */
  const foreign_requests = [];
  /** @type {string[]} */
  const console_errors = [];
  let bytes = 0;
  page.on('request', (request) => {
    const target = new URL(request.url());
    if (/^https?:$/.test(target.protocol) && target.host !== host) foreign_requests.push(request.url());
  });
  page.on('response', async (response) => {
    if (response.request().method() !== 'HEAD') bytes += Number(response.headers()['content-length'] ?? 0);
  });
  page.on('console', (message) => {
    if (message.type() === 'error' || message.type() === 'warning') {
      // Chromium's own word about drawing without a graphics card, not the page's.
      if (!/GPU stall|WebGL-0x|Automatic fallback to software WebGL|GroupMarkerNotSet/.test(message.text())) console_errors.push(`${message.text()} ${message.location().url}`);
    }
  });
  page.on('pageerror', (error) => console_errors.push(error.message));
  // A route's handler may still be waiting when the test ends, and its page is gone when it goes on.
  const close = context.close.bind(context);
  context.close = async () => {
    if (!page.isClosed()) await page.unrouteAll({ behavior: 'ignoreErrors' });
    await close();
  };
  await page.goto(url);
  return { page, context, foreign_requests, console_errors, transferred: () => bytes };
}

/** Options of a page's context on a phone. */
export const kPhone = { viewport: { width: 390, height: 844 }, isMobile: true, hasTouch: true };

/** Holds what a page asks of these addresses, but for the first requests; the answer lets it through. @param {any} page @param {string|RegExp} addresses @param {number} [first] */
export async function holdRequests(page, addresses, first = 0) {
  /** @type {() => void} */
  let release = () => {};
  const gate = new Promise((resolve) => { release = () => resolve(undefined); });
  let begun = 0;
  await page.route(addresses, async (/** @type {any} */ route) => {
    if ((begun += 1) > first) await gate;
    await route.continue().catch(() => {});  // the page may be gone by then
  });
  return release;
}

/** The next answer to what a page asks there is the one of now, and comes when it is released. @param {any} page @param {string|RegExp} addresses */
export async function holdAnswer(page, addresses) {
  /** @type {() => void} */
  let release = () => {};
  const gate = new Promise((resolve) => { release = () => resolve(undefined); });
  let is_taken = false;
  let is_held = false;
  await page.route(addresses, async (/** @type {any} */ route) => {
    if (is_taken || route.request().method() !== 'GET') {
      await route.fallback();
      return;
    }
    is_taken = true;
    const json = await (await route.fetch()).json();
    is_held = true;
    await gate;
    await route.fulfill({ json }).catch(() => {});  // the page may be gone by then
  });
  return { isHeld: () => is_held, release };
}

/** @param {any} page @param {number[]} from @param {number[]} to in px of the window @param {'left'|'right'} [button] */
export async function drag(page, from, to, button = 'left') {
  await page.mouse.move(...from);
  await page.mouse.down({ button });
  await page.mouse.move(...to, { steps: 5 });
  await page.mouse.up({ button });
}

/** The card of the photo in the middle of the map, by keyboard. @param {any} page */
export async function openPhotoCard(page) {
  await page.locator('#map canvas').focus();
  await page.keyboard.press('Enter');
  await page.waitForSelector('#photo-card:not([hidden])');
}

/** Adds places to what is being measured, each where the middle of the map is. @param {any} page @param {number[][]} places */
export async function addCentres(page, places) {
  for (const place of places) {
    await page.evaluate((/** @type {any} */ center) => /** @type {any} */ (window).skyquilt.map.jumpTo({ center }), place);
    await page.click('text=Add centre');
  }
}

/** @param {any} page @param {string} [selector] waits until everything of the map is drawn */
export async function mapIdle(page, selector = '#map') {
  await page.waitForSelector(`${selector}[data-map-state="idle"]`, { timeout: 60_000 });
}

/** Goes to an address, and waits for its map. @param {any} page @param {string} address */
export async function openMap(page, address) {
  await page.goto(address);
  await mapIdle(page);
}

/** @param {any} page */
export async function reloadMap(page) {
  await page.reload();
  await mapIdle(page);
}

/** What pressing a button saves, as text. @param {any} page @param {string} button @returns {Promise<{name: string, text: string}>} */
export async function savedBy(page, button) {
  const [download] = await Promise.all([page.waitForEvent('download'), page.click(button)]);
  return { name: download.suggestedFilename(), text: readFileSync(await download.path(), 'utf8') };
}

/** What was asked of the page by now is laid out and painted. @param {any} page */
export const twoFrames = (page) => page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve))));

/** Nothing of the page is on its way from one look to another. @param {any} page */
export async function atRest(page) {
  await twoFrames(page);
  await page.evaluate(() => Promise.allSettled(document.getAnimations().filter((one) => one.effect?.getComputedTiming().iterations !== Infinity).map((one) => one.finished)));
}

/** @param {() => boolean|Promise<boolean>} is_so waits for it, at most half a minute @param {string} [failure] */
export async function until(is_so, failure) {
  for (let i = 0; i < 300 && !(await is_so()); i += 1) await setTimeout(100);
  assert.ok(await is_so(), failure);
}

/**
 * The colours of a screenshot, by which a map is told from an empty canvas.
 * @param {any} page
 * @param {{x: number, y: number, width: number, height: number}} clip
 * @returns {Promise<{colours: number, share: (r: number, g: number, b: number, tolerance: number) => number,
 *                    at: (x: number, y: number) => number[]}>}
 */
export async function screenshotPixels(page, clip) {
  const png = await page.screenshot({ clip });
  // The browser itself decodes the picture: no image library is needed here.
  const { width, data } = await page.evaluate(async (/** @type {string} */ base64) => {
    const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
    const bitmap = await createImageBitmap(new Blob([bytes], { type: 'image/png' }));
    const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
    const context = /** @type {OffscreenCanvasRenderingContext2D} */ (canvas.getContext('2d'));
    context.drawImage(bitmap, 0, 0);
    const image = context.getImageData(0, 0, bitmap.width, bitmap.height).data;
    let text = '';
    for (let i = 0; i < image.length; i += 8192) text += String.fromCharCode(...image.subarray(i, i + 8192));
    return { width: bitmap.width, data: btoa(text) };
  }, png.toString('base64'));
  const rgba = Buffer.from(data, 'base64');
  const seen = new Set();
  for (let i = 0; i < rgba.length; i += 4) seen.add((rgba[i] >> 3) * 1024 + (rgba[i + 1] >> 3) * 32 + (rgba[i + 2] >> 3));
  return {
    colours: seen.size,
    share(r, g, b, tolerance) {
      let near = 0;
      for (let i = 0; i < rgba.length; i += 4) {
        if (Math.abs(rgba[i] - r) + Math.abs(rgba[i + 1] - g) + Math.abs(rgba[i + 2] - b) <= tolerance) near += 1;
      }
      return near / (rgba.length / 4);
    },
    at: (x, y) => [...rgba.subarray((y * width + x) * 4, (y * width + x) * 4 + 3)],
  };
}

/** A page of another site: by the name localhost, which is no site of 127.0.0.1. @param {string} markup in its body */
export async function startOuterPage(markup) {
  const server = createServer((_, response) => {
    response.writeHead(200, { 'Content-Type': 'text/html; charset=utf-8' });
    response.end(`<!DOCTYPE html><html lang="en"><head><title>Outer</title><link rel="icon" href="data:,"></head><body><h1>Outer</h1>${markup}<p style="height:3000px"></p></body></html>`);
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', () => resolve(undefined)));
  return {
    url: `http://localhost:${/** @type {any} */ (server.address()).port}/`,
    close: () => {
      server.closeAllConnections();
      return new Promise((resolve) => server.close(() => resolve(undefined)));
    },
  };
}

/** @param {any} page @returns {Promise<any>} what its frame shows */
export async function frameOn(page) {
  await page.locator('iframe').scrollIntoViewIfNeeded();
  return (await page.waitForSelector('iframe')).contentFrame();
}
