// The dialog that asks for a token, without a browser: how often it is put before somebody who closes it.
import assert from 'node:assert/strict';
import { test } from 'node:test';

const acts = new EventTarget();
/** @type {FakeElement[]} dialogs that are open */
const open = [];
class FakeElement extends EventTarget {
  returnValue = '';
  value = '';
  append() {}
  setAttribute() {}
  remove() {}
  showModal() {
    open.push(this);
  }
}
Object.assign(globalThis, {
  Node: FakeElement,
  addEventListener: acts.addEventListener.bind(acts),
  location: { pathname: '/', href: 'http://localhost/' },
  document: { body: new FakeElement(), documentElement: {}, createElement: () => new FakeElement(), getElementById: () => new FakeElement(), querySelectorAll: () => [] },
});
const { askForToken } = await import('../../../web/src/shared/access.js');

/** @returns {Promise<void>} when what waits for the dialog knows */
const closeAll = () => {
  for (const dialog of open.splice(0)) dialog.dispatchEvent(new Event('close'));
  return new Promise(setImmediate);
};

test('who closes the dialog is not asked again by what tries by itself, but is after doing something', async () => {
  askForToken();
  askForToken();
  assert.equal(open.length, 1);
  await closeAll();
  askForToken();
  assert.equal(open.length, 0);
  acts.dispatchEvent(new Event('click'));
  askForToken();
  assert.equal(open.length, 1);
  await closeAll();
});
