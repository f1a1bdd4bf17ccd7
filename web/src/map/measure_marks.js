// What of a measurement lies on the map as elements: its points, which are dragged or moved by keyboard, and the length
// of each part.
/** @import { LonLat } from './geodesy.js' */
/** @import { MapView } from './map_view.js' */
import { h } from '../shared/dom.js';
import { movedByKey } from '../shared/follow_pointer.js';
import { strings } from '../shared/flight_strings.js';

const kKeyStep_px = 4;
// A part that is shorter on the screen has no room for its length.
const kShortest_px = 64;

/** @typedef {{from: LonLat, to: LonLat, text: string}} Part */

/**
 * @param {MapView} view
 * @param {{on_grab: () => void, on_move: (index: number, place: LonLat) => void, on_drop: () => void, on_remove: (index: number) => void}} listener
 * @returns {{show: (places: LonLat[], parts: Part[]) => void}}
 */
export function measureMarks(view, listener) {
  /** @type {{element: HTMLElement, mark: ReturnType<MapView['addMark']>}[]} */
  const points = [];
  /** @type {{element: HTMLElement, mark: ReturnType<MapView['addMark']>, part: Part}[]} */
  const labels = [];
  let is_dragged = false;

  /** @param {number} index @param {LonLat} place */
  const addPoint = (index, place) => {
    const label = strings.measure.point(index + 1);
    const element = h('button', { type: 'button', class: 'measure-point', 'aria-label': label, title: label });
    const mark = view.addMark(element, place, 0, (next) => {
      if (!is_dragged) listener.on_grab();
      is_dragged = true;
      listener.on_move(index, next);
    });
    mark.on('dragend', () => {
      is_dragged = false;
      listener.on_drop();
    });
    element.addEventListener('keydown', (event) => {
      if (event.key === 'Delete') {
        event.stopPropagation();
        listener.on_remove(index);
        points[Math.min(index, points.length - 1)]?.element.focus();
        return;
      }
      const next = movedByKey(event, view.map, mark, kKeyStep_px);
      if (!next) return;
      listener.on_grab();
      listener.on_move(index, next);
      listener.on_drop();
    });
    points[index] = { element, mark };
  };
  const drawLabels = () => {
    for (const { element, part } of labels) {
      const [from, to] = [view.map.project(part.from), view.map.project(part.to)];
      element.hidden = Math.hypot(to.x - from.x, to.y - from.y) < kShortest_px;
    }
  };
  for (const event of /** @type {const} */ (['zoom', 'pitch'])) view.map.on(event, drawLabels);

  return {
    show(places, parts) {
      while (points.length > places.length) points.pop()?.mark.remove();
      places.forEach((place, i) => {
        if (points[i]) points[i].mark.setLngLat(place);
        else addPoint(i, place);
      });
      while (labels.length > parts.length) labels.pop()?.mark.remove();
      parts.forEach((part, i) => {
        /** @type {LonLat} */
        const middle = [(part.from[0] + part.to[0]) / 2, (part.from[1] + part.to[1]) / 2];
        if (!labels[i]) {
          const element = h('span', { class: 'measure-label' });
          labels[i] = { element, mark: view.addMark(element, middle, 0, null), part };
          element.removeAttribute('tabindex');
          element.setAttribute('role', 'note');
        }
        labels[i].part = part;
        labels[i].element.textContent = part.text;
        labels[i].element.setAttribute('aria-label', part.text);
        labels[i].mark.setLngLat(middle);
      });
      drawLabels();
    },
  };
}
