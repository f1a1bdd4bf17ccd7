// Follows what happens to a flight by the server's events. The browser comes back by itself after a broken link and
// gets what it missed; after an answer that is none of the server's, as of a proxy before it, the page does.
/** @import { Bounds } from '../shared/types.js' */
import { ApiError, getFlight } from '../shared/api.js';
import { readable } from '../shared/token.js';

const kPauses_ms = [2000, 10_000, 30_000, 120_000];

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
  const over = new AbortController();
  let tries = 0;
  let last_id = '';  // of an event: what came after it is sent again
  const open = () => {
    const after = last_id && `&after=${last_id}`;
    const events = new EventSource(readable(`/api/v1/events?flight=${encodeURIComponent(flight_id)}${after}`));
    over.signal.addEventListener('abort', () => events.close());
    events.addEventListener('open', () => (tries = 0));
    events.addEventListener('preview', (event) => {
      last_id = event.lastEventId;
      listener.on_preview(JSON.parse(event.data).preview);
    });
    events.addEventListener('map', () => listener.on_map());
    events.addEventListener('error', () => {
      if (events.readyState === EventSource.CLOSED) askLater();
    });
  };
  const askLater = () => {
    if (tries === kPauses_ms.length) return;
    const timer = setTimeout(() => void askAgain(), kPauses_ms[tries]);
    over.signal.addEventListener('abort', () => clearTimeout(timer));
    tries += 1;
  };
  // Events do not say why they ended: the flight itself may be gone, or have its map meanwhile.
  const askAgain = async () => {
    try {
      const { tilejson } = await getFlight(flight_id, over.signal);
      if (over.signal.aborted) return;
      if (tilejson) listener.on_map();
      else open();
    } catch (error) {
      if (!over.signal.aborted && error instanceof ApiError && error.is_passing) askLater();
    }
  };
  open();
  return () => over.abort();
}
