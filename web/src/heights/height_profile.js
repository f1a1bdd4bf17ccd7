// Heights along a measured distance, of what the photos show or of the smooth ground: asked of the server when the line
// rests, drawn below the measurement.
/** @import { Flight, GroundProfile } from '../shared/types.js' */
/** @import { LonLat } from '../map/geodesy.js' */
/** @import { MapView } from '../map/map_view.js' */
/** @import { Units } from '../shared/units.js' */
import { ApiError, getHeights, messageOf } from '../shared/api.js';
import { h, put } from '../shared/dom.js';
import { isImported } from '../flight/flight_words.js';
import { onEarth } from '../map/coordinates.js';
import { strings } from '../shared/flight_strings.js';
import { chosenUnits, heightIn } from '../shared/units.js';
import { askAtRest, kRest_ms } from './ask_at_rest.js';
import { figureList } from './figures.js';
import { heightChart } from './height_chart.js';
import { drawnProfile } from './surface_profile.js';

/**
 * @param {MapView} view
 * @returns {{element: HTMLElement, of: (flight: Flight|null) => void, show: (places: LonLat[], units: Units) => void}}
 *   of: whose ground it is; null: nobody's. show: fewer than two places take it away
 */
export function heightProfile(view) {
  const words = strings.heights;
  const element = h('section', { class: 'heights', id: 'heights', 'aria-label': words.heading, hidden: true });
  /** @type {Flight|null} */
  let flight = null;
  let knows_heights = true;
  /** @type {Units} */
  let units = chosenUnits();
  /** @type {ReturnType<MapView['addMark']>|null} */
  let mark = null;

  const markPlace = (/** @type {{lon: number, lat: number}|null} */ place) => {
    if (!place) {
      mark?.remove();
      mark = null;
      return;
    }
    if (mark) mark.setLngLat([place.lon, place.lat]);
    else mark = view.addMark(h('span', { class: 'height-mark', 'aria-hidden': 'true' }), [place.lon, place.lat], 0, null);
  };
  const say = (/** @type {string} */ text) => put(element, h('p', { class: 'muted fine', id: 'heights-message' }, text));
  const asker = askAtRest(kRest_ms, (/** @type {GroundProfile|null} */ found, /** @type {unknown} */ error) => {
    if (found) {
      draw();
      return;
    }
    if (error instanceof ApiError && error.status === 404) {
      knows_heights = false;
      say(words.none);
    } else say(messageOf(error));
  });
  const drop = () => {
    asker.drop();
    markPlace(null);
  };
  const draw = () => {
    if (!asker.answer) return;
    markPlace(null);
    const profile = drawnProfile(asker.answer);
    const { lowest_m, highest_m, climb_m, descent_m } = profile;
    if (profile.is_level) {
      say(words.level);
      return;
    }
    if (lowest_m === null || highest_m === null) {
      say(words.beside);
      return;
    }
    const figure = (/** @type {string} */ label, /** @type {number} */ value) => /** @type {[string, string]} */ ([label, heightIn(value, units)]);
    put(
      element,
      h('h3', { class: 'heights-title' }, words.heading),
      heightChart(profile, units, markPlace),
      figureList('heights-figures', [figure(words.lowest, lowest_m), figure(words.highest, highest_m), figure(words.climb, climb_m), figure(words.descent, descent_m)]),
      h('p', { class: 'fine muted' }, words.zero),
    );
  };

  return {
    element,
    of(next) {
      if (next?.id !== flight?.id || next?.revision !== flight?.revision) {
        drop();
        knows_heights = !next || !isImported(next);
      }
      flight = next;
    },
    show(places, next_units) {
      units = next_units;
      element.hidden = places.length < 2 || !flight;
      if (element.hidden || !flight) {
        drop();
        put(element);
        return;
      }
      if (!knows_heights) {
        say(words.none);
        return;
      }
      const { id } = flight;
      if (!asker.about(JSON.stringify(places), (signal) => getHeights(id, places.map(onEarth), signal))) {
        draw();
        return;
      }
      markPlace(null);
      if (!element.firstChild) say(words.waiting);
    },
  };
}
