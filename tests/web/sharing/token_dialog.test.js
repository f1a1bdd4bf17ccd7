// The dialog that asks for a token, without a browser: how often it is put before somebody who closes it.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { acts, made } from '../support/fake_page.js';

const { askForToken } = await import('../../../web/src/shared/access.js');
const open = () => made.filter(({ is_open }) => is_open);

test('who closes the dialog is not asked again by what tries by itself, but is after doing something', async () => {
  askForToken();
  askForToken();
  assert.equal(open().length, 1);
  open()[0].close();
  await new Promise(setImmediate);
  askForToken();
  assert.equal(open().length, 0);
  acts.dispatchEvent(new Event('click'));
  askForToken();
  assert.equal(open().length, 1);
});
