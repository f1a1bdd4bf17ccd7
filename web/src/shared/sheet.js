// On a phone the panel is a sheet over the map: the handle opens and closes it, by tap, drag or keyboard.
import { byId } from './dom.js';
import { strings } from './strings.js';

/**
 * @param {() => void} on_change the room left for the map changed
 * @returns {{close: () => void}} close: shows the map, where the panel lies over it
 */
export function bottomSheet(on_change) {
  const panel = byId('panel');
  const handle = byId('sheet-handle');
  const set = (/** @type {boolean} */ open) => {
    panel.classList.toggle('sheet-closed', !open);
    handle.setAttribute('aria-expanded', String(open));
    byId('sheet-handle-text').textContent = open ? strings.sheet.close : strings.sheet.open;
    on_change();
    panel.addEventListener('transitionend', on_change, { once: true });
  };
  let start_y = 0;
  let moved = false;
  handle.addEventListener('pointerdown', (event) => {
    start_y = event.clientY;
    moved = false;
    handle.setPointerCapture(event.pointerId);
  });
  handle.addEventListener('pointermove', (event) => {
    const by = event.clientY - start_y;
    if (!handle.hasPointerCapture(event.pointerId) || Math.abs(by) < 24) return;
    moved = true;
    set(by < 0);
  });
  handle.addEventListener('click', () => {
    if (!moved) set(panel.classList.contains('sheet-closed'));
    moved = false;
  });
  return {
    close: () => {
      // checkVisibility() is not there in Safari before 17.4, which phones of 2017 stay without.
      if (handle.getClientRects().length > 0 && !panel.classList.contains('sheet-closed')) set(false);
    },
  };
}
