// Steps of a user who marks control points on the page, for the tests against the real server.
import assert from 'node:assert/strict';
import { moveMap } from '../support/real_flights.js';

/** Opens the panel, and imports a list that is pasted. */
export async function importList(page, text, system = '') {
  if (!(await page.locator('#control-import-open').isVisible())) await page.click('#control > summary');
  await page.click('#control-import-open');
  await page.fill('#control-text', text);
  if (system) await page.fill('#control-system', system);
  await page.click('#control-import-go');
  await page.waitForSelector('#control-import', { state: 'detached' });
  await saved(page);
}

export const saved = (page) => page.waitForSelector('#control-state:has-text("All changes saved")');

/** Opens a point's photos. */
export async function openPoint(page, name) {
  await page.click(`#control-points [aria-label="Mark ${name} in photos"]`);
  await page.waitForSelector('#marking');
}

/** Shows a photo of the strip. @returns {Promise<boolean>} whether it is offered */
export async function choosePhoto(page, photo) {
  const frame = page.locator(`#marking .frame[title^="${photo}"]`);
  if ((await frame.count()) === 0) return false;
  await frame.click();
  await page.waitForSelector(`#marking .viewer-image[alt="${photo}"]:not([hidden])`, { timeout: 60_000 });
  return true;
}

/** Clicks a pixel of the photo that is shown, zoomed in on as a user would. */
export async function clickPixel(page, { x, y }) {
  await page.locator('#marking-view').focus();
  await page.keyboard.press('0');
  const box = await page.locator('#marking .viewer-image').boundingBox();
  const width = await page.evaluate(() => /** @type {HTMLImageElement} */ (document.querySelector('#marking .viewer-image')).naturalWidth);
  const scale = box.width / width;
  await page.mouse.move(box.x + (x + 0.5) * scale, box.y + (y + 0.5) * scale);
  for (let i = 0; i < 8; i += 1) await page.mouse.wheel(0, -100);
  const near = await page.locator('#marking .viewer-image').boundingBox();
  const zoomed = near.width / width;
  assert.ok(zoomed > scale, 'the wheel zooms in');
  await page.mouse.click(near.x + (x + 0.5) * zoomed, near.y + (y + 0.5) * zoomed);
  await page.waitForSelector('#marking-mark:not([hidden])');
}

/** Marks a point in photos. @param {{photo: string, x: number, y: number}[]} marks */
export async function markPoint(page, name, marks) {
  await openPoint(page, name);
  for (const mark of marks) {
    assert.ok(await choosePhoto(page, mark.photo), `${mark.photo} is offered for ${name}`);
    await clickPixel(page, mark);
  }
  await page.keyboard.press('Escape');
  await page.waitForSelector('#marking', { state: 'detached' });
}

/** Applies the points, and waits for the map that comes of it. */
export async function applyPoints(page, url, id) {
  await saved(page);
  return moveMap(page, url, id, '#control-apply');
}
