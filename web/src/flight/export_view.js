// A map as somebody wants it: format, coordinate system, area, resolution. The server makes it beside everything else
// and keeps it for a day; this lists what it has, with progress, downloads and refusals.
/** @import { Flight, MapExport } from '../shared/types.js' */
/** @import { Outline } from '../map/outlines.js' */
import { readable } from '../shared/token.js';
import { announce } from '../shared/announce.js';
import { listExports, messageOf, remarkWords, removeExport, serverWords, startExport } from '../shared/api.js';
import { refusalBox } from '../shared/dialogs.js';
import { arrange, h, put } from '../shared/dom.js';
import { dotted, formatBytes, formatDate, formatGsd, formatPercent } from '../shared/format.js';
import { icon, iconButton, runOnce } from '../shared/icons.js';
import { strings } from '../shared/flight_strings.js';
import { areaChoice } from './area_choice.js';
import { isOver } from './job_watch.js';

const kAgain_ms = 1000;
const kAgainWhenAway_ms = 5000;

/**
 * What the form says, as the server takes it.
 * @param {{format: string, crs: string, epsg: string, resolution_cm: string}} form
 * @param {Outline|null} outline
 * @returns {import('../shared/api.js').ExportWish}
 */
export function wishOf({ format, crs, epsg, resolution_cm }, outline) {
  const code = epsg.trim().replace(/^epsg\s*:?\s*/i, '');
  const centimetres = resolution_cm.trim() === '' ? null : Number(resolution_cm);
  if (format === 'report') return { format };  // of the whole map
  return {
    format,
    ...(format === 'geotiff' && crs !== 'stored' ? { crs: crs === 'utm' ? 'utm' : `EPSG:${code}` } : {}),
    ...(centimetres === null ? {} : { resolution_m: centimetres / 100 }),
    ...(outline ? { boundary: outline.geometry } : {}),
  };
}

/** @param {MapExport} made @returns {string} what was asked for, in words */
export function exportWords({ format, crs, resolution_m, boundary, index, expression, is_current }) {
  const words = strings.exports;
  return dotted(index?.toUpperCase() ?? expression, words.formats[format] ?? format, crs === 'utm' ? words.systems.utm : crs, resolution_m ? formatGsd(resolution_m) : '', boundary ? words.cut : '', is_current ? '' : words.earlier);
}

/**
 * @param {Flight} flight with a map
 * @param {Outline[]} outlines on the map now
 * @param {AbortSignal} signal the view is gone
 * @param {number} [cut_to] which of the outlines is chosen; -1: none
 * @param {boolean} [has_asked] something was asked for just now: what there is comes first
 * @returns {HTMLElement}
 */
export function exportView(flight, outlines, signal, cut_to = -1, has_asked = false) {
  const words = strings.exports;
  const list = h('ul', { class: 'shares exports', id: 'exports' });
  const { element: refusal, refuse } = refusalBox('export-refusal');
  const failed = (/** @type {unknown} */ error) => refuse(messageOf(error));

  const option = (/** @type {string} */ value, /** @type {string} */ label) => h('option', { value }, label);
  const format = h('select', { id: 'export-format', class: 'field' }, ...Object.entries(words.formats).map(([value, label]) => option(value, label)));
  const crs = h('select', { id: 'export-crs', class: 'field' }, ...Object.entries(words.systems).map(([value, label]) => option(value, label)));
  const epsg = h('input', { id: 'export-epsg', class: 'field', type: 'text', inputmode: 'numeric', placeholder: '2056', 'aria-label': words.epsg, required: true, pattern: '\\s*([Ee][Pp][Ss][Gg]\\s*:?\\s*)?[0-9]{1,6}\\s*', title: words.epsg_hint });
  const resolution = h('input', { id: 'export-resolution', class: 'field', type: 'number', min: 0, step: 'any', placeholder: words.as_map });
  const area = areaChoice('export-area', outlines, refuse, cut_to);

  const row = (/** @type {HTMLElement} */ field, /** @type {string} */ label, /** @type {(HTMLElement|null)[]} */ ...more) =>
    h('div', { class: 'export-row' }, h('label', { for: field.id }, label), h('div', { class: 'export-fields' }, field, ...more));
  const crs_row = row(crs, words.crs, epsg);
  const resolution_row = row(resolution, words.resolution);
  const area_row = row(area.field, words.area, area.browse, area.file);
  const drawForm = () => {
    crs_row.hidden = format.value !== 'geotiff';
    resolution_row.hidden = area_row.hidden = format.value === 'report';
    resolution.disabled = resolution_row.hidden;  // what nobody sees is not held against the form
    epsg.hidden = crs.value !== 'epsg';
    epsg.disabled = crs_row.hidden || epsg.hidden;
  };
  format.addEventListener('change', drawForm);
  crs.addEventListener('change', drawForm);
  drawForm();

  const start = h('button', { type: 'submit', class: 'button primary', id: 'export-start' }, words.start);
  const form = h(
    'form',
    { class: 'export-form', id: 'export-form' },
    row(format, words.format),
    crs_row,
    resolution_row,
    area_row,
    outlines.length === 0 && h('p', { class: 'muted fine' }, words.area_hint),
    h('div', { class: 'row' }, start),
  );
  form.addEventListener('submit', async (event) => {
    event.preventDefault();
    refuse('');
    start.disabled = true;
    try {
      await startExport(flight.id, wishOf({ format: format.value, crs: crs.value, epsg: epsg.value, resolution_cm: resolution.value }, area.chosen()));
      await watch();
      list.firstElementChild?.scrollIntoView({ block: 'nearest' });
    } catch (error) {
      failed(error);
    }
    start.disabled = false;
  });

  /** @typedef {{row: HTMLLIElement, what: HTMLElement, link: HTMLAnchorElement|null, remove: HTMLButtonElement, picture: 'close'|'trash', drawn: string}} ExportRow */
  /** @type {Map<string, ExportRow>} */
  const rows = new Map();
  /** Its buttons stay while it is made: a click that begins before an answer and ends after it counts. @param {string} id @returns {ExportRow} */
  const newRow = (id) => {
    const remove = iconButton('close', '', () => runOnce(remove, async () => {
      refuse('');
      await removeExport(flight.id, id);
      await watch();
      (/** @type {HTMLElement|null} */ (list.querySelector('button')) ?? start).focus();
    }, failed));
    return { row: h('li'), what: h('div', { class: 'export-what' }), link: null, remove, picture: 'close', drawn: '' };
  };
  /** @param {MapExport} made */
  const drawRow = (made) => {
    const entry = rows.get(made.id) ?? newRow(made.id);
    const before = rows.has(made.id) ? entry.row.dataset.state : made.state;
    rows.set(made.id, entry);
    const drawn = JSON.stringify([made.state, made.progress, made.is_current]);
    if (entry.drawn === drawn) return entry.row;
    entry.drawn = drawn;
    entry.row.dataset.state = made.state;
    const what = exportWords(made);
    if (before !== made.state && isOver(made)) announce(made.state === 'successful' ? words.ready(what) : words.failed(what));
    put(entry.what, h('span', {}, what), ...stateOf(made), ...notesOn(made));
    const picture = isOver(made) ? 'trash' : 'close';
    if (entry.picture !== picture) put(entry.remove, icon(picture));
    entry.picture = picture;
    for (const name of ['aria-label', 'title']) entry.remove.setAttribute(name, words.remove(what));
    if (made.download) entry.link ??= h('a', { class: 'button small', href: readable(made.download), download: '' }, icon('download'), strings.actions.download);
    arrange(entry.row, [entry.what, ...(entry.link ? [entry.link] : []), entry.remove]);
    return entry.row;
  };

  let timer = 0;
  const draw = (/** @type {MapExport[]} */ exports) => {
    const kept = new Set(exports.map(({ id }) => id));
    for (const id of rows.keys()) if (!kept.has(id)) rows.delete(id);
    arrange(list, exports.map(drawRow));
    heading.hidden = exports.length === 0;
  };
  // A server that is away for a moment goes on with what it was asked for.
  let is_away = false;
  let turn = 0;
  const watch = async () => {
    clearTimeout(timer);
    const own_turn = (turn += 1);
    // Gone, or asked again meanwhile: what was removed since then would be back.
    const isStale = () => signal.aborted || own_turn !== turn;
    try {
      const exports = await listExports(flight.id);
      if (isStale()) return;
      draw(exports);
      if (is_away) refuse('');
      is_away = false;
      if (!exports.every(isOver)) timer = window.setTimeout(() => void watch(), kAgain_ms);
    } catch (error) {
      if (isStale()) return;
      is_away = true;
      failed(error);
      timer = window.setTimeout(() => void watch(), kAgainWhenAway_ms);
    }
  };
  signal.addEventListener('abort', () => clearTimeout(timer));
  const heading = h('h3', { class: 'share-heading', hidden: true }, words.heading);
  void watch();
  return h('section', { id: 'export-view', 'aria-label': words.open }, ...(has_asked ? [refusal, heading, list, form] : [form, refusal, heading, list]));
}

/** @param {MapExport} made @returns {HTMLElement[]} what is to be known of the file */
function notesOn({ state, remark }) {
  const said = state === 'failed' ? null : remarkWords(remark);
  return said === null ? [] : [h('span', { class: 'fine' }, said)];
}

/** @param {MapExport} made @returns {HTMLElement[]} */
function stateOf({ state, progress, bytes, error, expires_at }) {
  const words = strings.exports;
  if (state === 'failed') return [h('span', { class: 'bad fine' }, error ? serverWords(error.code, error.message, error.reason) : words.failed(''))];
  if (state === 'successful') {
    const until = expires_at ? formatDate(expires_at, { with_time: true }) : '';
    return [h('span', { class: 'muted fine' }, dotted(bytes !== null && formatBytes(bytes), until && words.until(until)))];
  }
  const text = state === 'accepted' ? words.waiting : formatPercent(progress);
  return [h('progress', { class: 'bar', max: 1, value: progress, 'aria-label': words.progress }), h('span', { class: 'muted fine' }, text)];
}
