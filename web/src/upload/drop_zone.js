// The whole window takes files: dropped anywhere, or chosen by the buttons of the welcome and of the flight. Folders are
// walked to the bottom. And which uploads this page has under way or holds stopped, by flight: apart from what runs them,
// so that the list of flights knows of them without loading what sends files.
/** @import { FoundFile, Selection } from './drop_files.js' */
/** @import { UploadSession } from './uploads.js' */
import { showError, showNote } from '../shared/announce.js';
import { byId, h, put } from '../shared/dom.js';
import { icon } from '../shared/icons.js';
import { strings } from '../shared/strings.js';

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

/** @returns {boolean} whether leaving the page would break an upload, or leave no one to begin its map */
export const isUploading = () => [...sessions.values()].some(({ queue, trouble }) => trouble !== '' || queue.picture.state === 'running');

/** @typedef {'new'|'add'|''} Wish a flight of its own; more of the one that is open; '' where nobody said */

/**
 * @param {(selection: Selection, wish: Wish) => void} on_files
 * @returns {{choose_folder: () => void, choose_files: () => void, new_flight: () => void, add_photos: () => void}}
 */
export function dropZone(on_files) {
  const cover = byId('drop-cover');
  put(cover, h('div', { class: 'drop-cover-inner' }, icon('upload'), h('p', {}, strings.drop.drop_here)));
  // dragenter and dragleave also come from every element inside; the cover goes when none is left.
  let depth = 0;
  const holdsFiles = (/** @type {DragEvent} */ event) => event.dataTransfer?.types.includes('Files') ?? false;
  const showCover = (/** @type {boolean} */ visible) => {
    cover.hidden = !visible;
    if (!visible) depth = 0;
  };
  addEventListener('dragenter', (event) => {
    if (!holdsFiles(event)) return;
    depth += 1;
    showCover(true);
  });
  addEventListener('dragleave', (event) => {
    if (!holdsFiles(event)) return;
    depth -= 1;
    if (depth <= 0) showCover(false);
  });
  addEventListener('dragover', (event) => {
    if (!holdsFiles(event) || !event.dataTransfer) return;
    event.preventDefault();
    event.dataTransfer.dropEffect = 'copy';
  });
  addEventListener('drop', (event) => {
    if (!event.dataTransfer || !holdsFiles(event)) return;
    event.preventDefault();
    showCover(false);
    take(filesOfDrop(event.dataTransfer), '');
  });

  /** @param {Promise<FoundFile[]>|FoundFile[]} found @param {Wish} wish */
  const take = async (found, wish) => {
    const close = showNote(strings.drop.reading, { duration_ms: 600_000 });
    try {
      const { selectFiles } = await import('./drop_files.js');
      const selection = await selectFiles(await found);
      close();
      if (selection.chosen.length > 0) on_files(selection, wish);
      else showNote([strings.drop.nothing, ...new Set(selection.ignored.map(({ reason }) => reason))].join(' '), { is_error: true });
    } catch (error) {
      close();
      showError(error);
    }
  };

  /** @type {Wish} of who opened the browser's dialog last */
  let wished = '';
  const input = (/** @type {boolean} */ is_folder) => {
    const element = h('input', { type: 'file', multiple: true, hidden: true, id: is_folder ? 'folder-input' : 'files-input', webkitdirectory: is_folder });
    element.addEventListener('change', () => {
      const found = filesOfInput(element.files ?? new DataTransfer().files);
      element.value = '';
      if (found.length > 0) void take(found, wished);
      wished = '';
    });
    document.body.append(element);
    return element;
  };
  const folder_input = input(true);
  const files_input = input(false);
  const choose = (/** @type {HTMLInputElement} */ from, /** @type {Wish} */ wish) => () => {
    wished = wish;
    from.click();
  };
  return { choose_folder: choose(folder_input, ''), choose_files: choose(files_input, ''), new_flight: choose(folder_input, 'new'), add_photos: choose(folder_input, 'add') };
}

/**
 * All files of a drop. The items must be taken before the first await: the browser empties them afterwards.
 * @param {DataTransfer} transfer
 * @returns {Promise<FoundFile[]>}
 */
export async function filesOfDrop(transfer) {
  const roots = [...transfer.items]
    .filter((item) => item.kind === 'file')
    .map((item) => ({ entry: item.webkitGetAsEntry?.() ?? null, file: item.getAsFile() }));
  /** @type {FoundFile[]} */
  const found = [];
  for (const { entry, file } of roots) {
    if (entry) await walk(entry, found);
    else if (file) found.push({ file, path: file.name });
  }
  return found;
}

/**
 * @param {FileSystemEntry} entry
 * @param {FoundFile[]} found
 */
async function walk(entry, found) {
  const path = entry.fullPath.replace(/^\//, '');
  // A card has folders of the system's that nobody may read: what else there is counts all the same.
  const unread = (/** @type {unknown} */ error) => {
    console.debug(path, error);
    return null;
  };
  if (entry.isFile) {
    const file_entry = /** @type {FileSystemFileEntry} */ (entry);
    found.push({ file: await new Promise((resolve, reject) => file_entry.file(resolve, reject)).catch(unread), path });
    return;
  }
  const reader = /** @type {FileSystemDirectoryEntry} */ (entry).createReader();
  for (;;) {
    // readEntries gives at most a hundred at a time and an empty list at the end.
    const entries = await new Promise((resolve, reject) => reader.readEntries(resolve, reject)).catch(unread);
    if (!entries) found.push({ file: null, path: `${path}/` });
    if (!entries || entries.length === 0) return;
    for (const child of entries) await walk(child, found);
  }
}

/**
 * @param {FileList} list of an <input type="file">
 * @returns {FoundFile[]}
 */
function filesOfInput(list) {
  return [...list].map((file) => ({ file, path: file.webkitRelativePath || file.name }));
}
