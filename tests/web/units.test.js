// What is shown in the units that are chosen, without a browser: it is made again with others, and goes with its element.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { setFlagsFromString } from 'node:v8';
import { runInNewContext } from 'node:vm';
import { chosenUnits, inUnits, keepUnits } from '../../web/src/shared/units.js';

/** A document of one list. @type {Set<any>} */
const shown = new Set();
Object.assign(globalThis, { document: { querySelectorAll: (/** @type {string} */ selector) => [...shown].filter(({ marks }) => selector === `[${marks}]`) } });

/** @param {object} [about] what it was made of */
const element = (about) => ({
  about,
  text: chosenUnits(),
  marks: '',
  get isConnected() {
    return shown.has(this);
  },
  setAttribute(/** @type {string} */ name) {
    this.marks = name;
  },
  replaceWith(/** @type {any} */ other) {
    shown.delete(this);
    shown.add(other);
  },
});

test('what is shown follows the units, once and again', () => {
  keepUnits('metric');
  shown.add(inUnits(/** @type {any} */ (element)));
  for (const units of /** @type {const} */ (['imperial', 'metric'])) {
    keepUnits(units);
    assert.deepEqual([...shown].map(({ text }) => text), [units]);
  }
  shown.clear();
  assert.equal(inUnits(() => null), null);
});

test('what is shown no more is kept by nothing, however long the page is open', async () => {
  setFlagsFromString('--expose-gc');
  const collect = runInNewContext('gc');
  const left = (() => {
    const photos = { features: new Array(1000) };
    shown.add(inUnits(() => /** @type {any} */ (element(photos))));
    shown.clear();
    return new WeakRef(photos);
  })();
  await new Promise(setImmediate);
  collect();
  assert.equal(left.deref(), undefined);
});
