// What the page says of a finished flight in its list, its head and its report, as JSON:
//   node tests/web/support/flight_texts.js URL FLIGHT
// Ends with 77 where there is no browser.
import { launchBrowser, missingForBrowser, openPage } from './browser.js';

const [url, flight] = process.argv.slice(2);
const missing = missingForBrowser();
if (missing) {
  console.error(missing);
  process.exit(77);
}
const browser = await launchBrowser();
try {
  const { page } = await openPage(browser, url, { locale: 'en-GB' });
  const text = async (/** @type {string} */ selector) => (await page.innerText(selector)).trim();
  const row = `.flights li:has(a[href*="${flight}"])`;
  await page.waitForSelector(`${row} .chip`);
  const list = { status: await text(`${row} .chip`), facts: await text(row) };
  await page.goto(`${url}#/flights/${flight}`);
  await page.waitForSelector('#report .facts');
  const facts = await page.locator('#report .facts > div').evaluateAll((/** @type {Element[]} */ rows) =>
    Object.fromEntries(rows.map((one) => [one.querySelector('dt')?.textContent ?? '', one.querySelector('dd')?.textContent ?? ''])));
  console.log(JSON.stringify({
    list,
    head: { status: await text('.flight-facts .chip'), facts: await text('.flight-facts') },
    report: { status: (await text('#result-verdict strong')).replace(/\.$/, ''), absolute: facts['Absolute accuracy'], relative: facts['Relative accuracy'] },
  }));
} finally {
  await browser.close();
}
