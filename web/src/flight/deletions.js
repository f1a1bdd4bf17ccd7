// Deleting with a way back: the flight goes to the server's trash at once, so that it does not matter when the page is
// left, and "Undo" takes it out again. Where the server keeps no trash, a dialog confirms first.
/** @import { Flight, TrashedFlight } from '../shared/types.js' */
import { announce, showError, showNote } from '../shared/announce.js';
import { deleteFlight, getTrash, removeFlight, restoreFlight } from '../shared/api.js';
import { askToRemove } from '../shared/dialogs.js';
import { strings } from '../shared/strings.js';
import { uploadOf } from '../upload/uploads.js';

/**
 * @param {{id: string, name: string}} flight
 * @param {() => void} on_change called when the flight is back
 */
export async function restore(flight, on_change) {
  try {
    await restoreFlight(flight.id);
    announce(strings.flights.restored(flight.name));
  } catch (error) {
    showError(error);
  }
  on_change();
}

/**
 * @param {Flight} flight
 * @param {() => void} on_change called when the flight is back
 * @returns {Promise<boolean>} whether it is deleted now
 */
export async function deleteWithUndo(flight, on_change) {
  try {
    const { days } = await getTrash();
    if (days === 0 && !(await askToRemove(flight.name))) return false;
    uploadOf(flight.id)?.stop();
    await deleteFlight(flight.id);
    const undo = { label: strings.flights.undo, run: () => void restore(flight, on_change) };
    showNote(days === 0 ? strings.trash.removed(flight.name) : strings.flights.removed(flight.name, days), {
      action: days === 0 ? undefined : undo,
    });
    return true;
  } catch (error) {
    showError(error);
    return false;
  }
}

/**
 * @param {TrashedFlight} flight
 * @param {() => void} on_change called when it is gone
 */
export async function removeForGood(flight, on_change) {
  if (!(await askToRemove(flight.name))) return;
  try {
    await removeFlight(flight.id);
    announce(strings.trash.removed(flight.name));
  } catch (error) {
    showError(error);
  }
  on_change();
}
