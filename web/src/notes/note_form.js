// Writing a note: its name, its words and, of a point, its place, by click, by dragging or by the map's centre.
/** @import { LonLat } from '../map/geodesy.js' */
/** @import { Stage } from '../map/stage.js' */
/** @import { Note } from './note_shape.js' */
import { rounded } from '../map/measurement_files.js';
import { h, onEscape } from '../shared/dom.js';
import { button } from '../shared/icons.js';
import { strings } from '../shared/flight_strings.js';
import { bytesOf, kMaxNameBytes, kMaxTextBytes, noteOf } from './note_shape.js';

/**
 * @param {Stage} stage
 * @param {Note|null} note null: a new one
 * @param {{on_save: (note: Note) => void, on_end: () => void}} listener
 * @param {Note|null} [draft] what of it was written already
 * @returns {{element: HTMLFormElement, note: Note|null, draft: Note|null, close: () => void}} draft: null where nothing is written that is not in the note
 */
export function noteForm(stage, note, listener, draft = note) {
  const words = strings.notes;
  const name = h('input', { class: 'field', id: 'note-name', type: 'text', required: true, maxlength: kMaxNameBytes, autocomplete: 'off', value: draft?.properties.name ?? '' });
  const text = h('textarea', { class: 'field', id: 'note-text', rows: 3, maxlength: kMaxTextBytes, value: draft?.properties.text ?? '' });
  const view = stage.map_view;
  const is_point = !note || note.geometry.type === 'Point';
  const centre = () => /** @type {LonLat} */ (view?.map.getCenter().toArray() ?? [0, 0]);
  let place = /** @type {LonLat} */ (draft?.geometry.type === 'Point' ? draft.geometry.coordinates : centre());
  const pin = h('div', { class: 'note-pin', role: 'img', 'aria-label': words.mark });
  const mark = is_point && view ? view.addMark(pin, place, 0, (next) => (place = next)) : null;
  const moveTo = (/** @type {LonLat} */ next) => {
    place = next;
    mark?.setLngLat(next);
  };
  if (mark) stage.takeClicks(moveTo);
  const written = () => {
    const geometry = is_point ? { type: /** @type {const} */ ('Point'), coordinates: rounded(place) } : /** @type {Note} */ (note).geometry;
    return noteOf(name.value.trim(), text.value.replaceAll('\r\n', '\n').trim(), geometry, note?.id);
  };
  const close = () => {
    mark?.remove();
    stage.takeClicks(null);
  };
  const end = () => {
    close();
    listener.on_end();
  };
  for (const [input, most] of /** @type {[HTMLInputElement|HTMLTextAreaElement, number][]} */ ([[name, kMaxNameBytes], [text, kMaxTextBytes]])) {
    input.addEventListener('input', () => input.setCustomValidity(bytesOf(input.value) > most ? words.too_long : ''));
  }
  const element = h(
    'form',
    { class: 'note-form', id: 'note-form' },
    h('label', { for: 'note-name' }, words.name),
    name,
    h('label', { for: 'note-text' }, words.text),
    text,
    mark && h('p', { class: 'muted fine' }, words.place),
    h(
      'div',
      { class: 'row' },
      h('button', { type: 'submit', class: 'button small primary', id: 'note-save' }, strings.flights.save),
      mark && button(words.at_centre, () => moveTo(centre()), { id: 'note-centre' }),
      button(strings.flights.cancel, end),
    ),
  );
  onEscape(element, (event) => {
    event.stopPropagation();
    end();
  });
  element.addEventListener('submit', (event) => {
    event.preventDefault();
    const made = written();
    if (made.properties.name === '') {
      name.value = '';
      name.reportValidity();
      return;
    }
    close();
    listener.on_save(made);
  });
  return {
    element,
    note,
    get draft() {
      return name.value === (note?.properties.name ?? '') && text.value === (note?.properties.text ?? '') ? null : written();
    },
    close,
  };
}
