// The ground's height along a measured distance: asked of the server when the line rests, drawn below the measurement.
/** @import { Flight, GroundProfile } from '../shared/types.js' */
/** @import { LonLat } from '../map/geodesy.js' */
/** @import { MapView } from '../map/map_view.js' */
/** @import { Units } from '../shared/units.js' */
import { ApiError, getHeights } from '../shared/api.js';
import { h, put } from '../shared/dom.js';
import { isImported } from '../flight/flight_words.js';
import { strings } from '../shared/flight_strings.js';
import { heightIn } from '../shared/units.js';
import { heightChart } from './height_chart.js';

const kRest_ms = 250;  // so long a line that is moved by keys must rest

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
  let asked = '';  // for this line, its answer is there or on its way
  /** @type {GroundProfile|null} */
  let profile = null;
  let timer = 0;
  let abort = new AbortController();
  /** @type {ReturnType<MapView['addMark']>|null} */
  let mark = null;

  const markPlace = (/** @type {{lon: number, lat: number}|null} */ place) => {
    if (!place) {
      mark?.remove();
      mark = null;
      return;
    }
    if (mark) mark.setLngLat([place.lon, place.lat]);
    else {
      mark = view.addMark(h('span', { class: 'height-mark' }), [place.lon, place.lat], 0, null);
      mark.getElement().setAttribute('aria-hidden', 'true');
      mark.getElement().removeAttribute('tabindex');
      mark.getElement().removeAttribute('role');
      mark.getElement().removeAttribute('aria-label');
    }
  };
  const say = (/** @type {string} */ text) => put(element, h('p', { class: 'muted fine', id: 'heights-message' }, text));
  const drop = () => {
    clearTimeout(timer);
    abort.abort();
    markPlace(null);
    asked = '';
    profile = null;
  };
  const draw = (/** @type {Units} */ units) => {
    if (!profile) return;
    markPlace(null);
    const { lowest_m, highest_m, climb_m, descent_m } = profile;
    if (profile.ground === 'plane') {
      say(words.level);
      return;
    }
    if (lowest_m === null || highest_m === null) {
      say(words.beside);
      return;
    }
    const figure = (/** @type {string} */ label, /** @type {number} */ value) => h('div', {}, h('dt', {}, label), h('dd', {}, heightIn(value, units)));
    put(
      element,
      h('h3', { class: 'heights-title' }, words.heading),
      heightChart(profile, units, markPlace),
      h('dl', { class: 'heights-figures', id: 'heights-figures' }, figure(words.lowest, lowest_m), figure(words.highest, highest_m), figure(words.climb, climb_m), figure(words.descent, descent_m)),
      h('p', { class: 'fine muted' }, words.zero),
    );
  };
  const ask = async (/** @type {LonLat[]} */ places, /** @type {Units} */ units) => {
    if (!flight) return;
    abort = new AbortController();
    const { signal } = abort;
    try {
      const found = await getHeights(flight.id, places, signal);
      if (signal.aborted) return;
      profile = found;
      draw(units);
    } catch (error) {
      if (signal.aborted) return;
      asked = '';  // the next change asks again
      if (error instanceof ApiError && error.status === 404) {
        knows_heights = false;
        say(words.none);
      } else say(error instanceof Error ? error.message : String(error));
    }
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
    show(places, units) {
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
      const line = JSON.stringify(places);
      if (line === asked) {
        draw(units);
        return;
      }
      drop();
      asked = line;
      if (!element.firstChild) say(words.waiting);
      timer = window.setTimeout(() => void ask(places, units), kRest_ms);
    },
  };
}
