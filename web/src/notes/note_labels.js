// The names of notes on the map, each of which shows its note in the list. Where names would overlap, those that stand later
// in the list wait until there is room.
/** @import { MapView } from '../map/map_view.js' */
/** @import { Note } from './note_shape.js' */
import { button } from '../shared/icons.js';
import { labelPlace } from './note_shape.js';

/** Names on the map; all are in the list. */
const kMaxLabels = 200;
const kAbove_px = 10;
const kGap_px = 2;

/** @typedef {{x: number, y: number, width: number, height: number}} Box x, y: its upper left corner */

/**
 * @param {Box[]} boxes what matters more stands first
 * @returns {boolean[]} which of them are shown, so that no two overlap
 */
export function withRoom(boxes) {
  /** @type {Box[]} */
  const shown = [];
  return boxes.map((box) => {
    const is_taken = shown.some((other) => box.x < other.x + other.width && other.x < box.x + box.width && box.y < other.y + other.height && other.y < box.y + box.height);
    if (!is_taken) shown.push(box);
    return !is_taken;
  });
}

/**
 * @param {MapView} view
 * @param {Note[]} notes
 * @param {(id: string) => void} on_choose
 * @returns {{remove: () => void}}
 */
export function noteLabels(view, notes, on_choose) {
  const labels = notes.slice(0, kMaxLabels).map((note) => {
    const { name, text } = note.properties;
    const label = text ? `${name}: ${text}` : name;
    const place = labelPlace(note);
    const element = button(name, () => on_choose(note.id), { class: 'note-mark', 'data-note-mark': note.id, 'aria-label': label, title: label });
    const mark = view.addMark(element, place, kAbove_px, null);
    return { element, mark, place, size: { width: element.offsetWidth + kGap_px, height: element.offsetHeight + kGap_px } };
  });
  const draw = () => {
    const shown = withRoom(labels.map(({ place, size }) => {
      const { x, y } = view.map.project(place);
      return { x: x - size.width / 2, y: y - kAbove_px - size.height, ...size };
    }));
    labels.forEach(({ element }, i) => element.toggleAttribute('hidden', !shown[i] && document.activeElement !== element));
  };
  // Only these move names against each other.
  const moves = /** @type {const} */ (['zoom', 'rotate', 'pitch', 'resize']);
  for (const event of moves) view.map.on(event, draw);
  draw();
  return {
    remove() {
      for (const event of moves) view.map.off(event, draw);
      for (const { mark } of labels) mark.remove();
    },
  };
}
