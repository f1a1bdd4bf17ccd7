// Drag, wheel and two fingers on something that is panned and zoomed; where the arrow keys lead; what a cursor lies over.

/** On the screen: right, down. @type {Record<string, [number, number]>} */
export const kArrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

/**
 * @param {KeyboardEvent} event
 * @param {import('../../vendor/maplibre-gl.mjs').Map} map
 * @param {import('../../vendor/maplibre-gl.mjs').Marker} mark on it
 * @param {number} step_px of the screen
 * @returns {[number, number]|null} longitude and latitude where the key leads the mark; null: it is no arrow
 */
export function movedByKey(event, map, mark, step_px) {
  const step = kArrows[event.key];
  if (!step) return null;
  event.preventDefault();
  event.stopPropagation();
  const { x, y } = map.project(mark.getLngLat());
  return map.unproject([x + step[0] * step_px, y + step[1] * step_px]).toArray();
}

/**
 * The place below a cursor that lies over a map, however that moves below it, else in the middle. A finger leaves no cursor.
 * @param {import('../../vendor/maplibre-gl.mjs').Map} map
 * @param {(is_there: boolean) => void} on_change the cursor came or moved; false: it went
 */
export function pointedPlace(map, on_change) {
  const canvas = map.getCanvasContainer();
  /** @type {[number, number]|null} */
  let cursor = null;
  const set = (/** @type {[number, number]|null} */ next) => {
    if (!cursor && !next) return;
    cursor = next;
    on_change(next !== null);
  };
  const point = (/** @type {PointerEvent} */ event) => {
    const box = canvas.getBoundingClientRect();
    set(event.pointerType === 'touch' ? null : [event.clientX - box.left, event.clientY - box.top]);
  };
  canvas.addEventListener('pointermove', point);
  canvas.addEventListener('pointerdown', point);
  canvas.addEventListener('pointerleave', () => set(null));
  return {
    get is_cursor() {
      return cursor !== null;
    },
    get place() {
      return cursor ? map.unproject(cursor) : map.getCenter();
    },
  };
}

/**
 * @param {HTMLElement} element
 * @param {{pan: (x_px: number, y_px: number) => void, zoom: (by: number, x_px?: number, y_px?: number) => void}} actions pixels of the screen; zoom: around a place from the middle
 */
export function followPointer(element, { pan, zoom }) {
  /** @type {Map<number, {x: number, y: number}>} */
  const fingers = new Map();
  let travelled_px = 0;
  const fromMiddle = (/** @type {number} */ x, /** @type {number} */ y) => {
    const box = element.getBoundingClientRect();
    return /** @type {[number, number]} */ ([x - box.left - box.width / 2, y - box.top - box.height / 2]);
  };
  element.addEventListener('wheel', (event) => {
    event.preventDefault();
    zoom(2 ** (-Math.sign(event.deltaY) * Math.min(0.5, Math.abs(event.deltaY) / 200)), ...fromMiddle(event.clientX, event.clientY));
  }, { passive: false });
  element.addEventListener('dblclick', (event) => {
    if (!(/** @type {Element} */ (event.target)).closest('a, button')) zoom(2, ...fromMiddle(event.clientX, event.clientY));
  });
  element.addEventListener('pointerdown', (event) => {
    if (/** @type {Element} */ (event.target).closest('button, .floating')) return;
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    travelled_px = 0;
  });
  element.addEventListener('pointermove', (event) => {
    if (event.buttons === 0) fingers.delete(event.pointerId);  // it was lifted elsewhere: beside this, or in a menu
    const before = fingers.get(event.pointerId);
    if (!before) return;
    const now = { x: event.clientX, y: event.clientY };
    travelled_px += Math.hypot(now.x - before.x, now.y - before.y);
    if (travelled_px > 4) element.setPointerCapture(event.pointerId);
    const other = [...fingers].find(([id]) => id !== event.pointerId)?.[1];
    if (other) {
      const spread = (/** @type {{x: number, y: number}} */ at) => Math.max(20, Math.hypot(at.x - other.x, at.y - other.y));
      zoom(spread(now) / spread(before), ...fromMiddle((now.x + other.x) / 2, (now.y + other.y) / 2));
    } else if (travelled_px > 4) pan(now.x - before.x, now.y - before.y);
    fingers.set(event.pointerId, now);
  });
  const lift = (/** @type {PointerEvent} */ event) => fingers.delete(event.pointerId);
  element.addEventListener('pointerup', lift);
  element.addEventListener('pointercancel', lift);
  // A drag that began on a mark does not open it.
  element.addEventListener('click', (event) => {
    if (travelled_px > 4) event.preventDefault();
    travelled_px = 0;
  }, true);
}
