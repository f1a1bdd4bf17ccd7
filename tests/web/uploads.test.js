// An upload without a browser: what is dropped, and what becomes of files and map on a poor line.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { made } from './support/fake_page.js';
import { loadFlightStrings } from '../../web/src/shared/flight_strings.js';
import { holdToken, token_kept } from '../../web/src/shared/token.js';
import { selectFiles } from '../../web/src/upload/drop_files.js';
import { filesOfDrop, stoppedUploadOf } from '../../web/src/upload/drop_zone.js';

await loadFlightStrings();
holdToken('');
/** @type {Map<string, string>} */
const kept = new Map();
const localStorage = { get length() { return kept.size; }, key: (/** @type {number} */ i) => [...kept.keys()][i], getItem: (/** @type {string} */ key) => kept.get(key) ?? null, setItem: (/** @type {string} */ key, /** @type {string} */ text) => void kept.set(key, text), removeItem: (/** @type {string} */ key) => void kept.delete(key) };
Object.defineProperty(globalThis, 'localStorage', { value: localStorage, configurable: true });

/** @typedef {{status: number, headers?: Record<string, string>}} Answer */
/** What the server says to the parts of files that it is sent; 0: the line breaks. */
const line = { /** @type {Answer[]} */ answers: [], /** @type {string[]} */ asked: [] };
class FakeRequest {
  upload = {};
  /** @type {Answer} */
  #answer = { status: 0 };
  open(/** @type {string} */ method, /** @type {string} */ address) {
    line.asked.push(`${method} ${address.split('/').pop()}`);
  }
  setRequestHeader() {}
  #is_aborted = false;
  abort() {
    this.#is_aborted = true;
  }
  get status() {
    return this.#answer.status;
  }
  responseText = '';
  getResponseHeader(/** @type {string} */ name) {
    return this.#answer.headers?.[name] ?? null;
  }
  send() {
    this.#answer = line.answers.shift() ?? { status: 0 };
    setImmediate(() => this.#is_aborted || /** @type {any} */ (this)[this.status ? 'onload' : 'onerror']({}));
  }
}
Object.assign(globalThis, {
  XMLHttpRequest: FakeRequest,
  window: { setTimeout, localStorage, XMLHttpRequest: FakeRequest, Blob },
});
const { sendFile } = await import('../../web/src/upload/send_file.js');
const { UploadSession } = await import('../../web/src/upload/uploads.js');
const { UploadQueue } = await import('../../web/src/upload/upload_queue.js');

const chosen = (/** @type {string} */ name) => ({ chosen: [{ name, file: new File(['x'], name) }], ignored: [], folder: '' });
const isBegun = (/** @type {InstanceType<typeof UploadSession>} */ session) => new Promise((resolve) => session.addEventListener('job', resolve, { once: true }));

test('photos of phones and raw files are called so, with what to do', async () => {
  const { chosen, ignored } = await selectFiles(['IMG_0001.HEIC', 'DSC_0001.nef', 'letter.pdf'].map((path) => ({ path, file: new File(['x'], path) })));
  assert.deepEqual(chosen, []);
  assert.deepEqual(ignored.map(({ name, reason }) => [name, /as JPEG/.test(reason)]), [['DSC_0001.nef', true], ['IMG_0001.HEIC', true], ['letter.pdf', false]]);
});

test('of a card that is dropped what cannot be read is named, and the system\'s own folders are not', async () => {
  const no = (/** @type {any} */ _, /** @type {(error: Error) => void} */ reject) => reject(new DOMException('refused', 'NotReadableError'));
  const fileAt = (/** @type {string} */ fullPath, read = (/** @type {any} */ take) => take(new File([Uint8Array.of(0xff, 0xd8, 0xff)], 'a.jpg'))) => ({ isFile: true, fullPath, file: read });
  const folderAt = (/** @type {string} */ fullPath, /** @type {any[]|null} */ inner) => {
    const parts = [inner, []];
    return { isFile: false, fullPath, createReader: () => ({ readEntries: inner ? (/** @type {any} */ take) => take(parts.shift()) : no }) };
  };
  const card = folderAt('/E', [folderAt('/E/System Volume Information', null), folderAt('/E/DCIM', [fileAt('/E/DCIM/a.jpg'), fileAt('/E/DCIM/b.jpg', no)]), folderAt('/E/private', null)]);
  const transfer = { items: [{ kind: 'file', webkitGetAsEntry: () => card, getAsFile: () => null }] };
  const { chosen, ignored, folder } = await selectFiles(await filesOfDrop(/** @type {any} */ (transfer)));
  assert.deepEqual([chosen.map(({ name }) => name), ignored.map(({ name }) => name), folder], [['a.jpg'], ['E/DCIM/b.jpg', 'E/private/'], 'E']);
  assert.ok(ignored.every(({ reason }) => /cannot be read/.test(reason)));
});

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
  let is_done = isBegun(session);
  await session.add(chosen('a.csv'));
  while (session.trouble === '') await new Promise(setImmediate);
  is_lost = false;
  t.mock.timers.tick(1000);
  await is_done;
  assert.deepEqual([session.job?.id, begun.size], ['j1', 1]);
  is_done = isBegun(session);
  await session.add(chosen('b.csv'));
  await is_done;
  assert.deepEqual([session.job?.id, begun.size], ['j2', 2]);
});

test('what was sent of a file stays where the server does not say how much that is, as with a token that has ended', async () => {
  const file = new File([new Uint8Array(600_000)], 'a.jpg');
  const send = () => sendFile('f', 'a.jpg', file, () => {}, new AbortController().signal).then(() => 204, (error) => error.status);
  line.answers = [{ status: 201, headers: { Location: '/api/v1/uploads/u1' } }, { status: 0 }];
  assert.equal(await send(), 0);
  for (const status of [401, 429, 502, 503]) {
    line.answers = [{ status }];
    assert.equal(await send(), status);
  }
  line.answers = [{ status: 200, headers: { 'Upload-Offset': '590000', 'Upload-Length': '600000' } }, { status: 204, headers: { 'Upload-Offset': '600000' } }];
  assert.equal(await send(), 204);
  assert.deepEqual(line.asked, ['POST uploads', 'PATCH u1', ...Array(5).fill('HEAD u1'), 'PATCH u1']);
  // Of one that is gone all is sent.
  line.answers = [{ status: 201, headers: { Location: '/api/v1/uploads/u2' } }, { status: 0 }];
  await send();
  line.answers = [{ status: 404 }, { status: 201, headers: { Location: '/api/v1/uploads/u3' } }, { status: 204, headers: { 'Upload-Offset': '600000' } }];
  assert.equal(await send(), 204);
});

test('a token that ends during an upload fails no file: with the next one it goes on', async () => {
  let is_refused = false;
  globalThis.fetch = async (_, { method = 'GET' } = {}) => new Response(method === 'GET' ? '{"files":[]}' : '{"id":"j"}', { status: is_refused ? 401 : 200 });
  line.answers = [{ status: 401 }];
  const session = new UploadSession('f');
  const is_done = isBegun(session);
  await session.add(chosen('a.csv'));
  while (!session.queue.picture.retry) await new Promise(setImmediate);
  assert.match(session.queue.picture.retry.reason, /401/);
  line.answers = [{ status: 201, headers: { Location: '/api/v1/uploads/u4', 'Upload-Offset': '1' } }];
  is_refused = true;
  token_kept.dispatchEvent(new Event('change', { cancelable: true }));
  while (session.trouble === '') await new Promise(setImmediate);
  assert.deepEqual([session.queue.picture.done, session.queue.picture.failed], [1, 0]);
  is_refused = false;
  await is_done;
  assert.equal(session.job?.id, 'j');
});

test('of a flight that was deleted elsewhere during an upload it is said once, and its files wait to be taken back', async () => {
  globalThis.fetch = async (address) => (String(address).endsWith('/files') ? new Response('{"files":[]}') : new Response('', { status: 404 }));
  line.answers = Array(8).fill({ status: 404 });
  const session = new UploadSession('f');
  const is_stopped = isBegun(session);
  await session.add({ chosen: Array.from({ length: 8 }, (_, i) => chosen(`${i}.jpg`).chosen[0]), ignored: [], folder: '' });
  await is_stopped;
  for (let turn = 0; turn < 20; turn += 1) await new Promise(setImmediate);
  const notes = made.filter(({ attributes }) => attributes.class === 'note note-error');
  for (const note of notes) note.dispatchEvent(new Event('pointerenter'));  // it does not go away meanwhile
  assert.equal(notes.length, 1);
  assert.deepEqual([session.queue.picture.failed, session.queue.picture.state, stoppedUploadOf('f')], [0, 'paused', session]);
});

test('a list that was edited is sent under a name of its own, and told; one that is there is not sent again', async () => {
  const stored = new Map([['geo.txt', 'old']]);
  globalThis.fetch = async (address, { method = 'GET' } = {}) => {
    const name = String(address).split('/files/')[1];
    if (method === 'DELETE') stored.delete(name);
    if (name) return new Response(stored.get(name));
    return new Response(JSON.stringify(method === 'GET' ? { files: [...stored].map(([name, { length }]) => ({ name, bytes: length })) } : { id: 'j' }));
  };
  const session = new UploadSession('f');
  const notes = () => made.filter(({ attributes }) => attributes.class === 'note');
  const before = notes().length;
  const drop = async (/** @type {string} */ text) => {
    line.asked = [];
    line.answers = [{ status: 201, headers: { Location: '/api/v1/uploads/u9', 'Upload-Offset': String(text.length) } }];
    const is_done = isBegun(session);
    await session.add({ chosen: [{ name: 'geo.txt', file: new File([text], 'geo.txt') }], ignored: [], folder: '' });
    await is_done;
    for (const note of notes()) note.dispatchEvent(new Event('pointerenter'));
    const { name } = session.queue.items[session.queue.items.length - 1];
    if (line.asked.length > 0) stored.set(name, text);
    return [name, line.asked.length, notes().length - before];
  };
  assert.deepEqual(await drop('old'), ['geo.txt', 0, 0]);
  assert.deepEqual(await drop('new'), ['geo(2).txt', 1, 1], 'as long as the old one');
  assert.deepEqual(await drop('new'), ['geo(2).txt', 0, 2]);
  assert.deepEqual(await drop('longer'), ['geo(3).txt', 1, 3]);
  made.filter(({ attributes }) => attributes.class === 'note-action').at(-1)?.dispatchEvent(new Event('click'));
  while (stored.has('geo.txt')) await new Promise(setImmediate);
  assert.deepEqual([...stored.keys()], ['geo(2).txt', 'geo(3).txt']);
});

test('no file is begun before it is known what the flight has', async () => {
  /** @type {string[]} */
  const sent = [];
  const queue = new UploadQueue([], async ({ name }) => void sent.push(name), { may_differ: (name) => name === 'b.csv' });
  queue.start();
  assert.equal(queue.picture.state, 'finished');
  queue.hold();
  queue.add([{ name: 'a.jpg', file: new Blob(['x']) }, { name: 'b.csv', file: new Blob(['x']) }]);
  assert.deepEqual([sent, queue.picture.state], [[], 'running']);
  queue.skipStored(new Map([['a.jpg', 1], ['b.csv', 1]]));
  queue.start();
  assert.deepEqual(sent, ['b.csv']);
});
