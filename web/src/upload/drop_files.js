// From the files that were dropped or chosen to a list of those worth sending. Each is judged by its name and its first
// bytes, so that a broken card or a stray document is told before anything is sent.
import { strings } from '../shared/strings.js';

/** @typedef {{file: File, path: string}} FoundFile */
/** @typedef {{file: File, name: string}} ChosenFile name: as sent to the server */
/** @typedef {{name: string, reason: string}} IgnoredFile */
/** @typedef {{chosen: ChosenFile[], ignored: IgnoredFile[], folder: string}} Selection */

const kPhotos = new Set(['jpg', 'jpeg', 'tif', 'tiff', 'png', 'dng']);
const kLogs = new Set(['csv', 'txt', 'log', 'bin', 'ulg', 'tlog', 'srt', 'ass', 'mrk', 'pos', 'json', 'gpx', 'kml', 'geojson', 'nmea']);
const kFilms = new Set(['mp4', 'mov']);
// What cameras write beside a film for their own screens, and films in other containers.
const kOtherFilms = new Set(['avi', 'mkv', 'lrf', 'lrv', 'ts']);
// The server unpacks these into the files in them.
const kArchiveName = /\.(zip|tar|tgz|tar\.gz)$/i;
// What network drives and systems keep in folders of their own: previews of each photo, deleted files.
const kFolderOfPrograms = /(^|\/)(@eadir|[@#]recycle|\$recycle\.bin|system volume information|__macosx)\//i;
const kOtherArchives = new Set(['7z', 'rar', 'gz', 'bz2', 'xz']);

/**
 * @param {string} name
 * @returns {string} lower case, without the dot
 */
function extension(name) {
  const dot = name.lastIndexOf('.');
  return dot < 0 ? '' : name.slice(dot + 1).toLowerCase();
}

/** @param {string} name @returns {boolean} whether the server opens it */
export const isArchive = (name) => kArchiveName.test(name);

/**
 * @param {Uint8Array} head the first bytes of a file
 * @returns {boolean} JPEG, TIFF (also DNG) or PNG
 */
export function looksLikePhoto(head) {
  const starts = (/** @type {number[]} */ ...bytes) => bytes.every((byte, i) => head[i] === byte);
  return (
    starts(0xff, 0xd8, 0xff) ||
    starts(0x49, 0x49, 0x2a, 0x00) ||
    starts(0x4d, 0x4d, 0x00, 0x2a) ||
    starts(0x49, 0x49, 0x2b, 0x00) ||
    starts(0x4d, 0x4d, 0x00, 0x2b) ||
    starts(0x89, 0x50, 0x4e, 0x47)
  );
}

/**
 * Chooses what to send. Hidden files of cameras and systems are passed over in silence.
 * @param {FoundFile[]} found
 * @returns {Promise<Selection>}
 */
export async function selectFiles(found) {
  /** @type {Selection} */
  const selection = { chosen: [], ignored: [], folder: commonFolder(found) };
  const taken = new Set();
  const reasons = strings.drop.reasons;
  const sorted = [...found].sort((a, b) => (a.path < b.path ? -1 : a.path > b.path ? 1 : 0));
  for (const { file, path } of sorted) {
    const name = path.slice(path.lastIndexOf('/') + 1);
    if (name.startsWith('.') || /^(thumbs\.db|desktop\.ini)$/i.test(name) || kFolderOfPrograms.test(path)) continue;
    const kind = extension(name);
    let reason = '';
    if (kOtherFilms.has(kind)) reason = reasons.film;
    else if (kOtherArchives.has(kind) && !isArchive(name)) reason = reasons.archive;
    else if (!kPhotos.has(kind) && !kFilms.has(kind) && !kLogs.has(kind) && !isArchive(name)) reason = reasons.kind;
    else if (file.size === 0) reason = reasons.empty;
    else if (kPhotos.has(kind) && !looksLikePhoto(new Uint8Array(await file.slice(0, 8).arrayBuffer()))) {
      reason = reasons.not_photo;
    }
    if (reason) {
      selection.ignored.push({ name: path, reason });
      continue;
    }
    const unique = uniqueName(path, taken);
    taken.add(unique.toLowerCase());
    selection.chosen.push({ file, name: unique });
  }
  return selection;
}

/**
 * Cameras start again at 0001 in each card folder; the folder's name then tells the photos apart.
 * @param {string} path
 * @param {Set<string>} taken names in use, in lower case
 * @returns {string}
 */
function uniqueName(path, taken) {
  const parts = path.split('/');
  for (let depth = 1; depth <= parts.length; depth += 1) {
    const name = parts.slice(-depth).join('_');
    if (!taken.has(name.toLowerCase())) return name;
  }
  for (let i = 2; ; i += 1) {
    const name = `${i}_${parts.join('_')}`;
    if (!taken.has(name.toLowerCase())) return name;
  }
}

/**
 * @param {FoundFile[]} found
 * @returns {string} the top folder that holds all, or ''
 */
function commonFolder(found) {
  const tops = new Set(found.map(({ path }) => (path.includes('/') ? path.slice(0, path.indexOf('/')) : '')));
  return tops.size === 1 ? [...tops][0] : '';
}
