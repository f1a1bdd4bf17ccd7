// From the files that were dropped or chosen to a list of those worth sending. Each is judged by its name and its first
// bytes, so that a broken card or a stray document is told before anything is sent.
import { strings } from '../shared/strings.js';

/** @typedef {{file: File|null, path: string}} FoundFile file: null where it cannot be read; path: of a folder with a stroke behind it */
/** @typedef {{file: File, name: string}} ChosenFile name: as sent to the server */
/** @typedef {{name: string, reason: string}} IgnoredFile */
/** @typedef {{chosen: ChosenFile[], ignored: IgnoredFile[], folder: string}} Selection */

const kPhotos = new Set(['jpg', 'jpeg', 'tif', 'tiff', 'png', 'dng']);
// As phones and cameras write them too; the server opens none of these.
const kOtherPhotos = new Set(['heic', 'heif', 'hif', 'avif', 'webp', 'jxl', 'raw', 'arw', 'cr2', 'cr3', 'nef', 'nrw', 'orf', 'raf', 'rw2', 'pef', 'srw', 'iiq', 'gpr']);
const kLogs = new Set(['csv', 'tsv', 'txt', 'log', 'bin', 'ulg', 'tlog', 'srt', 'ass', 'mrk', 'pos', 'json', 'gpx', 'kml', 'geojson', 'nmea', 'xmp']);
const kFilms = new Set(['mp4', 'mov']);
// What cameras write beside a film for their own screens, and films in other containers.
const kOtherFilms = new Set(['avi', 'mkv', 'lrf', 'lrv', 'ts']);
// The server unpacks these into the files in them.
const kArchiveName = /\.(zip|tar|tgz|tar\.gz)$/i;
// So many of a file's folders stand in front of its name at most.
const kMaxFolders = 8;
// What network drives and systems keep in folders of their own, hidden ones too: previews of each photo, deleted files.
const kFolderOfPrograms = /(^|\/)(\.[^/]*|@eadir|[@#]recycle|\$recycle\.bin|system volume information|__macosx)\//i;
// What `skyquilt stitch` makes beside its mosaic.state, as server/jobs/out_folder.cc names it; frames lie below.
const kMapProduct = /^(mosaic\..+|mosaic_utm\.tif|thumbnail\.png|(report|locate|cameras|layers)\.json|photos\.geojson|geo\.txt|bands\.tif|(dsm|dtm)(_photos|_ground|_hillshade)?\.tif|contours\..+|layer_\w+\.mbtiles)$/;
// Tables as office programs save them by themselves.
const kOffice = new Set(['xlsx', 'xlsm', 'xls', 'ods', 'numbers']);
const kOtherArchives = new Set(['7z', 'rar', 'gz', 'bz2', 'tbz2', 'xz', 'txz', 'zst']);

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

/** @param {string} name @returns {boolean} of what was flown: a list, a log, a sidecar */
export const isLog = (name) => kLogs.has(extension(name));

/** @param {string} name @returns {boolean} whether the server makes photos of its frames */
export const isFilm = (name) => kFilms.has(extension(name));

/**
 * @param {Blob} file
 * @param {number} bytes
 * @returns {Promise<ArrayBuffer>} its first ones; none where it cannot be read, as of a card that was taken out
 */
export const headOf = (file, bytes) => file.slice(0, bytes).arrayBuffer().catch(() => new ArrayBuffer(0));

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
  const reasons = strings.drop.reasons;
  const folderOf = (/** @type {string} */ path) => path.slice(0, path.lastIndexOf('/') + 1);
  const foldersWith = (/** @type {RegExp} */ mark) => new Set(found.map(({ path }) => path).filter((path) => mark.test(path)).map(folderOf));
  const maps = foldersWith(/(^|\/)mosaic\.state$/);
  const frames = foldersWith(/\/frames\/frames\.json$/); // a folder of frames that is chosen itself counts
  const sorted = [...found].sort((a, b) => (a.path < b.path ? -1 : a.path > b.path ? 1 : 0));
  for (const { file, path } of sorted) {
    const name = path.slice(path.lastIndexOf('/') + 1);
    if (name.startsWith('.') || /^(thumbs\.db|desktop\.ini)$/i.test(name) || kFolderOfPrograms.test(path)) continue;
    if (frames.has(folderOf(path)) || (maps.has(folderOf(path)) && kMapProduct.test(name))) continue;
    if (!file) {
      selection.ignored.push({ name: path, reason: reasons.unread });
      continue;
    }
    const kind = extension(name);
    let reason = '';
    if (kOtherFilms.has(kind)) reason = reasons.film;
    else if (kOtherPhotos.has(kind)) reason = reasons.photo;
    else if (kOtherArchives.has(kind) && !isArchive(name)) reason = reasons.archive;
    else if (kOffice.has(kind)) reason = reasons.office;
    else if (!kPhotos.has(kind) && !isFilm(name) && !kLogs.has(kind) && !isArchive(name)) reason = reasons.kind;
    else if (file.size === 0) reason = reasons.empty;
    else if (kPhotos.has(kind)) {
      const head = await headOf(file, 8);
      reason = head.byteLength === 0 ? reasons.unread : looksLikePhoto(new Uint8Array(head)) ? '' : reasons.not_photo;
    }
    if (reason) {
      selection.ignored.push({ name: path, reason });
      continue;
    }
    selection.chosen.push({ file, name: path });
  }
  const names = namesApart(selection.chosen.map(({ name }) => name));
  selection.chosen.forEach((one, i) => (one.name = names[i]));
  return selection;
}

/**
 * Cameras start again at 0001 in each card folder; the folder's name then tells the photos apart. A list beside such
 * photos keeps it too, for it counts for these; a sidecar is called as its photo. As core/base/text/file_names.cc names
 * files.
 * @param {string[]} paths
 * @returns {string[]} a name for each, all different
 */
export function namesApart(paths) {
  const split = paths.map((path) => path.split('/')).map((parts) => ({ folders: parts.slice(0, -1), name: parts[parts.length - 1] }));
  const key = (/** @type {{folders: string[]}} */ { folders }) => folders.join('/');
  /** @type {Map<string, string>} */
  const first_folder = new Map();
  const doubled = new Set();
  for (const one of split) {
    const plain = one.name.toLowerCase();
    if (!first_folder.has(plain)) first_folder.set(plain, key(one));
    else if (first_folder.get(plain) !== key(one)) doubled.add(plain);
  }
  const isDoubled = (/** @type {{name: string}} */ { name }) => doubled.has(name.toLowerCase());
  const labels = labelsOf(new Map(split.filter(isDoubled).map((one) => [key(one), one.folders])));
  const companyOf = (/** @type {{folders: string[], name: string}} */ one) => `${key(one)}/${one.name.split('.')[0].toLowerCase()}`;
  /** @type {Map<string, boolean>} */
  const is_photo_doubled = new Map();
  for (const one of split) {
    if (!kPhotos.has(extension(one.name))) continue;
    is_photo_doubled.set(companyOf(one), isDoubled(one) || (is_photo_doubled.get(companyOf(one)) ?? false));
  }
  const taken = new Set();
  return split.map((one) => {
    const label = isDoubled(one) || (is_photo_doubled.get(companyOf(one)) ?? true) ? labels.get(key(one)) ?? [] : [];
    const own = [...label, one.name].join('_');
    const dot = own.lastIndexOf('.');
    let name = own;
    for (let i = 2; taken.has(name); i += 1) name = dot > 0 ? `${own.slice(0, dot)}(${i})${own.slice(dot)}` : `${own}(${i})`;
    taken.add(name);
    return name;
  });
}

/**
 * @param {Map<string, string[]>} folders parts of paths
 * @returns {Map<string, string[]>} of each the last parts that tell it from the others
 */
function labelsOf(folders) {
  /** @type {Map<string, string[]>} */
  const labels = new Map();
  let open = [...folders.keys()];
  for (let parts = 1; parts <= kMaxFolders && open.length > 0; parts += 1) {
    /** @type {Map<string, number>} */
    const times = new Map();
    const word = (/** @type {string} */ folder) => (labels.get(folder) ?? []).join('/').toLowerCase();
    for (const folder of open) {
      labels.set(folder, (folders.get(folder) ?? []).slice(-parts));
      times.set(word(folder), (times.get(word(folder)) ?? 0) + 1);
    }
    open = open.filter((folder) => times.get(word(folder)) !== 1);
  }
  return labels;
}

/**
 * @param {FoundFile[]} found
 * @returns {string} the top folder that holds all, or ''
 */
function commonFolder(found) {
  const tops = new Set(found.map(({ path }) => (path.includes('/') ? path.slice(0, path.indexOf('/')) : '')));
  return tops.size === 1 ? [...tops][0] : '';
}
