// The height of what the photos show below the cursor, beside its coordinates, and how far that is above the ground. Asked of
// the server when the cursor rests; not there where the map has no heights, or the cursor is beside the map.
/** @import { SurfaceHeights } from '../shared/types.js' */
/** @import { MapView } from '../map/map_view.js' */
/** @import { Units } from '../shared/units.js' */
import { getSurfaceHeights } from '../shared/api.js';
import { h, put } from '../shared/dom.js';
import { strings } from '../shared/flight_strings.js';
import { chosenUnits, heightIn, units_chosen } from '../shared/units.js';
import { lonBeside, wrapLongitude } from '../map/coordinates.js';
import { askAtRest } from './ask_at_rest.js';

const kCursorRest_ms = 150;
// Less above the ground is what stays in the ground itself.
const kStanding_m = 0.3;

/**
 * @param {SurfaceHeights} heights
 * @param {Units} units
 * @returns {{height: string, over_ground: string}} '' for what is not known, or not worth saying
 */
export function readoutWords({ dsm_m = null, dtm_m = null }, units) {
  if (dsm_m === null) return { height: '', over_ground: '' };
  const over_m = dtm_m === null ? 0 : dsm_m - dtm_m;
  return { height: heightIn(dsm_m, units, [], units === 'metric' ? 2 : 1), over_ground: over_m > kStanding_m ? `+${heightIn(over_m, units)}` : '' };
}

/**
 * @param {MapView} view
 * @returns {{element: HTMLElement, of: (place: {lng: number, lat: number}) => void}} of: where the cursor is now
 */
export function heightReadout(view) {
  const words = strings.heights;
  const element = h('span', { class: 'mono coordinate-height', id: 'cursor-height', hidden: true });
  const show = (/** @type {SurfaceHeights|null} */ heights) => {
    const { height, over_ground } = readoutWords(heights ?? {}, chosenUnits());
    const aside = (/** @type {string} */ text) => h('span', { class: 'visually-hidden' }, text);
    element.hidden = height === '';
    if (element.hidden) put(element);
    else put(element, aside(`${words.here} `), height, over_ground && ` ${over_ground}`, over_ground && aside(` ${words.over_ground}`));
  };
  const asker = askAtRest(kCursorRest_ms, show);
  const drop = () => {
    asker.drop();
    show(null);
  };
  view.shown.addEventListener('change', drop);
  units_chosen.addEventListener('change', () => show(asker.answer));
  return {
    element,
    of({ lng, lat }) {
      const [west, south, east, north] = view.bounds ?? [0, 0, 0, 0];
      const lon = lonBeside(lng, (west + east) / 2);
      if (!view.heights.includes('dsm') || lon < west || lon > east || lat < south || lat > north) drop();
      else if (asker.about(`${lng},${lat}`, (signal) => getSurfaceHeights(view.flight_id, wrapLongitude(lng), lat, signal))) show(null);
    },
  };
}
