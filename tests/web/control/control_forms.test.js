// The form of a list of control points, without a browser.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { made } from '../support/fake_page.js';
import { loadFlightStrings } from '../../../web/src/shared/flight_strings.js';
import { ControlDocument } from '../../../web/src/control/control_document.js';
import { openImport } from '../../../web/src/control/control_forms.js';

await loadFlightStrings();

test('a list that was edited since it was chosen can be chosen again', () => {
  openImport(new ControlDocument('f'), []);
  const file = made.find(({ attributes }) => attributes.type === 'file');
  assert.ok(file);
  file.value = 'C:\\fakepath\\gcp_list.txt';
  // Browsers tell no change where the file of that name is chosen once more.
  file.dispatchEvent(new Event('click'));
  assert.equal(file.value, '');
});
