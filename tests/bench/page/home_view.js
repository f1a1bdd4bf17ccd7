// How soon the home view of many flights is there over a slow line, in Chromium against the mock server:
//   node tests/bench/page/home_view.js [FLIGHTS] [ROUNDS]
// The line has 4 Mbit/s and 100 ms; the cache is empty. What the mock's pictures weigh is no measure: the server's are
// of 512 pixels and come after the list.
import { launchBrowser, openPage } from '../../web/support/browser.js';
import { seedMany } from '../../web/support/mock_flight.js';
import { startMockServer } from '../../web/support/mock_server.js';

const count = Number(process.argv[2] ?? 300);
const rounds = Number(process.argv[3] ?? 5);
const median = (/** @type {number[]} */ values) => values.sort((a, b) => a - b)[Math.floor(values.length / 2)];

const mock = await startMockServer({ page_limit: 500 });
seedMany(mock, count);
const browser = await launchBrowser();
try {
  const listed_s = [];
  const pictured_s = [];
  let requests = 0;
  let bytes = 0;
  for (let i = 0; i < rounds; i += 1) {
    const { page, context } = await openPage(browser, 'about:blank');
    const line = await context.newCDPSession(page);
    await line.send('Network.enable');
    await line.send('Network.emulateNetworkConditions', { offline: false, latency: 100, downloadThroughput: 500_000, uploadThroughput: 500_000 });
    requests = 0;
    bytes = 0;
    page.on('request', () => (requests += 1));
    line.on('Network.loadingFinished', ({ encodedDataLength }) => (bytes += encodedDataLength));
    const began = performance.now();
    await page.goto(mock.url, { waitUntil: 'commit' });
    await page.waitForFunction((wanted) => document.querySelectorAll('.flights li').length === wanted && document.querySelector('.overview-mark'), count);
    listed_s.push((performance.now() - began) / 1000);
    await page.waitForFunction(() => {
      const pictures = [...document.querySelectorAll('.thumb-image')];
      return pictures.length > 3 && pictures.every((image) => /** @type {HTMLImageElement} */ (image).complete);
    });
    pictured_s.push((performance.now() - began) / 1000);
    await page.waitForLoadState('networkidle');
    await context.close();
  }
  console.log(`${count} flights: list and marks after ${median(listed_s).toFixed(2)} s, pictures after ${median(pictured_s).toFixed(2)} s (median of ${rounds}), ${requests} requests, ${(bytes / 1000).toFixed(0)} kB`);
} finally {
  await browser.close();
  await mock.close();
}
