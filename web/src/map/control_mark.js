// A control point on the map: a target with its name, which opens its marks.
/** @import { MapView } from './map_view.js' */
import { h } from '../shared/dom.js';

/**
 * @param {MapView} view
 * @param {{name: string, place: [number, number], label: string, is_marked: boolean}} point
 * @param {(name: string) => void} on_choose
 * @returns {{remove: () => void}}
 */
export function controlMark(view, { name, place, label, is_marked }, on_choose) {
  const element = h('button', { type: 'button', class: is_marked ? 'control-mark is-marked' : 'control-mark', 'data-point': name, 'aria-label': label, title: label, on: { click: () => on_choose(name) } }, h('span', {}, name));
  return view.addMark(element, place, 0, null);
}
