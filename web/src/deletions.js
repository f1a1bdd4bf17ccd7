// Deleting with a way back: the flight vanishes from the page at once, and from the server when the note with
// "Undo" has gone (or the page is left).
/** @import { Flight } from './types.js' */
import { authorization } from './access.js';
import { announce, showError, showNote } from './announce.js';
import { deleteFlight } from './api.js';
import { strings } from './strings.js';
import { uploadOf } from './uploads.js';

/** @type {Set<string>} */
const pending = new Set();

/** @param {string} id */
export const isDeleted = (id) => pending.has(id);

/**
 * @param {Flight} flight
 * @param {() => void} on_change called when the flight vanishes, returns, or is gone for good
 */
export function deleteWithUndo(flight, on_change) {
  uploadOf(flight.id)?.stop();
  pending.add(flight.id);
  let undone = false;
  showNote(strings.flights.removed(flight.name), {
    action: {
      label: strings.flights.undo,
      run: () => {
        undone = true;
        pending.delete(flight.id);
        announce(strings.flights.restored(flight.name));
        on_change();
      },
    },
    on_close: async () => {
      if (undone) return;
      try {
        await deleteFlight(flight.id);
      } catch (error) {
        showError(error);
      }
      pending.delete(flight.id);
      on_change();
    },
  });
  on_change();
}

addEventListener('pagehide', () => {
  // The user left before the note closed: the deletion was meant.
  for (const id of pending) {
    void fetch(`/api/v1/flights/${encodeURIComponent(id)}`, { method: 'DELETE', keepalive: true, headers: authorization() });
  }
});
