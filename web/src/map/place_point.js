// One point by which a map is placed: its numbered mark where the map shows it, the mark where it really is, and its row
// in the tool's card with the field for that place.
/** @import { LonLat } from './geodesy.js' */
/** @import { MapView } from './map_view.js' */
import { formatCoordinates, wrapLongitude } from './coordinates.js';
import { h } from '../shared/dom.js';
import { movedByKey } from '../shared/follow_pointer.js';
import { icon } from '../shared/icons.js';
import { parsePlace } from './parse_place.js';
import { strings } from '../shared/flight_strings.js';

const kStem_px = 14;  // of a mark, as its style draws it: what is marked stays in sight; the true place's hangs, so that neither hides the other
const kPatience_ms = 900;  // until what is being typed is said to be no place

/** @typedef {ReturnType<typeof placePoint>} PlacePoint */

/**
 * @param {MapView} view
 * @param {'shown'|'is'} kind
 * @param {LonLat} place
 * @param {(place: LonLat) => void} on_move by pointer or arrow keys, ten pixels with Shift
 */
function markAt(view, kind, place, on_move) {
  const element = h('button', { type: 'button', class: `point-mark point-mark-${kind}` });
  const moved = (/** @type {LonLat} */ [lon, lat]) => on_move([wrapLongitude(lon), lat]);
  const mark = view.addMark(element, place, kind === 'shown' ? kStem_px : -kStem_px, moved);
  element.addEventListener('keydown', (event) => {
    const next = movedByKey(event, view.map, mark, event.shiftKey ? 10 : 1);
    if (!next) return;
    mark.setLngLat(next);
    moved(next);
  });
  return {
    element,
    set: (/** @type {LonLat} */ next) => mark.setLngLat(next),
    show: () => mark.addTo(view.map),
    remove: () => mark.remove(),
  };
}

/**
 * @param {MapView} view
 * @param {LonLat} first where the map shows it
 * @param {{on_change: () => void, on_remove: () => void, on_enter: () => void}} listener on_enter: with its true place
 */
export function placePoint(view, first, listener) {
  const words = strings.place;
  let shown = first;
  /** @type {LonLat|null} */
  let is = null;
  let timer = 0;
  const badge = h('span', { class: 'place-badge', 'aria-hidden': 'true' });
  const said = h('p', { class: 'place-said muted' });
  const input = h('input', { class: 'field mono', type: 'text', autocomplete: 'off', autocapitalize: 'characters', spellcheck: 'false', maxlength: 100, placeholder: words.example });
  const remove = h('button', { type: 'button', class: 'icon-button', on: { click: () => listener.on_remove() } }, icon('close'));
  const row = h('li', { class: 'place-row' }, badge, input, remove, said);
  const shown_mark = markAt(view, 'shown', shown, (place) => {
    shown = place;
    listener.on_change();
  });
  /** @type {ReturnType<typeof markAt>|null} */
  let is_mark = null;
  let number = 0;

  const label = () => {
    shown_mark.element.textContent = String(number);
    shown_mark.element.setAttribute('aria-label', words.mark.shown(number));
    if (!is_mark) return;
    is_mark.element.textContent = String(number);
    is_mark.element.setAttribute('aria-label', words.mark.is(number));
  };
  const drawTrue = () => {
    if (!is) {
      is_mark?.remove();
      is_mark = null;
      return;
    }
    if (is_mark) is_mark.set(is);
    else {
      is_mark = markAt(view, 'is', is, (place) => {
        is = place;
        write(place);
        listener.on_change();
      });
      label();
    }
  };
  const write = (/** @type {LonLat} */ [lon, lat]) => {
    input.value = formatCoordinates(lon, lat, 'decimal');
    say('');
  };
  const say = (/** @type {string} */ text, is_fault = false) => {
    clearTimeout(timer);
    said.classList.toggle('place-fault', is_fault);
    said.setAttribute('role', is_fault ? 'alert' : 'status');
    said.textContent = text;
    if (is_fault) input.setAttribute('aria-invalid', 'true');
    else input.removeAttribute('aria-invalid');
  };
  /** @param {boolean} is_whole nothing more is going to be typed */
  const read = (is_whole) => {
    const result = parsePlace(input.value);
    const before = is;
    is = 'place' in result ? result.place : null;
    if ('place' in result) {
      say(`= ${formatCoordinates(...result.place, 'decimal')}`);
    } else {
      const tell = () => say(words.faults[result.fault], result.fault !== 'empty');
      if (is_whole || result.fault === 'empty') tell();
      else {
        if (before) say('');
        clearTimeout(timer);
        timer = window.setTimeout(tell, kPatience_ms);
      }
    }
    if (before?.join() === is?.join()) return;
    drawTrue();
    listener.on_change();
  };
  input.addEventListener('input', (event) => read(/** @type {InputEvent} */ (event).inputType === 'insertFromPaste'));
  input.addEventListener('change', () => read(true));
  input.addEventListener('keydown', (event) => {
    if (event.key !== 'Enter') return;
    event.preventDefault();  // not for what gets the focus
    read(true);
    if (is) listener.on_enter();
  });

  return {
    row,
    input,
    get shown() {
      return shown;
    },
    get is() {
      return is;
    },
    /** @param {LonLat} place */
    setShown(place) {
      shown = place;
      shown_mark.set(place);
    },
    /** @param {LonLat} place */
    setTrue(place) {
      is = place;
      write(place);
      drawTrue();
    },
    /** @param {number} next its place among the points, from 1 */
    setNumber(next) {
      number = next;
      badge.textContent = String(next);
      input.setAttribute('aria-label', words.field(next));
      remove.setAttribute('aria-label', words.remove(next));
      remove.title = words.remove(next);
      said.id = `place-said-${next}`;
      input.setAttribute('aria-describedby', said.id);
      input.id = `place-is-${next}`;
      label();
    },
    /** @param {boolean} visible its marks */
    setVisible(visible) {
      for (const mark of [shown_mark, is_mark]) visible ? mark?.show() : mark?.remove();
    },
    remove() {
      clearTimeout(timer);
      shown_mark.remove();
      is_mark?.remove();
      row.remove();
    },
  };
}
