// The poster of the real server lies on the map that comes after it, pixel upon pixel.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { holdRequests, mapIdle, screenshotPixels, twoFrames } from '../support/browser.js';
import { options, stitchedFlight, useSimulatedFlight } from '../support/real_flights.js';

const used = useSimulatedFlight();

/** How far the second picture lies beside the first, px: where they differ least. */
function shiftBetween(first, second, width, height) {
  const kMaxShift = 4;
  const light = (/** @type {any} */ picture, /** @type {number} */ x, /** @type {number} */ y) => picture.at(x, y).reduce((/** @type {number} */ sum, /** @type {number} */ c) => sum + c, 0);
  let best = { x: 0, y: 0, difference: Infinity };
  for (let dy = -kMaxShift; dy <= kMaxShift; dy += 1) {
    for (let dx = -kMaxShift; dx <= kMaxShift; dx += 1) {
      let difference = 0;
      for (let y = kMaxShift; y < height - kMaxShift; y += 3) {
        for (let x = kMaxShift; x < width - kMaxShift; x += 3) difference += Math.abs(light(first, x, y) - light(second, x + dx, y + dy));
      }
      if (difference < best.difference) best = { x: dx, y: dy, difference };
    }
  }
  return best;
}

test('the poster lies on the map to a pixel, on the page and in the bare map', options, async () => {
  const server = await used.serve('data');
  const address = await stitchedFlight(server.url, used.folder);
  const id = address.split('/').pop();
  const picture = await fetch(`${address}/thumbnail.webp?size=1024`);
  assert.ok(Number(picture.headers.get('content-length')) < 130_000);
  for (const path of [`#/flights/${id}`, `embed/${id}`]) {
    const { page, console_errors } = await used.open('about:blank');
    const release = await holdRequests(page, /\/tiles\/[^/]+\/\d+\//);
    await page.goto(server.url + path, { waitUntil: 'commit' });
    await page.waitForSelector('.poster:not([hidden])');
    await page.waitForFunction(() => /** @type {any} */ (window).skyquilt?.map.getLayer('mosaic-1'));
    await twoFrames(page);
    const box = await page.locator('.poster').boundingBox();
    const clip = { x: Math.round(box.x), y: Math.round(box.y), width: Math.min(560, Math.floor(box.width)), height: Math.min(420, Math.floor(box.height)) };
    const before = await screenshotPixels(page, clip);
    assert.ok(before.colours > 50, 'a picture, not a patch');
    release();
    await mapIdle(page);
    await page.waitForFunction(() => !document.querySelector('.poster'));
    const found = shiftBetween(before, await screenshotPixels(page, clip), clip.width, clip.height);
    assert.ok(Math.abs(found.x) <= 1 && Math.abs(found.y) <= 1, `${path}: ${JSON.stringify(found)}`);
    assert.deepEqual(console_errors, []);
  }
});
