// The notes of a flight as the page keeps them, without a browser: an answer that comes late is not taken for a newer one, and
// what another tab could not save yet stays.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { NoteDocument } from '../../../web/src/notes/note_document.js';
import { noteOf } from '../../../web/src/notes/note_shape.js';
import { loadFlightStrings } from '../../../web/src/shared/flight_strings.js';
import { holdToken } from '../../../web/src/shared/token.js';

await loadFlightStrings();
holdToken('');
/** @type {Map<string, string>} */
const kept = new Map();
const storage = { getItem: (/** @type {string} */ key) => kept.get(key) ?? null, setItem: (/** @type {string} */ key, /** @type {string} */ text) => void kept.set(key, text), removeItem: (/** @type {string} */ key) => void kept.delete(key) };
Object.defineProperty(globalThis, 'localStorage', { value: storage, configurable: true });
Object.assign(globalThis, { addEventListener: () => {}, removeEventListener: () => {} });

/** A server that answers when a test says so. */
function heldServer() {
  /** @type {{method: string, if_match: string, answer: (features: object[], etag: string) => void}[]} */
  const asked = [];
  globalThis.fetch = (_, { method = 'GET', headers = {} } = {}) => new Promise((resolve) => asked.push({
    method,
    if_match: /** @type {any} */ (headers)['If-Match'] ?? '',
    answer: (features, ETag) => resolve(new Response(JSON.stringify({ type: 'FeatureCollection', features }), { headers: { ETag } })),
  }));
  return asked;
}

const pointAt = (/** @type {string} */ id) => noteOf(id, '', { type: 'Point', coordinates: [7.4391, 46.9512] }, id);

test('a look at the server that is overtaken by saving takes nothing back', async () => {
  const asked = heldServer();
  const [well, gate, tree] = ['well', 'gate', 'tree'].map(pointAt);
  const notes = new NoteDocument('f', true);
  const loaded = notes.load();
  asked[0].answer([well], '"1"');
  await loaded;
  const looked = notes.refresh();
  notes.set(gate);
  const saved = notes.flush();
  assert.deepEqual(asked.map(({ method }) => method), ['GET', 'GET', 'PUT']);
  asked[2].answer([well, gate], '"2"');
  await saved;
  asked[1].answer([well], '"1"');
  await looked;
  assert.deepEqual(notes.notes.map(({ id }) => id), ['well', 'gate']);
  notes.set(tree);
  const again = notes.flush();
  assert.equal(asked[3].if_match, '"2"', 'what is saved next goes on top of what was saved');
  asked[3].answer([well, gate, tree], '"3"');
  await again;
  notes.close();
  assert.equal(notes.state, 'saved');
});

test('what a tab could not save yet is not forgotten by another one', async () => {
  const asked = heldServer();
  const [well, gate] = ['well', 'gate'].map(pointAt);
  const open = async () => {
    const notes = new NoteDocument('g', true);
    const loaded = notes.load();
    asked[asked.length - 1].answer([], '"1"');
    await loaded;
    return notes;
  };
  const [left, other] = [await open(), await open()];
  left.set(well);
  void left.flush();  // of a tab that sleeps: no answer comes
  const looked = other.refresh();
  asked[asked.length - 1].answer([], '"1"');
  await looked;
  other.set(gate);
  assert.deepEqual((await open()).notes.map(({ id }) => id), ['well', 'gate']);
  const saved = other.flush();
  asked[asked.length - 1].answer([gate], '"2"');
  await saved;
  const again = await open();
  assert.deepEqual(again.notes.map(({ id }) => id), ['well']);
  for (const notes of [left, other, again]) notes.endPause();
});
