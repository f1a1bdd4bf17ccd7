// The control points of a flight as the page keeps them, without a browser: what is marked on a poor line is not lost.
import assert from 'node:assert/strict';
import { beforeEach, test } from 'node:test';
import { ControlDocument, controlOf } from '../../../web/src/control/control_document.js';
import { loadFlightStrings } from '../../../web/src/shared/flight_strings.js';
import { holdToken, token_kept } from '../../../web/src/shared/token.js';

await loadFlightStrings();
holdToken('');
Object.assign(globalThis, { addEventListener: () => {}, removeEventListener: () => {} });

/** @typedef {import('../../../web/src/control/control_document.js').ControlPoints} ControlPoints */

/** A server that keeps points as ours does; what becomes of its next answers stands in `line`. */
const server = {
  /** @type {ControlPoints} */
  kept: { reference_system: 'EPSG:4326', points: [] },
  edition: 0,
  /** @type {('away'|'lost'|'refused')[]} away: it is not asked; lost: it is, and its answer does not come; refused: for its token */
  line: [],
  /** @param {Pick<ControlPoints, 'points'>} next */
  keep({ points }) {
    const kept = (/** @type {number} */ pixel) => Number((pixel + 0.5).toFixed(3)) - 0.5;
    const heightOf = (/** @type {number|null} */ height) => (points.every((point) => point.height === 0) ? null : height);
    server.kept = { reference_system: 'EPSG:4326', points: points.map((point) => ({ ...point, height: heightOf(point.height), lon: point.x, lat: point.y, marks: point.marks.map(({ photo, x, y }) => ({ photo, x: kept(x), y: kept(y) })) })) };
    server.edition += 1;
  },
};

globalThis.fetch = async (_, { method = 'GET', headers = {}, body = '' } = {}) => {
  const fate = server.line.shift();
  if (fate === 'away') throw new TypeError('network');
  const answer = (/** @type {object} */ json, status = 200) => new Response(JSON.stringify(json), { status, headers: { ETag: `"${server.edition}"` } });
  if (fate === 'refused') return answer({ title: 'Unauthorized' }, 401);
  if (method === 'PUT') {
    if (/** @type {any} */ (headers)['If-Match'] !== `"${server.edition}"`) return answer({ title: 'Precondition Failed', detail: 'changed elsewhere' }, 412);
    server.keep(JSON.parse(String(body)));
  }
  if (fate === 'lost') throw new TypeError('network');
  return answer(server.kept);
};

const pointAt = (/** @type {string} */ name) => ({ name, x: 7, y: 46, height: null, marks: [] });
const marked = (/** @type {ControlPoints} */ { points }) => points.flatMap(({ name, marks }) => marks.map(({ photo }) => `${name} ${photo}`)).join();

beforeEach(() => {
  server.line = [];
  server.keep({ points: [pointAt('P1')] });
});

test('whoever asked for a token: the page is not loaded anew with it while points are not saved, and they are sent', async () => {
  const isLoadedAnew = () => token_kept.dispatchEvent(new Event('change', { cancelable: true }));
  const control = new ControlDocument('token');
  await control.load();
  control.mark('P1', 'A.JPG', { x: 1, y: 2 });
  server.line = ['refused'];
  await assert.rejects(control.flush());
  assert.equal(isLoadedAnew(), false);
  while (control.state !== 'saved') await new Promise(setImmediate);
  assert.equal(marked(server.kept), 'P1 A.JPG');
  assert.equal(isLoadedAnew(), true);
});

test('a mark whose answer is lost is no change by others: those after it are saved', async () => {
  const control = new ControlDocument('poor-line');
  await control.load();
  control.mark('P1', 'A.JPG', { x: 1200.123456, y: 800.0625 });
  server.line = ['lost'];
  await assert.rejects(control.flush());
  assert.equal(control.state, 'waiting');
  control.mark('P1', 'B.JPG', { x: 5, y: 6 });
  server.line = ['away'];
  await assert.rejects(control.flush());
  control.mark('P1', 'C.JPG', { x: 7, y: 8 });
  await control.flush();
  assert.equal(control.state, 'saved');
  assert.equal(marked(server.kept), 'P1 A.JPG,P1 B.JPG,P1 C.JPG');
  control.mark('P1', 'D.JPG', { x: 9, y: 9 });
  await control.flush();
  assert.equal(marked(server.kept), 'P1 A.JPG,P1 B.JPG,P1 C.JPG,P1 D.JPG', 'on top of what was saved');
});

test('an answer that is lost is known by its points also where the server takes their zeros for no heights', async () => {
  const control = new ControlDocument('zeros');
  await control.load();
  control.change({ reference_system: 'EPSG:4326', points: [7, 8, 9].map((x) => ({ ...pointAt(`P${x}`), x, height: 0 })) });
  server.line = ['lost'];
  await assert.rejects(control.flush());
  control.mark('P7', 'A.JPG', { x: 1, y: 2 });
  await control.flush();
  assert.equal(marked(server.kept), 'P7 A.JPG');
});

test('what others changed meanwhile stays, and is told', async () => {
  const control = new ControlDocument('others');
  await control.load();
  control.mark('P1', 'A.JPG', { x: 1, y: 2 });
  server.line = ['away'];
  await assert.rejects(control.flush());
  server.keep({ points: [{ ...pointAt('P1'), marks: [{ photo: 'A.JPG', x: 100, y: 2 }] }] });
  await assert.rejects(control.flush());
  assert.equal(control.state, 'failed');
  assert.equal(control.points[0].marks[0].x, 100);
  assert.equal(server.kept.points[0].marks[0].x, 100);
});

test('what is marked in a dialog while a new panel reads the points stays, but for what others changed', async () => {
  const control = controlOf('dialog');
  await control.load();
  const read = control.load();
  control.mark('P1', 'A.JPG', { x: 1, y: 2 });
  await read;
  assert.equal(marked(control), 'P1 A.JPG');
  await control.flush();
  const late = control.load();
  control.mark('P1', 'B.JPG', { x: 3, y: 4 });
  await control.flush();
  await late;
  assert.equal(marked(control), 'P1 A.JPG,P1 B.JPG');
  assert.equal(marked(server.kept), 'P1 A.JPG,P1 B.JPG');
  server.keep({ points: [pointAt('P1'), pointAt('P2')] });
  const refused = control.load();
  control.mark('P1', 'C.JPG', { x: 5, y: 6 });
  await refused;
  assert.equal(control.state, 'failed');
  assert.deepEqual(control.points.map(({ name, marks }) => `${name} ${marks.length}`), ['P1 0', 'P2 0']);
});

test('what a panel that was closed could not save is there in the next one, and is saved', async () => {
  const left = controlOf('left');
  await left.load();
  left.mark('P1', 'A.JPG', { x: 1, y: 2 });
  server.line = ['away'];
  left.close();
  while (left.state !== 'waiting') await new Promise(setImmediate);
  const opened = controlOf('left');
  let drawn = 0;
  opened.addEventListener('change', () => (drawn += 1));
  await opened.load();
  assert.equal(marked(opened), 'P1 A.JPG');
  assert.equal(drawn, 1);
  opened.mark('P1', 'B.JPG', { x: 3, y: 4 });
  await opened.flush();
  assert.equal(marked(server.kept), 'P1 A.JPG,P1 B.JPG');
  // Where all is saved, what others changed meanwhile is read.
  opened.close();
  server.keep({ points: [pointAt('P1'), pointAt('P2')] });
  const again = controlOf('left');
  await again.load();
  assert.deepEqual(again.points.map(({ name }) => name), ['P1', 'P2']);
});
