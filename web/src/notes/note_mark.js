// The name of a note on the map, which shows it in the list.
/** @import { LonLat } from '../map/geodesy.js' */
/** @import { MapView } from '../map/map_view.js' */
import { h } from '../shared/dom.js';

/**
 * @param {MapView} view
 * @param {{id: string, name: string, label: string, place: LonLat}} note
 * @param {(id: string) => void} on_choose
 * @returns {{remove: () => void}}
 */
export function noteMark(view, { id, name, label, place }, on_choose) {
  const element = h('button', { type: 'button', class: 'note-mark', 'data-note-mark': id }, name);
  element.addEventListener('click', (event) => {
    event.stopPropagation();  // not one on the map
    on_choose(id);
  });
  const mark = view.addMark(element, place, 10, null);
  // The library names its marks by itself.
  element.setAttribute('aria-label', label);
  element.title = label;
  return mark;
}
