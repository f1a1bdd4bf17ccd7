// Which uploads this page has under way or holds stopped, by flight. Apart from what runs them, so that the list of
// flights knows of them without loading what sends files.
/** @import { UploadSession } from './uploads.js' */

/** @type {Map<string, UploadSession>} */
export const sessions = new Map();
/** @type {Map<string, UploadSession>} */
export const held = new Map();

/**
 * @param {string} flight_id
 * @returns {UploadSession|undefined} the upload under way
 */
export const uploadOf = (flight_id) => sessions.get(flight_id);

/**
 * @param {string} flight_id
 * @returns {UploadSession|undefined} one that was stopped and can go on: this page still has its files
 */
export const stoppedUploadOf = (flight_id) => held.get(flight_id);

/** @returns {boolean} whether this page has files that it would have to be given again */
export const holdsUploads = () => sessions.size > 0 || held.size > 0;

/** @returns {boolean} whether leaving the page would break an upload */
export const isUploading = () => [...sessions.values()].some(({ queue }) => queue.picture.state === 'running');
