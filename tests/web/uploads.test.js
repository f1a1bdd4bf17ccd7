// An upload on a poor line, without a browser: what becomes of its map.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { loadFlightStrings } from '../../web/src/shared/flight_strings.js';
import { holdToken } from '../../web/src/shared/token.js';

await loadFlightStrings();
holdToken('');
Object.assign(globalThis, { addEventListener: () => {}, document: { getElementById: () => ({ textContent: '' }) } });
const { UploadSession } = await import('../../web/src/upload/uploads.js');

test('where the answer to the beginning of a map is lost, asking again begins none but that; the next one is another', async (t) => {
  t.mock.timers.enable({ apis: ['setTimeout'] });
  /** @type {Map<string, string>} jobs that were begun, by key */
  const begun = new Map();
  let is_lost = true;
  globalThis.fetch = async (_, { method = 'GET', headers = {} } = {}) => {
    if (method === 'GET') return new Response('{"files":[]}');
    const key = /** @type {any} */ (headers)['Idempotency-Key'];
    if (!begun.has(key)) begun.set(key, `j${begun.size + 1}`);
    if (is_lost) throw new TypeError('network');
    return new Response(JSON.stringify({ id: begun.get(key) }));
  };
  const session = new UploadSession('f');
  session.queue.send = async () => {};
  const sent = (/** @type {string} */ name) => session.add({ chosen: [{ name, file: new File(['x'], name) }], ignored: [], folder: '' });
  const isBegun = () => new Promise((resolve) => session.addEventListener('job', resolve, { once: true }));
  let is_done = isBegun();
  await sent('a.csv');
  while (session.trouble === '') await new Promise(setImmediate);
  is_lost = false;
  t.mock.timers.tick(1000);
  await is_done;
  assert.deepEqual([session.job?.id, begun.size], ['j1', 1]);
  is_done = isBegun();
  await sent('b.csv');
  await is_done;
  assert.deepEqual([session.job?.id, begun.size], ['j2', 2]);
});
