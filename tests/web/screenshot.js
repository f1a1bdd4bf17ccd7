// Saves a picture of the page:
//   node tests/web/screenshot.js URL OUT.png [--size 1366x768] [--flight ID] [--zoom Z] [--centre LON,LAT]
//        [--scheme light|dark] [--phone] [--map-only] [--no-photos] [--wait SELECTOR|MILLISECONDS] [--no-map]
// --no-photos hides footprints and cameras; --map-only saves the map without the panel.
// With --flight (or a URL that opens a flight) it waits until the map is drawn, unless --no-map.
import { launchBrowser, mapIdle, missingForBrowser, openPage } from './support/browser.js';

const [url, out, ...rest] = process.argv.slice(2);
if (!url || !out) {
  console.error('usage: node screenshot.js URL OUT.png [--size WxH] [--flight ID] [--zoom Z] [--centre LON,LAT] [--scheme light|dark] [--phone] [--map-only] [--no-photos] [--wait X] [--no-map]');
  process.exit(2);
}
const missing = missingForBrowser();
if (missing) {
  console.error(missing);
  process.exit(1);
}
const has = (/** @type {string} */ name) => rest.includes(name);
const option = (/** @type {string} */ name) => (has(name) ? rest[rest.indexOf(name) + 1] : undefined);
const [width, height] = (option('--size') ?? (has('--phone') ? '390x844' : '1366x768')).split('x').map(Number);
const target = new URL(url);
const flight = option('--flight');
if (flight) target.hash = `#/flights/${flight}`;

const browser = await launchBrowser();
try {
  const { page, foreign_requests, console_errors } = await openPage(browser, target.href, {
    viewport: { width, height },
    colorScheme: option('--scheme') ?? 'light',
    deviceScaleFactor: has('--phone') ? 2 : 1,
    hasTouch: has('--phone'),
    isMobile: has('--phone'),
  });
  const wants_map = !has('--no-map') && target.hash.startsWith('#/flights/');
  if (wants_map) {
    await mapIdle(page);
    if (has('--no-photos')) {
      await page.evaluate(() => {
        const { map } = /** @type {any} */ (window).skyquilt;
        for (const id of ['photos-fill', 'photos-line', 'cameras']) if (map.getLayer(id)) map.setLayoutProperty(id, 'visibility', 'none');
      });
      await page.waitForTimeout(300);
    }
    const zoom = option('--zoom');
    const centre = option('--centre')?.split(',').map(Number);
    if (zoom || centre) {
      await page.evaluate(
        ([z, c]) => {
          const { map } = /** @type {any} */ (window).skyquilt;
          map.jumpTo({ ...(z ? { zoom: Number(z) } : {}), ...(c ? { center: c } : {}) });
        },
        /** @type {[string|undefined, number[]|undefined]} */ ([zoom, centre]),
      );
      await page.waitForTimeout(200);
      await mapIdle(page);
    }
  } else {
    await page.waitForLoadState('networkidle');
  }
  const wait = option('--wait');
  if (wait && /^\d+$/.test(wait)) await page.waitForTimeout(Number(wait));
  else if (wait) await page.waitForSelector(wait);
  const clip = has('--map-only') ? await page.locator('#map').boundingBox() : undefined;
  await page.screenshot({ path: out, clip: clip ?? undefined });
  for (const line of [...foreign_requests.map((u) => `foreign request: ${u}`), ...console_errors.map((e) => `console: ${e}`)]) console.error(line);
} finally {
  await browser.close();
}
