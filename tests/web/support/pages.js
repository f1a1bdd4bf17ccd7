// What the tests of the page share: Chromium, the page of a mock server, and what must hold wherever a test ends.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after, afterEach } from 'node:test';
import { atRest, launchBrowser, mapIdle, missingForBrowser, openPage, packageFile } from './browser.js';
import { startMockServer } from './mock_server.js';

const missing = missingForBrowser();
export const options = { skip: missing || false, timeout: 120_000 };

/** One for all files that are run in one process. @type {ReturnType<typeof launchBrowser>|null} */
let browser = null;
/** @type {(() => Promise<void>)[]} */
let cleanups = [];
/** What each page of the case complains of or asks of others. @type {(() => string[])[]} */
let noises = [];
after(async () => {
  // A Chromium that does not end, or whatever else is open yet, holds up nobody: how the cases went is told by now.
  setTimeout(() => process.exit(), 60_000).unref();
  await (await browser)?.close();
});
afterEach(async () => {
  const noise = noises.flatMap((ofPage) => ofPage());
  noises = [];
  for (const clean of cleanups.reverse()) await clean();
  cleanups = [];
  assert.deepEqual(noise, [], 'a page asks nobody but its server and has no complaints');
});

/**
 * A server and a page of a case's own; both go with it, and the page is quiet to its end.
 * @param {object} [server_options]
 * @param {object} [context_options] is_drawn: true where a case looks at the pixels of a map; errors: those that it provokes
 * @param {(mock: any) => string} [view] of the page, by its hash; the list unless said
 */
async function setUp(server_options = {}, context_options = {}, view = () => '') {
  const mock = await startMockServer({ job_ms: 1500, ...server_options });
  cleanups.push(() => mock.close());
  return { mock, ...(await openAt(mock.url + view(mock), context_options)) };
}

/** A page of another server. @param {string} url @param {{errors?: RegExp, [option: string]: any}} [context_options] */
async function openAt(url, { errors, ...context_options } = {}) {
  browser ??= launchBrowser();
  const opened = await openPage(await browser, url, { is_drawn: false, ...context_options });
  cleanups.push(() => opened.context.close());
  noises.push(() => [...opened.foreign_requests, ...opened.console_errors.filter((text) => !errors?.test(text))]);
  return opened;
}

/** setUp with a flight whose map is there, which no view shows yet. @param {string} name @param {object} [server_options] @param {object} [context_options] */
async function setUpFlight(name, server_options, context_options) {
  const opened = await setUp(server_options, context_options);
  return { flight: opened.mock.seedReady(name), ...opened };
}

/** The same with that flight opened by its address: no list is loaded first. @param {object} [server_options] @param {object} [context_options] */
async function setUpReady(name, server_options, context_options) {
  let flight;
  const opened = await setUp(server_options, context_options, (mock) => `#/flights/${(flight = mock.seedReady(name)).id}`);
  await mapIdle(opened.page);
  return { flight, ...opened };
}

/** setUp, setUpFlight, setUpReady and openAt open a page; cleanUp is told what is undone with it. */
export const usePages = () => ({ setUp, setUpFlight, setUpReady, openAt, cleanUp: (/** @type {() => Promise<void>} */ clean) => cleanups.push(clean) });

/** A flight whose map is there, opened. @param {{page: any, mock: any}} opened @param {string} name @param {number} [photos] */
export async function openReady({ page, mock }, name, photos) {
  const flight = mock.seedReady(name, photos);
  await page.goto(`${mock.url}#/flights/${flight.id}`);
  await mapIdle(page);
  return flight;
}

/** What the page has asked for by now has come to whoever counts it: to show that something was not asked. @param {any} page */
export const allAsked = (page) => page.evaluate(async () => void (await fetch('/favicon.svg')));

/** A minute later the page's time stands still, of which there is a clock; page.clock.runFor() lets some pass. @param {any} page */
export async function stopClock(page) {
  await page.clock.pauseAt(await page.evaluate(() => Date.now() + 60_000));
}

export async function assertAccessible(page, where) {
  // A colour on its way to another has the contrast of neither.
  await atRest(page);
  if (!(await page.evaluate(() => 'axe' in window))) await page.evaluate(readFileSync(packageFile('axe-core/axe.min.js'), 'utf8'));
  const { violations } = await page.evaluate(() => /** @type {any} */ (window).axe.run(document, { resultTypes: ['violations'], rules: { 'target-size': { enabled: true } } }));
  const found = violations.map((v) => `${v.id}: ${v.nodes.map((n) => n.target.join(' ')).join(', ')} (${v.nodes[0].failureSummary})`);
  assert.deepEqual(found, [], `axe finds faults in the ${where}`);
}
