// What the first view does without: an open flight, its map, uploads and dialogs. Loaded as one when the first of them
// is wanted; index.html names their files, so that none waits for another to be read.
export { FlightView } from './flight/flight_view.js';
export { Stage } from './map/stage.js';
export { bottomSheet } from './shared/sheet.js';
export { askName, askWhereTo } from './shared/dialogs.js';
export { deleteWithUndo, removeForGood, restore } from './flight/deletions.js';
export { showShareDialog } from './sharing/share_dialog.js';
export { headOf } from './upload/drop_files.js';
export { startUpload } from './upload/uploads.js';
export { glanceAtPhoto, kHeadBytes } from './upload/exif_reader.js';
export { nearestPlace } from './upload/nearest_place.js';
