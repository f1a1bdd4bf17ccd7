// What the tests of the page share: Chromium, the page of a mock server, and what must hold wherever a test ends.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after, afterEach, before } from 'node:test';
import { launchBrowser, mapIdle, missingForBrowser, openPage, packageFile } from './browser.js';
import { startMockServer } from './mock_server.js';

const missing = missingForBrowser();
export const options = { skip: missing || false, timeout: 120_000 };

/** One browser for the test file that calls this; setUp opens a page of its own, and cleanUp is undone with it. */
export function usePages() {
  let browser;
  /** @type {(() => Promise<void>)[]} */
  let cleanups = [];
  before(async () => {
    if (!missing) browser = await launchBrowser();
  });
  after(() => browser?.close());
  afterEach(async () => {
    for (const clean of cleanups.reverse()) await clean();
    cleanups = [];
  });

  /** @param {object} [server_options] @param {object} [context_options] */
  async function setUp(server_options = {}, context_options = {}) {
    const mock = await startMockServer({ job_ms: 1500, ...server_options });
    cleanups.push(() => mock.close());
    const opened = await openPage(browser, mock.url, context_options);
    cleanups.push(() => opened.context.close());
    return { mock, ...opened };
  }
  return { setUp, cleanUp: (/** @type {() => Promise<void>} */ clean) => cleanups.push(clean) };
}

/** A flight whose map is there, opened. @param {{page: any, mock: any}} opened @param {string} name @param {number} [photos] */
export async function openReady({ page, mock }, name, photos) {
  const flight = mock.seedReady(name, photos);
  await page.goto(`${mock.url}#/flights/${flight.id}`);
  await mapIdle(page);
  return flight;
}

export async function assertQuiet(opened, expected_errors = []) {
  assert.deepEqual(opened.foreign_requests, []);
  assert.deepEqual(opened.console_errors.filter((text) => !expected_errors.some((pattern) => pattern.test(text))), []);
}

export async function assertAccessible(page, where) {
  // A colour on its way to another has the contrast of neither.
  await page.evaluate(() => Promise.allSettled(document.getAnimations().filter((one) => one.effect?.getComputedTiming().iterations !== Infinity).map((one) => one.finished)));
  if (!(await page.evaluate(() => 'axe' in window))) await page.evaluate(readFileSync(packageFile('axe-core/axe.min.js'), 'utf8'));
  const { violations } = await page.evaluate(() => /** @type {any} */ (window).axe.run(document, { resultTypes: ['violations'], rules: { 'target-size': { enabled: true } } }));
  const found = violations.map((v) => `${v.id}: ${v.nodes.map((n) => n.target.join(' ')).join(', ')} (${v.nodes[0].failureSummary})`);
  assert.deepEqual(found, [], `axe finds faults in the ${where}`);
}
