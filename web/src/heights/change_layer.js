// The choice of another flight of the same ground: how the map's heights differ from its, as a layer in colours. Not there
// where the map has no heights, or nobody else flew here.
/** @import { ChangeTileJson, Flight, HeightShift } from '../shared/types.js' */
/** @import { MapView } from '../map/map_view.js' */
import { showError } from '../shared/announce.js';
import { getChange } from '../shared/api.js';
import { h, put } from '../shared/dom.js';
import { formatPercent } from '../shared/format.js';
import { strings } from '../shared/flight_strings.js';
import { chosenUnits, heightIn, units_chosen } from '../shared/units.js';
import { height_layers } from '../map/map_style.js';
import { tilesOf } from '../map/map_layers.js';
import { sourceBounds } from '../map/tile_addresses.js';
import { earlierFlights, nameWithDay } from './earlier_flights.js';

const [kChange, ...layers_above] = height_layers;
const kOpacity = 0.75;  // what it lies over can be seen
// Of less of the ground, what is taken out may be what has changed.
const kMuchAlike = 0.7;

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
    h('p', { class: 'small-label' }, words.legend),
    h('ul', { class: 'change-steps' }, ...steps.reverse()),
    h('p', { class: 'muted fine' }, words.least(heightIn(least_shown_m, units, [], 2)), ' ', shiftWords(shift)),
    ...doubtsOf(shift),
  ];
}

/** What was taken out between the two maps. @param {HeightShift} shift */
export function shiftWords({ east_m, north_m, up_m }) {
  const words = strings.heights.change;
  const length = (/** @type {number} */ metres) => heightIn(metres, chosenUnits(), [], 2);
  const up = length(Math.abs(up_m));
  return east_m === null || north_m === null ? words.raised(up) : words.shifted(up, length(Math.hypot(east_m, north_m)));
}

/** @param {HeightShift} shift @returns {Node[]} */
export const doubtsOf = ({ alike_share }) =>
  alike_share < kMuchAlike ? [h('p', { class: 'fine amber' }, strings.heights.change.little_alike(formatPercent(alike_share)))] : [];

/** @param {MapView} view @returns {HTMLElement} */
export function changeLayer(view) {
  const words = strings.heights.change;
  const select = h('select', { id: 'change-since', class: 'field' });
  const key = h('div', { id: 'change-legend', 'aria-live': 'polite' });
  /** @type {ChangeTileJson|null} that is shown */
  let change = null;
  const element = h('div', { class: 'overlay-choice', hidden: true }, h('label', { for: 'change-since', class: 'small-label' }, words.since), select, key);
  let turn = 0;
  const take = () => {
    turn += 1;
    change = null;
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
    put(key, h('p', { class: 'muted fine' }, words.waiting));
    try {
      const got = await getChange(view.flight_id, select.value);
      if (own_turn !== turn) return;
      change = got;
      view.map.addSource(kChange, { type: 'raster', ...tilesOf(change), ...sourceBounds(view.bounds) });
      view.addBelowPhotos({ id: kChange, type: 'raster', source: kChange, paint: { 'raster-opacity': kOpacity, 'raster-resampling': 'nearest', 'raster-fade-duration': 0 } }, layers_above);
      put(key, ...legend(change));
    } catch (error) {
      if (own_turn !== turn) return;
      select.value = '';
      take();
      showError(error);
    }
  });
  view.shown.addEventListener('change', async () => {
    take();
    offer([]);
    if (!view.heights.includes('dsm')) return;
    const own_turn = turn;
    const others = await earlierFlights(view);
    if (own_turn === turn) offer(others);
  });
  units_chosen.addEventListener('change', () => {
    if (change) put(key, ...legend(change));
  });
  return element;
}
