// The flights before a map's own over its ground, whose heights its own can be compared with.
/** @import { Flight } from '../shared/types.js' */
/** @import { MapView } from '../map/map_view.js' */
import { listFlights } from '../shared/api.js';
import { dayOf, overlap } from '../map/compare_view.js';

/** @param {Flight} flight */
export const nameWithDay = (flight) => `${flight.name}, ${dayOf(flight)}`;

/** @param {Flight} flight */
const whenOf = (flight) => Date.parse(flight.captured?.first ?? flight.created_at);

/** Of the map that is shown, asked once for all who want them. @type {WeakMap<MapView, {about: string, flights: Promise<Flight[]>}>} */
const asked = new WeakMap();

/** @param {MapView} view @returns {Promise<Flight[]>} with a map of common ground, the latest first; whether they have heights is not known */
async function findEarlier({ flight_id, bounds }) {
  const flights = await listFlights();
  const own = flights.find(({ id }) => id === flight_id);
  if (!own || !bounds) return [];
  return flights
    .filter((other) => other.id !== flight_id && overlap({ bounds }, other) && whenOf(other) <= whenOf(own))
    .sort((a, b) => whenOf(b) - whenOf(a));
}

/** Who cannot list flights compares with none. @param {MapView} view @returns {Promise<Flight[]>} */
export function earlierFlights(view) {
  const about = JSON.stringify([view.flight_id, view.bounds]);
  const before = asked.get(view);
  if (before?.about === about) return before.flights;
  const flights = findEarlier(view).catch(() => {
    asked.delete(view);
    return [];
  });
  asked.set(view, { about, flights });
  return flights;
}
