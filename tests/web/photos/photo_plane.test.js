// A photo within its view, without a browser.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { FakeElement } from '../support/fake_page.js';
import { loadFlightStrings } from '../../../web/src/shared/flight_strings.js';
import { photoPlane } from '../../../web/src/flight/photo_plane.js';

await loadFlightStrings();
Object.assign(globalThis, { ResizeObserver: class { observe() {} } });

test('what is asked of a photo that is not there yet does not spoil the next one', () => {
  const view = Object.assign(new FakeElement(), { clientWidth: 800, clientHeight: 600 });
  const plane = photoPlane(/** @type {any} */ (view), { on_draw: () => {}, on_load: () => plane.show({ x: 10, y: 20 }, plane.scale) });
  Object.assign(plane.image, { naturalWidth: 0, naturalHeight: 0 });
  for (const key of /** @type {const} */ (['+', 0, '-'])) plane.keys[key]();
  Object.assign(plane.image, { naturalWidth: 4000, naturalHeight: 3000 });
  plane.image.dispatchEvent(new Event('load'));
  assert.match(plane.image.style.transform, /scale\(1\)/);
  plane.keys[0]();
  assert.match(plane.image.style.transform, /scale\(0\.2\)/);
});
