// What lies above and below a base within a measured area, where the map has heights: asked of the server when the outline
// rests, told below the measurement.
/** @import { VolumeFigures } from '../shared/types.js' */
/** @import { LonLat } from '../map/geodesy.js' */
/** @import { MapView } from '../map/map_view.js' */
/** @import { Units } from '../shared/units.js' */
import { getVolume, messageOf } from '../shared/api.js';
import { h, put } from '../shared/dom.js';
import { formatPercent, typedNumber } from '../shared/format.js';
import { strings } from '../shared/flight_strings.js';
import { number } from '../shared/language.js';
import { polygonOf } from '../map/measurement_files.js';
import { chosenUnits, heightIn, heightUnit, metresPer, volumeIn } from '../shared/units.js';
import { askAtRest, kRest_ms } from './ask_at_rest.js';
import { doubtsOf, shiftWords } from './change_layer.js';
import { earlierFlights, nameWithDay } from './earlier_flights.js';
import { figureList } from './figures.js';

const kGiven = 'given';
const kSince = 'since=';  // and the other flight's id
// Of less measured ground, or less ground with heights, it is said.
const kMuchMeasured = 0.9;
const kAllCovered = 0.99;

/**
 * @param {VolumeFigures} found
 * @param {Units} units
 * @returns {Node[]}
 */
function volumeWords(found, units) {
  const words = strings.volume;
  const in_units = (/** @type {number} */ cubic_metres) => volumeIn(cubic_metres, units);
  const covered_share = found.area_m2 > 0 ? found.covered_m2 / found.area_m2 : 1;
  // Of what has heights.
  const measured_share = found.covered_m2 > 0 ? Math.min(1, (found.measured_share * found.area_m2) / found.covered_m2) : 0;
  const doubts = [
    ...(covered_share < kAllCovered ? [words.partly(formatPercent(covered_share))] : []),
    ...(measured_share < kMuchMeasured ? [words.little_measured(formatPercent(measured_share))] : []),
  ];
  const { shift } = found;
  return [
    figureList('volume-figures', [
      [shift ? words.added : words.above, in_units(found.cut_m3)],
      [shift ? words.taken : words.below, in_units(found.fill_m3)],
      [words.net, words.with_error(in_units(found.net_m3), found.net_sigma_m3 === null ? words.unknown_error : in_units(found.net_sigma_m3))],
      ...(shift ? [] : [/** @type {[string, string]} */ ([found.base === 'plane' ? words.mean_height : words.height, heightIn(found.base_m, units)])]),
    ]),
    ...(shift ? [h('p', { class: 'muted fine' }, shiftWords(shift)), ...doubtsOf(shift)] : []),
    ...doubts.map((text) => h('p', { class: 'fine amber' }, text)),
  ];
}

/**
 * @param {MapView} view
 * @returns {{element: HTMLElement, show: (places: LonLat[], units: Units) => void}} show: corners of an outline that does not
 *   cross itself; fewer than three take it away
 */
export function volumeSection(view) {
  const words = strings.volume;
  /** @type {LonLat[]} */
  let places = [];
  /** @type {Units} */
  let units = chosenUnits();
  /** @type {number|null} */
  let given_m = null;

  const base = h('select', { id: 'volume-base', class: 'field' }, ...Object.entries(words.bases).map(([value, label]) => h('option', { value }, label)));
  const given = h('input', { type: 'text', id: 'volume-given', class: 'field mono', autocomplete: 'off', 'aria-label': words.given });
  const unit = h('span', { class: 'muted' });
  const given_row = h('div', { class: 'volume-given', hidden: true }, given, unit);
  const result = h('div', { class: 'volume-result', id: 'volume-result', 'aria-live': 'polite' });
  const element = h(
    'section',
    { class: 'heights', id: 'volume', 'aria-label': words.heading, hidden: true },
    h('h3', { class: 'heights-title' }, words.heading),
    h('label', { for: 'volume-base', class: 'small-label' }, words.base),
    base,
    given_row,
    result,
  );

  const say = (/** @type {string} */ text) => put(result, h('p', { class: 'muted fine', id: 'volume-message' }, text));
  const asker = askAtRest(kRest_ms, (/** @type {VolumeFigures|null} */ found, /** @type {unknown} */ error) => {
    if (found) put(result, ...volumeWords(found, units));
    else say(messageOf(error));
  });
  const drop = () => {
    asker.drop();
    put(result);
  };
  const writeGiven = () => {
    unit.textContent = heightUnit(units);
    if (given_m !== null) given.value = number(given_m / metresPer(units), { maximumFractionDigits: 2, useGrouping: false });
  };
  const ask = () => {
    if (element.hidden) return;
    const is_readable = base.value !== kGiven || given_m !== null;
    given.setAttribute('aria-invalid', String(!is_readable));
    if (!is_readable) {
      drop();
      say(words.no_number);
      return;
    }
    const wanted = base.value.startsWith(kSince) ? base.value : `base=${base.value === kGiven ? given_m : base.value}`;
    const { flight_id } = view;
    const outline = polygonOf(places);
    const is_new = asker.about(JSON.stringify([flight_id, wanted, outline]), (signal) => getVolume(flight_id, wanted, outline, signal));
    if (is_new && !result.firstChild) say(words.waiting);
    if (!is_new && asker.answer) put(result, ...volumeWords(asker.answer, units));
  };
  const draw = () => {
    element.hidden = places.length < 3 || !view.heights.includes('dsm');
    if (element.hidden) {
      drop();
      return;
    }
    void offerEarlier();
    ask();
  };
  base.addEventListener('change', () => {
    given_row.hidden = base.value !== kGiven;
    // A first guess is the height of the base before.
    if (!given_row.hidden && given_m === null && asker.answer) given_m = Number(asker.answer.base_m.toFixed(2));
    writeGiven();
    put(result);  // of another base: what is asked for now may take a while
    ask();
  });
  given.addEventListener('input', () => {
    const value = typedNumber(given.value);
    given_m = Number.isFinite(value) ? value * metresPer(units) : null;
    ask();
  });
  let turn = 0;  // a map's
  let is_offered = false;
  const offerEarlier = async () => {
    if (is_offered) return;
    is_offered = true;
    const own_turn = turn;
    const others = await earlierFlights(view);
    if (own_turn === turn) base.append(...others.map((other) => h('option', { value: kSince + other.id }, words.since(nameWithDay(other)))));
  };
  const withdrawEarlier = () => {
    turn += 1;
    is_offered = false;
    if (base.value.startsWith(kSince)) base.selectedIndex = 0;
    for (const option of base.querySelectorAll(`option[value^="${kSince}"]`)) option.remove();
  };
  view.shown.addEventListener('change', () => {
    drop();
    withdrawEarlier();
    given_m = null;
    given.value = '';
    draw();
  });

  return {
    element,
    show(next, next_units) {
      places = next;
      if (next_units !== units) {
        units = next_units;
        writeGiven();
      }
      draw();
    },
  };
}
