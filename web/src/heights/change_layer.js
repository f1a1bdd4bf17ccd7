// The choice of another flight of the same ground: how the map's heights differ from its, as a layer in colours. Not there
// where the map has no heights, or nobody else flew here.
/** @import { ChangeTileJson, Flight } from '../shared/types.js' */
/** @import { MapView } from '../map/map_view.js' */
import { showError } from '../shared/announce.js';
import { getChange } from '../shared/api.js';
import { h, put } from '../shared/dom.js';
import { strings } from '../shared/flight_strings.js';
import { chosenUnits, heightIn } from '../shared/units.js';
import { contour_layers } from '../map/map_style.js';
import { tilesOf } from '../map/map_layers.js';
import { nameWithDay, otherFlights } from './earlier_flights.js';

const kChange = 'height-change';

/** @param {ChangeTileJson} change */
function legend({ stops, least_shown_m, shift }) {
  const words = strings.heights.change;
  const units = chosenUnits();
  const steps = stops.map(({ change_m, colour }) => {
    const swatch = h('span', { class: 'swatch', 'aria-hidden': 'true' });
    swatch.style.backgroundColor = colour;
    return h('li', {}, swatch, h('span', { class: 'mono' }, `${change_m > 0 ? '+' : ''}${heightIn(change_m, units)}`));
  });
  return [
    h('ul', { class: 'change-steps' }, ...steps.reverse()),
    h('p', { class: 'muted fine' }, words.least(heightIn(least_shown_m, units)), ' ', shiftWords(shift)),
  ];
}

/** What was taken out between the two maps. @param {ChangeTileJson['shift']} shift */
export function shiftWords({ east_m, north_m, up_m }) {
  const units = chosenUnits();
  return strings.heights.change.shifted(heightIn(Math.abs(up_m), units), heightIn(Math.hypot(east_m, north_m), units));
}

/** @param {MapView} view @returns {HTMLElement} */
export function changeLayer(view) {
  const words = strings.heights.change;
  const select = h('select', { id: 'change-since', class: 'field' });
  const key = h('div', { id: 'change-legend' });
  const element = h('div', { class: 'overlay-choice', hidden: true }, h('label', { for: 'change-since', class: 'small-label' }, words.since), select, key);
  let turn = 0;
  const take = () => {
    turn += 1;
    put(key);
    view.remove(kChange, [kChange]);
  };
  const offer = (/** @type {Flight[]} */ others) => {
    put(select, h('option', { value: '' }, words.none), ...others.map((other) => h('option', { value: other.id }, nameWithDay(other))));
    element.hidden = others.length === 0;
  };
  select.addEventListener('change', async () => {
    take();
    const own_turn = turn;
    if (!select.value) return;
    try {
      const change = await getChange(view.flight_id, select.value);
      if (own_turn !== turn) return;
      view.map.addSource(kChange, { type: 'raster', ...tilesOf(change), ...(view.bounds ? { bounds: view.bounds } : {}) });
      view.addBelowPhotos({ id: kChange, type: 'raster', source: kChange, paint: { 'raster-resampling': 'nearest', 'raster-fade-duration': 0 } }, contour_layers);
      put(key, ...legend(change));
    } catch (error) {
      if (own_turn !== turn) return;
      select.value = '';
      showError(error);
    }
  });
  view.shown.addEventListener('change', async () => {
    take();
    offer([]);
    if (!view.heights.includes('dsm')) return;
    const own_turn = turn;
    const others = await otherFlights(view).catch(() => []);  // who cannot list flights compares with none
    if (own_turn === turn) offer(others);
  });
  return element;
}
