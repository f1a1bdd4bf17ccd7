// Places that are typed, and what pairs of places do to a map: against GeographicLib and by hand.
import assert from 'node:assert/strict';
import { createRequire } from 'node:module';
import { test } from 'node:test';
import { formatCoordinates } from '../../../web/src/map/coordinates.js';
import { parsePlace } from '../../../web/src/map/parse_place.js';
import { lieNear, movement } from '../../../web/src/map/place_pairs.js';
import { web_root } from '../support/mock_server.js';

let geodesic = null;
try {
  geodesic = createRequire(`${web_root}/package.json`)('geographiclib-geodesic').Geodesic.WGS84;
} catch {
  geodesic = null;
}

/** @param {string} text @param {number} lat @param {number} lon */
function assertReads(text, lat, lon) {
  const read = parsePlace(text);
  assert.ok('place' in read, `${text}: ${JSON.stringify(read)}`);
  assert.ok(Math.abs(read.place[0] - lon) < 1e-9 && Math.abs(read.place[1] - lat) < 1e-9, `${text} is read as ${read.place}`);
}

test('a place is read however it is written', () => {
  const [lat, lon] = [46 + 57 / 60 + 4.3 / 3600, 7 + 26 / 60 + 20.8 / 3600];
  for (const text of ['46.95, 7.43', '46.95 7.43', '46.95,7.43', '46,95 7,43', '46,95, 7,43', '46,95; 7,43', '46.95/7.43', '(46.95, 7.43)', 'geo:46.95,7.43?z=17',
    '46.95N 7.43E', '46.95 n, 7.43 e', 'N46.95 E7.43', 'N 46.95° E 7.43°', '46.95°N7.43°E', '7.43E 46.95N', 'E7.43, N46.95', 'lat: 46.95 lon: 7.43', 'Latitude 46.95, Longitude 7.43',
    '46° 57′ N 7° 25.8′ E', '46 57 7 25.8', '46 57.0N 7 25.8E']) assertReads(text, 46.95, 7.43);
  for (const text of [`46°57'04.3"N 7°26'20.8"E`, '46° 57′ 04.3″ N  7° 26′ 20.8″ E', `46°57'04,3"N, 7°26'20,8"E`, `46º57’04.3''N, 007º26’20.8''E`, '46:57:04.3 7:26:20.8',
    '46 57 04.3, 7 26 20.8', 'N46 57 04.3 E7 26 20.8', '46d57m04.3s 7d26m20.8s']) assertReads(text, lat, lon);
  for (const text of ['-46.95, -7.43', '−46.95, −7.43', '–46.95 –7.43', '46.95S 7.43W', 'S46.95 W7.43', '-46 57 -7 25.8', '46°57′S 7°25.8′W']) assertReads(text, -46.95, -7.43);
  assertReads('+46.95, -0.5', 46.95, -0.5);
  assertReads('0.0001, -0.0002', 0.0001, -0.0002);
  assertReads('-0 30 -0 45', -0.5, -0.75);
  assertReads('-33.85, 151.2', -33.85, 151.2);
});

test('what the page itself shows can be pasted', () => {
  for (const [lon, lat] of [[7.4391, 46.9512], [-70.66, -33.45], [151.2093, -33.8688]]) {
    assertReads(formatCoordinates(lon, lat, 'decimal'), lat, lon);
    const read = parsePlace(formatCoordinates(lon, lat, 'dms'));
    assert.ok('place' in read && Math.abs(read.place[0] - lon) < 2e-6 && Math.abs(read.place[1] - lat) < 2e-6);
  }
});

test('what is no place, or could be two, is not read, and why is told', () => {
  const faults = {
    empty: ['', '   '],
    unreadable: ['46.95', 'abc', '46.95, abc', '46,95', '46,95,7,43', '46.95 7.43 5', '46.95-7.43', '-46.95S 7W', '46.95N 7.43N', '46.95E 7.43E', '46.95N 7.43', '46.95 57 7.43 26', '46 57 7',
      '32N  385000.00 E  5200000.00 N', '1e2, 3', 'NaN, NaN', '46.95N,,7.43E', '46.95, 7.43, 500', '9'.repeat(100), '1 '.repeat(50)],
    swapped: ['147.12, -33.8', '91, 7', '-100 20'],
    range: ['91, 181', '46, 180.1', '86N 7E', '10, 99999'],
    minutes: ['46 60 7 26', '46 57 7 61', '46 57 60 7 26 20', '46°57′04″N 7°26′75″E'],
  };
  for (const [fault, texts] of Object.entries(faults)) for (const text of texts) assert.deepEqual(parsePlace(text), { fault }, text);
});

test('points are near together within a twentieth of the map', () => {
  const bounds = /** @type {[number, number, number, number]} */ ([7.1, 46.8, 7.11, 46.806]);
  const across = (/** @type {number} */ share) => /** @type {[number, number][]} */ ([[7.104, 46.802], [7.104 + 0.01 * share, 46.802 + 0.006 * share]]);
  assert.ok(lieNear(across(0.045), bounds));
  assert.ok(!lieNear(across(0.055), bounds));
  assert.ok(!lieNear([[7.1, 46.8]], bounds), 'one point is not near another');
  assert.ok(!lieNear([...across(0.01), [7.109, 46.8055]], bounds), 'a third one is far');
  assert.ok(lieNear([[180, 1], [-179.9999, 1]], [179.9, 0.9, 180, 1.1]), 'across the date line');
});

test('pairs tell shift, turn and scale', { skip: geodesic ? false : 'web/node_modules is missing (npm ci in web/)' }, () => {
  const at = (/** @type {[number, number]} */ [lon, lat], /** @type {number} */ azimuth_deg, /** @type {number} */ length_m) => {
    const { lon2, lat2 } = geodesic.Direct(lat, lon, azimuth_deg, length_m);
    return /** @type {[number, number]} */ ([lon2, lat2]);
  };
  /** @type {[number, number]} */
  const nowhere = [0, 0];
  /** @type {[number, number]} */
  const field = [179.9995, 60];
  const pairs = [[20, 150], [140, 220], [260, 90]].map(([azimuth, length]) => ({ shown: at(nowhere, azimuth, length), is: at(field, azimuth + 35, length * 1.8) }));
  for (const count of [2, 3]) {
    const move = movement(pairs.slice(0, count));
    assert.ok(move);
    assert.ok(Math.abs(move.turn_deg - 35) < 0.05 && Math.abs(move.scale - 1.8) < 0.002 && move.miss_m < 0.1, JSON.stringify(move));
  }
  const slipped = movement([pairs[0], pairs[1], { ...pairs[2], is: at(pairs[2].is, 0, 30) }]);
  assert.ok(slipped && slipped.miss_m > 8, JSON.stringify(slipped));
  const one = movement([{ shown: [7.1, 46.8], is: at([7.1, 46.8], 90, 40) }]);
  assert.ok(one && Math.abs(one.shift_m - 40) < 1e-3 && one.scale === 1 && one.turn_deg === 0);
  assert.equal(movement([pairs[0], pairs[0]]), null);
  assert.equal(movement([pairs[0], { ...pairs[1], is: pairs[0].is }]), null);
});
