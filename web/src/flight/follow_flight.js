// Follows what happens to a flight by the server's events. The browser comes back by itself after a broken link and
// gets what it missed.
/** @import { Bounds } from '../shared/types.js' */
import { readable } from '../shared/token.js';

/**
 * @typedef {object} Growth the preview of a flight has changed
 * @property {number} edition
 * @property {number} photos
 * @property {Bounds} bounds
 * @property {Bounds} changed where
 */

/**
 * @param {string} flight_id
 * @param {{on_preview: (growth: Growth) => void, on_map: () => void}} listener
 * @returns {() => void} ends it
 */
export function followFlight(flight_id, listener) {
  const events = new EventSource(readable(`/api/v1/events?flight=${encodeURIComponent(flight_id)}`));
  events.addEventListener('preview', (event) => listener.on_preview(JSON.parse(event.data).preview));
  events.addEventListener('map', () => listener.on_map());
  return () => events.close();
}
