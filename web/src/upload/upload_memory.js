// What this browser was to send for a flight, kept until its map is begun: so that after a stop, a deletion taken back
// or a reload the page can tell from the server's own list what is still missing there.
/** @import { StoredFile } from '../shared/types.js' */
import { dropChoice } from '../shared/language.js';
import { isArchive } from './drop_files.js';

const key = (/** @type {string} */ flight_id) => `skyquilt.upload.${flight_id}`;

/** @param {string} flight_id @returns {Map<string, number>} name to size */
function read(flight_id) {
  try {
    return new Map(JSON.parse(localStorage.getItem(key(flight_id)) ?? '[]'));
  } catch {
    return new Map();  // written by something else
  }
}

/**
 * @param {string} flight_id
 * @param {{name: string, file: File|Blob}[]} files more of them
 */
export function rememberUpload(flight_id, files) {
  const kept = read(flight_id);
  for (const { name, file } of files) kept.set(name, file.size);
  keep(flight_id, kept);
}

/** @param {string} flight_id @param {Map<string, number>} kept */
function keep(flight_id, kept) {
  try {
    localStorage.setItem(key(flight_id), JSON.stringify([...kept]));
  } catch {
    // A browser without room only forgets: the page then says what the server has, and not what it lacks.
  }
}

/**
 * @param {string} flight_id
 * @param {string} before
 * @param {string} name that the file has in the flight
 */
export function rememberName(flight_id, before, name) {
  const kept = read(flight_id);
  const bytes = kept.get(before);
  if (bytes === undefined) return;
  kept.delete(before);
  kept.set(name, bytes);
  keep(flight_id, kept);
}

/** @param {string} flight_id */
export const forgetUpload = (flight_id) => dropChoice(key(flight_id));

/**
 * @param {string} flight_id
 * @param {StoredFile[]} stored what the server has
 * @returns {{files: number, missing: string[]}|null} null where this browser does not know what was to be sent
 */
export function whatIsMissing(flight_id, stored) {
  const wanted = read(flight_id);
  // Of an archive the server has the files in it.
  if (wanted.size === 0 || [...wanted.keys()].some(isArchive)) return null;
  const there = new Map(stored.map(({ name, bytes }) => [name, bytes]));
  return { files: wanted.size, missing: [...wanted].filter(([name, bytes]) => there.get(name) !== bytes).map(([name]) => name) };
}
