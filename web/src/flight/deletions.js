// Deleting with a way back: the flight goes to the server's trash at once, so that it does not matter when the page is
// left, and "Undo" takes it out again. Where the server keeps no trash, a dialog confirms first.
/** @import { Flight, TrashedFlight } from '../shared/types.js' */
import { announce, showError, showNote } from '../shared/announce.js';
import { deleteFlight, getTrash, removeFlight, restoreFlight } from '../shared/api.js';
import { askToRemove } from '../shared/dialogs.js';
import { strings } from '../shared/strings.js';
import { held, uploadOf } from '../upload/drop_zone.js';
import { forgetUpload } from '../upload/upload_memory.js';
import { forgetChosen } from './job_options.js';
import { resumeUpload } from '../upload/uploads.js';

/** What was still to be sent for a flight that is gone for good. @param {string} id */
function forget(id) {
  forgetUpload(id);
  forgetChosen(id);
  held.delete(id);
}

/**
 * @param {{id: string, name: string}} flight
 * @param {() => void} on_change called when the flight is back
 * @returns {Promise<boolean>} whether it is
 */
export async function restore(flight, on_change) {
  let is_back = false;
  try {
    await restoreFlight(flight.id);
    is_back = true;
    announce(strings.flights.restored(flight.name));
  } catch (error) {
    showError(error);
  }
  on_change();
  return is_back;
}

/**
 * @param {Flight} flight
 * @param {() => void} on_change called when the flight is back
 * @returns {Promise<boolean>} whether it is deleted now
 */
export async function deleteWithUndo(flight, on_change) {
  const upload = uploadOf(flight.id);
  try {
    const { days } = await getTrash();
    if (days === 0 && !(await askToRemove(flight.name))) return false;
    upload?.stop({ tells: false });
    await deleteFlight(flight.id);
    if (days === 0) forget(flight.id);
    // An upload that the deletion broke off goes on.
    const takeBack = () => restore(flight, on_change).then((is_back) => is_back && upload && resumeUpload(upload));
    const undo = { label: strings.flights.undo, run: () => void takeBack() };
    showNote(days === 0 ? strings.trash.removed(flight.name) : strings.flights.removed(flight.name, days), {
      action: days === 0 ? undefined : undo,
    });
    return true;
  } catch (error) {
    showError(error);
    if (upload && !uploadOf(flight.id)) resumeUpload(upload);
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
    forget(flight.id);
    announce(strings.trash.removed(flight.name));
  } catch (error) {
    showError(error);
  }
  on_change();
}
