// Where a map is pointed at, without a browser: a cursor that rests while the map moves, and fingers, which leave none. And the
// sheet of a phone, which gives way to the map.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { pointedPlace } from '../../web/src/shared/follow_pointer.js';
import { bottomSheet } from '../../web/src/shared/sheet.js';

/** A map of a degree a pixel, whose upper left corner can be moved. */
function plainMap() {
  const canvas = Object.assign(new EventTarget(), { getBoundingClientRect: () => ({ left: 100, top: 50 }) });
  const map = { west: 7, north: 46, getCanvasContainer: () => canvas, unproject: (/** @type {[number, number]} */ [x, y]) => ({ lng: map.west + x, lat: map.north - y }), getCenter: () => map.unproject([10, 10]) };
  const send = (/** @type {string} */ type, more = {}) => canvas.dispatchEvent(Object.assign(new Event(type), { pointerType: 'mouse', ...more }));
  return { map, send };
}

test('the place below a cursor is what lies there now, wherever the map was moved since', () => {
  const { map, send } = plainMap();
  /** @type {boolean[]} */
  const told = [];
  const pointed = pointedPlace(/** @type {any} */ (map), (is_there) => told.push(is_there));
  assert.deepEqual([pointed.is_cursor, pointed.place], [false, { lng: 17, lat: 36 }]);
  send('pointermove', { clientX: 102, clientY: 53 });
  assert.deepEqual([pointed.is_cursor, pointed.place], [true, { lng: 9, lat: 43 }]);
  map.west += 4;  // by a key
  assert.deepEqual(pointed.place, { lng: 13, lat: 43 });
  send('pointerleave');
  assert.deepEqual([pointed.is_cursor, pointed.place], [false, { lng: 21, lat: 36 }]);
  assert.deepEqual(told, [true, false]);
});

test('a finger leaves no cursor where it tapped: what counts is the middle of the map', () => {
  const { map, send } = plainMap();
  let told = 0;
  const pointed = pointedPlace(/** @type {any} */ (map), () => (told += 1));
  const finger = { pointerType: 'touch', clientX: 102, clientY: 53 };
  for (const type of ['pointerdown', 'pointermove', 'pointerleave']) send(type, finger);
  // What browsers send after a tap for pages that know mice alone.
  send('mousemove', finger);
  assert.deepEqual([pointed.is_cursor, pointed.place, told], [false, { lng: 17, lat: 36 }, 0]);
  send('pointermove', { clientX: 102, clientY: 53 });
  send('pointerdown', finger);
  assert.equal(pointed.is_cursor, false);
});

test('the sheet of a phone gives way to the map, in a browser of some years ago too; beside the map it stays', () => {
  for (const boxes of [[{}], []]) {
    const classes = new Set();
    const classList = { contains: (/** @type {string} */ name) => classes.has(name), toggle: (/** @type {string} */ name, /** @type {boolean} */ on) => (on ? classes.add(name) : classes.delete(name)) };
    const element = Object.assign(new EventTarget(), { classList, setAttribute: () => {}, textContent: '', getClientRects: () => boxes });
    Object.assign(globalThis, { document: { getElementById: () => element } });
    bottomSheet(() => {}).close();
    assert.equal(classes.has('sheet-closed'), boxes.length > 0);
  }
});
