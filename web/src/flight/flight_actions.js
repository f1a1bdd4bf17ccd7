// What one does with a finished map, in a row: share it, download it, open it in QGIS.
/** @import { Flight } from '../shared/types.js' */
import { readable, withToken } from '../shared/token.js';
import { showError } from '../shared/announce.js';
import { downloadPath, downloadSize, getBands, getReport, startExport } from '../shared/api.js';
import { at } from '../shared/router.js';
import { showDialog } from '../shared/dialogs.js';
import { h, put } from '../shared/dom.js';
import { formatBytes } from '../shared/format.js';
import { button, icon, runOnce } from '../shared/icons.js';
import { strings } from '../shared/flight_strings.js';
import { mayChange } from './flight_words.js';
import { tokenForPrograms } from '../sharing/links_view.js';

/**
 * @param {Flight} flight with a map
 * @param {(flight: Flight) => void} share
 * @param {() => import('../map/outlines.js').Outline[]} outlines that are on the map
 * @returns {HTMLElement}
 */
export function flightActions(flight, share, outlines) {
  const words = strings.actions;
  return h(
    'div',
    { class: 'row flight-actions no-print' },
    mayChange(flight) && button(strings.share.action, () => share(flight), { picture: 'share', id: 'flight-share' }),
    button(words.download, () => showDownloads(flight, outlines()), { picture: 'download', id: 'flight-download' }),
    button(words.qgis, () => showQgis(flight), { picture: 'layers', id: 'flight-qgis' }),
  );
}

/** What is made when somebody wants it, as the server takes it. @type {Record<'utm'|'report'|'kmz', import('../shared/api.js').ExportWish>} */
const kWishes = { utm: { format: 'geotiff', crs: 'utm' }, report: { format: 'report' }, kmz: { format: 'kmz' } };

/**
 * @param {Flight} flight
 * @param {import('../map/outlines.js').Outline[]} outlines
 * @param {{cut_to?: number, wish?: import('../shared/api.js').ExportWish|null}} [at_once] cut_to: which of the outlines an export is
 *   to be cut to: it alone is asked for; wish: what is made without further question
 */
export function showDownloads(flight, outlines, { cut_to = -1, wish: wanted = null } = {}) {
  const words = strings.actions;
  const link = (/** @type {import('../shared/api.js').DownloadName} */ name) => {
    const [title, hint] = { ...words.files, ...words.band_files, ...words.height_files }[name];
    const small = h('small', {}, hint);
    const has_size = downloadSize(flight.id, name).then((bytes) => {
      if (bytes !== null) small.textContent = `${formatBytes(bytes)}, ${hint}`;
      return bytes !== null;
    });
    return { made: h('a', { class: 'download', href: readable(downloadPath(flight.id, name)), download: '' }, icon('download'), h('span', {}, title), small), has_size };
  };
  const namesIn = (/** @type {object} */ files) => /** @type {import('../shared/api.js').DownloadName[]} */ (Object.keys(files));
  const closed = new AbortController();
  const exports = h('div', { class: 'export-part' });
  const showExports = (/** @type {HTMLButtonElement} */ pressed, /** @type {import('../shared/api.js').ExportWish|null} */ wish) => runOnce(pressed, async () => {
    const { exportView } = await import('./export_view.js');
    if (wish) await startExport(flight.id, wish);  // one that is there already is what this gives
    downloads.remove();  // the exports themselves would be out of sight below
    put(exports, exportView(flight, outlines, closed.signal, cut_to, wish !== null));
    if (!wish) put(dialog.querySelector('h2') ?? dialog, strings.exports.open);
    /** @type {HTMLElement|null} */ (exports.querySelector(wish ? 'a, button' : 'select'))?.focus();
  }, showError);
  const open = button(strings.exports.open, () => void showExports(open, null), { class: 'text-button', id: 'export-open' });
  const wishRow = (/** @type {string} */ name, /** @type {string} */ title, /** @type {string} */ hint, /** @type {import('../shared/api.js').ExportWish} */ wish) => {
    const row = h('button', { type: 'button', class: 'download', id: `download-${name}`, on: { click: () => void showExports(row, wish) } }, icon('download'), h('span', {}, title), h('small', {}, hint));
    return row;
  };
  const wish = (/** @type {keyof typeof kWishes} */ name) => wishRow(name, words.wishes[name][0], words.wishes[name][1], kWishes[name]);
  // What the tiles lie in is not what distances are measured in, so that this comes first.
  const downloads = h('div', { class: 'downloads' }, wish('utm'), wish('report'), wish('kmz'), ...namesIn(words.files).map((name) => link(name).made));
  const addFiles = async (/** @type {object} */ files) => {
    for (const name of namesIn(files)) {
      const { made, has_size } = link(name);
      if (await has_size) downloads.append(made);
    }
  };
  const addHeights = async (/** @type {NonNullable<import('../shared/types.js').Report['surface']>} */ { heights_from, records_from }) => {
    await addFiles(words.height_files);
    const zero = heights_from === 'survey' ? heights_from : records_from;
    if (zero) downloads.append(h('p', { class: 'fine muted', id: 'heights-zero' }, words.heights_zero[zero]));
  };
  const addIndices = async () => {
    for (const { id, title } of (await getBands(flight.id)).indices) {
      if (id) downloads.append(wishRow(id, title, words.index_values, { format: 'geotiff', crs: 'utm', index: id }));
    }
  };
  getReport(flight.id).then(({ surface, bands }) => {
    if (bands) void addFiles(words.band_files);
    if (bands) addIndices().catch(showError);
    if (surface) addHeights(surface).catch(showError);
  }, (error) => console.debug('a map without a report has neither bands nor heights', error));
  put(exports, open);
  const dialog = showDialog('download-dialog', words.download, h('div', {}, downloads, exports));
  dialog.addEventListener('close', () => closed.abort());
  if (cut_to >= 0 || wanted) void showExports(open, wanted);
}

/** Says what to do, with the file that does it. @param {Flight} flight */
function showQgis(flight) {
  const words = strings.actions;
  const body = h('div', { id: 'qgis-body' });
  const draw = async () => {
    const token = await tokenForPrograms(flight, body, draw);
    if (token === null) return;
    put(
      body,
      h('ol', { class: 'numbered' }, ...words.qgis_steps.map((text) => h('li', {}, text))),
      h('a', { class: 'button primary', id: 'qgis-file', href: withToken(at(`/connect/${encodeURIComponent(flight.id)}/qgis.qlr`), token), download: '' }, icon('download'), words.qgis_file),
      h('p', { class: 'muted' }, words.qgis_live),
      token && h('p', { class: 'muted' }, strings.links.carries_token),
    );
  };
  draw().catch((error) => put(body, h('p', { class: 'callout callout-error', role: 'alert' }, error.message)));
  showDialog('qgis-dialog', words.qgis, body);
}
