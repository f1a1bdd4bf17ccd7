// The other flights of a map's ground, whose heights its own can be compared with.
/** @import { Flight } from '../shared/types.js' */
/** @import { MapView } from '../map/map_view.js' */
import { listFlights } from '../shared/api.js';
import { dayOf, overlap } from '../map/compare_view.js';

/** @param {Flight} flight */
export const nameWithDay = (flight) => `${flight.name}, ${dayOf(flight)}`;

/**
 * Whether a flight has heights is said by who is asked for them.
 * @param {MapView} view
 * @returns {Promise<Flight[]>} with a map of common ground
 */
export async function otherFlights(view) {
  const { bounds, flight_id } = view;
  return bounds ? (await listFlights()).filter((other) => other.id !== flight_id && overlap({ bounds }, other)) : [];
}
