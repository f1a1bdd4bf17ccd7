// What the page's photo viewer marks, against what the server says of the place.
import assert from 'node:assert/strict';

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
