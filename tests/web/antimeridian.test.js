// Maps across the antimeridian, whose bounds go on beyond 180 degrees, without a browser.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { overlap } from '../../web/src/map/compare_view.js';
import { lonBeside } from '../../web/src/map/coordinates.js';

/** @typedef {import('../../web/src/shared/types.js').Bounds} Bounds */

test('a map across the antimeridian has common ground with those on both sides of it', () => {
  const on = (/** @type {number} */ west, /** @type {number} */ east) => ({ bounds: /** @type {Bounds} */ ([west, -17, east, -16.9]) });
  const across = on(179.99, 180.01);
  for (const beside of [on(-179.995, -179.98), on(179.98, 179.995), on(179.995, 180.02)]) assert.deepEqual([overlap(across, beside), overlap(beside, across)], [true, true], String(beside.bounds));
  for (const away of [on(-179.98, -179.97), on(179.97, 179.98), on(-0.01, 0.01)]) assert.deepEqual([overlap(across, away), overlap(away, across)], [false, false], String(away.bounds));
  assert.equal(overlap(on(7, 8), on(7.5, 9)), true);
  assert.deepEqual([lonBeside(-179.75, 180), lonBeside(179.75, -180), lonBeside(7.25, 8), lonBeside(540.5, -179)], [180.25, -180.25, 7.25, -179.5]);
});
