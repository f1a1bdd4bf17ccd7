// The list of flights in the panel: open, rename, delete; states that change are redrawn in place.
/** @import { Flight } from '../shared/types.js' */
import { h, put } from '../shared/dom.js';
import { formatBytes, formatCaptureDay, formatDate, formatPercent } from '../shared/format.js';
import { icon } from '../shared/icons.js';
import { routeHash } from '../shared/router.js';
import { strings } from '../shared/strings.js';
import { readyWords } from './result_verdict.js';
import { drawThumbnail } from './thumbnail.js';
import { uploadOf } from '../upload/uploads.js';

/**
 * @param {Flight} flight
 * @returns {HTMLElement} the state as a coloured word
 */
export function stateChip(flight) {
  const upload = uploadOf(flight.id);
  const state = upload ? 'uploading' : flight.state;
  let text = strings.states[state] ?? state;
  const ready = readyWords(flight);
  if (state === 'ready') text = ready.text;
  if (state === 'processing' && flight.job?.progress) text += ` ${formatPercent(flight.job.progress)}`;
  if (upload) {
    const { sent_bytes, bytes } = upload.queue.picture;
    if (bytes > 0) text += ` ${formatPercent(sent_bytes / bytes)}`;
  }
  return h('span', { class: `chip chip-${state === 'ready' && !ready.is_whole ? 'amber' : state}` }, text);
}

/**
 * @param {Flight} flight
 * @returns {string}
 */
export function flightFacts(flight) {
  const photos = flight.photos ? strings.flights.photos(flight.photos.total) : strings.flights.files(flight.file_count);
  return [takenDay(flight), photos, flight.bytes > 0 ? formatBytes(flight.bytes) : '', flight.file_count > 0 ? strings.flights.uploaded(formatDate(flight.created_at)) : formatDate(flight.created_at)]
    .filter(Boolean)
    .join(' · ');
}

/** When its photos were taken. @param {Flight} flight @returns {string} empty where that is not known */
export const takenDay = (flight) => (flight.captured ? formatCaptureDay(flight.captured) : '');

/** Its time among others: of the photos, else of the upload. @param {Flight} flight */
const timeOf = (flight) => Date.parse(flight.captured?.first ?? '') || Date.parse(flight.created_at) || 0;

/** May this client change it? @param {Flight} flight */
export const mayChange = (flight) => flight.may_change !== false;

/** @type {Record<'newest'|'taken'|'name'|'largest', (a: Flight, b: Flight) => number>} */
const orders = {
  newest: (a, b) => (a.created_at < b.created_at ? 1 : a.created_at > b.created_at ? -1 : 0),
  taken: (a, b) => timeOf(b) - timeOf(a),
  name: (a, b) => a.name.localeCompare(b.name, undefined, { numeric: true }),
  largest: (a, b) => b.bytes - a.bytes,
};

/**
 * @param {{rename: (flight: Flight) => void, remove: (flight: Flight) => void}} actions
 * @returns {{element: HTMLElement, update: (flights: Flight[]|null, error?: string) => void}}
 */
export function flightList(actions) {
  /** @type {Map<string, {row: HTMLLIElement, shown: string, canvas: HTMLCanvasElement, drawn: string}>} */
  const rows = new Map();
  const list = h('ul', { class: 'flights', id: 'flights' });
  const message = h('p', { class: 'muted', id: 'flights-message' });
  const search = h('input', {
    type: 'search',
    class: 'field',
    id: 'flight-search',
    placeholder: strings.flights.search,
    'aria-label': strings.flights.search,
    on: { input: () => redraw() },
  });
  const order = h(
    'select',
    { class: 'field', id: 'flight-order', 'aria-label': strings.flights.order, on: { change: () => redraw() } },
    ...Object.entries(strings.flights.orders).map(([value, label]) => h('option', { value }, label)),
  );
  const filters = h('div', { class: 'filters' }, search, order);
  const element = h(
    'section',
    { class: 'flight-list', 'aria-labelledby': 'flights-heading' },
    h('h2', { class: 'list-heading', id: 'flights-heading', tabindex: -1 }, strings.flights.heading),
    filters,
    list,
    message,
  );
  /** @type {Flight[]|null} */
  let flights = null;
  let failure = '';

  const redraw = () => {
    const query = search.value.trim().toLowerCase();
    const shown = (flights ?? [])
      .filter((flight) => flight.name.toLowerCase().includes(query))
      .sort(orders[/** @type {keyof typeof orders} */ (order.value)]);
    filters.hidden = (flights?.length ?? 0) < 6;
    for (const [id, { row }] of rows) {
      if (!shown.some((flight) => flight.id === id)) {
        row.remove();
        rows.delete(id);
      }
    }
    shown.forEach((flight, i) => {
      const row = rowOf(flight);
      if (list.children[i] !== row) list.insertBefore(row, list.children[i] ?? null);
    });
    message.textContent =
      failure || (flights === null ? '' : flights.length === 0 ? strings.flights.none : shown.length ? '' : strings.flights.no_match);
    message.hidden = message.textContent === '';
  };

  /** @param {Flight} flight @returns {HTMLLIElement} */
  const rowOf = (flight) => {
    const chip = stateChip(flight);
    const picture = JSON.stringify([flight.name, flightFacts(flight), chip.className, chip.textContent]);
    let entry = rows.get(flight.id);
    if (!entry) {
      entry = { row: h('li'), shown: '', canvas: h('canvas', { class: 'thumb', width: 112, height: 112, 'aria-hidden': 'true' }), drawn: '' };
      rows.set(flight.id, entry);
    }
    if (entry.shown !== picture) {
      entry.shown = picture;
      const had_focus = entry.row.contains(document.activeElement);
      put(
        entry.row,
        h(
          'a',
          { class: 'flight-link', href: routeHash({ view: 'flight', id: flight.id }) },
          entry.canvas,
          h('span', { class: 'flight-text' }, h('span', { class: 'flight-name' }, flight.name),
            h('span', { class: 'flight-facts' }, flightFacts(flight)), chip),
        ),
        h(
          'span',
          { class: 'row-actions' },
          mayChange(flight) && action('pencil', `${strings.flights.rename}: ${flight.name}`, () => actions.rename(flight)),
          mayChange(flight) && action('trash', `${strings.flights.remove}: ${flight.name}`, () => actions.remove(flight)),
        ),
      );
      if (had_focus) entry.row.querySelector('a')?.focus();
    }
    const revision = `${flight.tilejson}#${flight.revision}`;
    if (flight.tilejson && entry.drawn !== revision) {
      entry.drawn = revision;
      // A missing picture is no loss the user must hear of.
      drawThumbnail(flight, entry.canvas).catch((error) => console.debug('no thumbnail', error));
    }
    return entry.row;
  };

  return {
    element,
    update(next, error = '') {
      flights = next ?? flights;
      failure = error;
      redraw();
    },
  };
}

/** @param {string} name @param {string} label @param {() => void} run */
function action(name, label, run) {
  return h('button', { type: 'button', class: 'icon-button', 'aria-label': label, title: label, on: { click: run } }, icon(name));
}
