// The part of the layers card that shows an index of the map: which one, its colours and the values of their ends,
// how often each value occurs, the value under the cursor, and zones for machines. Not there where the map has none.
/** @import { IndexStatistics, MapIndex } from '../shared/types.js' */
/** @import { MapView } from '../map/map_view.js' */
import { showNote } from '../shared/announce.js';
import { getBands, getIndexStatistics, getIndexValue, getReport, zonesPath } from '../shared/api.js';
import { wrapLongitude } from '../map/coordinates.js';
import { checkRow, h, put, svg } from '../shared/dom.js';
import { pointedPlace } from '../shared/follow_pointer.js';
import { button } from '../shared/icons.js';
import { strings } from '../shared/flight_strings.js';
import { fixed, number } from '../shared/language.js';
import { calibrationOf, indexQuery, indexTiles, parseRange, roundTo } from './index_query.js';

const kNone = '';
const kOwn = 'own';
const kTypingPause_ms = 350;
const kCursorPause_ms = 120;
const kHistogramHeight = 36;
const kUsualZones = 5;

/** @param {() => void} act @param {number} pause_ms */
function afterPause(act, pause_ms) {
  let timer = 0;
  return () => {
    clearTimeout(timer);
    timer = window.setTimeout(act, pause_ms);
  };
}

/** As one types it. @param {number} value */
const typed = (value) => number(value + 0, { maximumSignificantDigits: 6, useGrouping: false });  // no minus before a zero

/** @param {MapView} view @param {(wish: import('../shared/api.js').ExportWish) => void} download */
export function indexSection(view, download) {
  const words = strings.indices;
  const which = h('select', { id: 'index', class: 'field' });
  const own = h('input', { type: 'text', id: 'index-expression', class: 'field mono', maxlength: 512, spellcheck: 'false', autocapitalize: 'off', autocomplete: 'off', 'aria-label': words.expression, hidden: true });
  const colours = h('select', { id: 'index-colours', class: 'field', 'aria-label': words.colours });
  const least = h('input', { type: 'text', id: 'index-least', class: 'field mono', 'aria-label': words.least });
  const most = h('input', { type: 'text', id: 'index-most', class: 'field mono', 'aria-label': words.most });
  const fit = button(words.fit, () => fitToValues(), { class: 'text-button', id: 'index-fit' });
  const { input: turned, row: turned_row } = checkRow(words.turned, 'index-turned', false, () => recolour());
  const fault = h('p', { class: 'muted', id: 'index-fault', role: 'alert', hidden: true });
  const histogram = svg('svg', { class: 'index-histogram', id: 'index-histogram', viewBox: `0 0 64 ${kHistogramHeight}`, preserveAspectRatio: 'none', role: 'img' });
  const ramp = h('div', { class: 'layer-ramp', id: 'index-ramp', 'aria-hidden': 'true' });
  const value = h('p', { class: 'row between', id: 'index-value' });
  const calibration = h('p', { class: 'muted fine', id: 'index-calibration' });
  const geotiff = button(words.geotiff, () => {
    if (shown) download({ format: 'geotiff', crs: 'utm', ...(shown.id ? { index: shown.id } : { expression: shown.expression }) });
  }, { class: 'text-button', id: 'index-geotiff' });
  const zones = h('select', { id: 'index-zones', class: 'field' }, ...[3, 4, 5, 6, 7].map((n) => h('option', { value: n }, words.zones(n))));
  zones.value = String(kUsualZones);
  const geojson = h('a', { id: 'zones-geojson', download: '' }, 'GeoJSON');
  const shapefile = h('a', { id: 'zones-shp', download: '' }, words.shapefile);
  const details = h(
    'div',
    { class: 'index-details', hidden: true },
    own,
    fault,
    h('div', { class: 'index-colours' }, colours, turned_row),
    histogram,
    ramp,
    h('div', { class: 'index-range' }, least, fit, most),
    value,
    calibration,
    h('div', {}, geotiff),
    h('label', { for: 'index-zones', class: 'small-label' }, words.zoning),
    h('div', { class: 'index-zones' }, zones, geojson, shapefile),
  );
  const element = h('div', { class: 'overlay-choice', hidden: true }, h('label', { for: 'index', class: 'small-label' }, words.title), which, details);

  /** @type {Map<string, string[]>} */
  const ramps = new Map();
  /** @type {MapIndex|null} */
  let shown = null;
  /** @type {IndexStatistics|null} */
  let statistics = null;
  /** @type {import('../shared/types.js').Report['bands']} what the report says of them */
  let bands;
  let bands_of = '';  // the map
  let draw_turn = 0;
  let opens_first = false;  // whoever draws next shows the first index
  let turn = 0;  // of the index that is shown
  let place_turn = 0;

  const ramp_name = () => colours.value + (turned.checked ? '_r' : '');
  const rampColours = () => {
    const stops = ramps.get(colours.value) ?? [];
    return turned.checked ? [...stops].reverse() : stops;
  };
  const refuse = (/** @type {string} */ text) => {
    fault.textContent = text;
    fault.hidden = text === '';
  };

  const drawHistogram = () => {
    histogram.replaceChildren();
    const range = parseRange(least.value, most.value);
    const bins = statistics?.histogram ?? [];
    const [from, to] = [statistics?.min ?? 0, statistics?.max ?? 0];
    const top = Math.max(1, ...bins);
    const stops = rampColours();
    bins.forEach((count, i) => {
      const middle = from + ((i + 0.5) * (to - from)) / bins.length;
      const share = range ? Math.min(1, Math.max(0, (middle - range[0]) / (range[1] - range[0]))) : 0;
      const height = (count / top) * kHistogramHeight;
      histogram.append(svg('rect', { x: i, y: kHistogramHeight - height, width: 1, height, fill: stops[Math.round(share * (stops.length - 1))] ?? '#888888' }));
    });
    histogram.setAttribute('aria-label', statistics?.mean == null ? words.no_values : words.histogram(fixed(from, 2), fixed(to, 2), fixed(statistics.mean, 2)));
    ramp.style.backgroundImage = `linear-gradient(90deg, ${stops.join(', ')})`;
  };

  // The tiles, their legend and what is made of them follow every change of the colours.
  const recolour = () => {
    const range = parseRange(least.value, most.value);
    least.setAttribute('aria-invalid', String(!range));
    most.setAttribute('aria-invalid', String(!range));
    drawHistogram();
    if (!shown || !range) return;
    view.showIndex(indexTiles(view.tile_template, { index: shown, colormap: ramp_name(), rescale: range }));
    const query = `${indexQuery(shown)}&classes=${zones.value}`;
    geojson.href = zonesPath(view.flight_id, `${query}&format=geojson`);
    shapefile.href = zonesPath(view.flight_id, `${query}&format=shp`);
    geotiff.disabled = false;
  };
  const recolourSoon = afterPause(recolour, kTypingPause_ms);

  const fitToValues = () => {
    if (statistics?.percentiles.p2 == null || statistics.percentiles.p98 == null) return;
    const { p2, p98 } = statistics.percentiles;
    const width = Math.max(p98 - p2, 1e-6);
    least.value = typed(roundTo(p2, width));
    most.value = typed(roundTo(p98, width));
    recolour();
  };

  const drawValue = (/** @type {number|null} */ found) => put(value, h('span', { class: 'muted' }, words.value), h('span', { class: 'mono' }, found === null ? '\u2013' : fixed(found, 3)));

  const stop = () => {
    turn += 1;
    shown = null;
    statistics = null;
    view.hideIndex();
    for (const link of [geojson, shapefile]) link.removeAttribute('href');
    geotiff.disabled = true;
    drawHistogram();
    refuse('');
    put(value);
    put(calibration);
  };

  /** @param {MapIndex} index @param {boolean} fits the ends of the colours come from the values */
  const show = async (index, fits) => {
    stop();
    const own_turn = turn;
    const bounds = view.bounds;
    if (!bounds) return;
    drawValue(null);  // its line is there before it: what lies below stays where one clicks
    put(calibration, words.calibrations[calibrationOf(index.expression, view.has_bands ? bands?.bands ?? [] : null)]);
    if (!fits) {
      [least.value, most.value] = index.rescale.map(typed);
      colours.value = index.colormap;
      turned.checked = false;
      shown = index;
      recolour();
    }
    try {
      const found = await getIndexStatistics(view.flight_id, indexQuery(index), bounds);
      if (own_turn !== turn) return;
      statistics = found;
      shown = index;
      if (fits) fitToValues();
      recolour();
    } catch (error) {
      if (own_turn !== turn) return;
      if (index.id) showNote(/** @type {Error} */ (error).message, { is_error: true });
      else refuse(/** @type {Error} */ (error).message);
    }
  };

  const showOwn = () => {
    const expression = own.value.trim();
    if (which.value !== kOwn) return;
    if (expression === '') stop();
    else void show({ title: expression, expression, rescale: [-1, 1], colormap: colours.value }, true);
  };

  const showValue = async (/** @type {{lng: number, lat: number}} */ place) => {
    const index = shown;
    const own_turn = (place_turn += 1);
    if (!index) return;
    const found = await getIndexValue(view.flight_id, indexQuery(index), wrapLongitude(place.lng), place.lat).catch(() => null);  // the next place asks again
    if (own_turn !== place_turn || index !== shown) return;
    drawValue(found);
  };
  let place = view.map.getCenter();
  const showValueSoon = afterPause(() => void showValue(place), kCursorPause_ms);
  const look = () => {
    place = pointed.place;
    if (shown) showValueSoon();
  };
  const pointed = pointedPlace(view.map, (is_there) => is_there && look());
  view.map.on('moveend', look);

  const choose = () => {
    own.hidden = which.value !== kOwn;
    details.hidden = which.value === kNone;
    const index = view.indices.find(({ id }) => id === which.value);
    if (index) void show(index, false);
    else stop();
    if (which.value === kOwn) {
      if (own.value === '') own.value = view.indices[0]?.expression ?? view.bands[0];
      own.focus();
      showOwn();
    }
  };
  which.addEventListener('change', choose);
  // What was asked about one map is not laid over the next.
  view.shown.addEventListener('change', () => {
    which.value = kNone;
    choose();
  });
  own.addEventListener('input', afterPause(showOwn, 2 * kTypingPause_ms));
  for (const input of [least, most]) input.addEventListener('input', recolourSoon);
  for (const input of [colours, zones]) input.addEventListener('change', recolour);

  const loadRamps = async () => {
    if (ramps.size > 0) return;
    const { colormaps } = await getBands(view.flight_id);
    for (const { id, colours: stops } of colormaps) ramps.set(id, stops);
    put(colours, ...[...ramps.keys()].map((id) => h('option', { value: id }, words.ramps[id] ?? id)));
  };
  // A map that is there without its report is shown all the same, as one of whose values nothing is known.
  const loadBands = async () => {
    const map = view.tile_template;  // with its revision
    if (bands_of === map) return;
    const found = view.has_bands ? (await getReport(view.flight_id).catch(() => null))?.bands : undefined;
    if (map === view.tile_template) [bands, bands_of] = [found, map];
  };

  return {
    element,
    /** @param {boolean} [shows_first] the first index at once */
    async draw(shows_first = false) {
      const own_turn = (draw_turn += 1);
      opens_first ||= shows_first;
      element.hidden = view.bands.length === 0 || view.flight_id === '';
      if (element.hidden) return;
      try {
        await loadRamps();
        await loadBands();
      } catch {
        if (own_turn === draw_turn) element.hidden = true;  // the map is there without its indices
        return;
      }
      if (own_turn !== draw_turn || (shown && view.has_index)) return;
      stop();
      put(
        which,
        h('option', { value: kNone }, words.none),
        ...view.indices.map(({ id, title }) => h('option', { value: id ?? '' }, `${title}: ${words.about[id ?? ''] ?? ''}`)),
        h('option', { value: kOwn }, words.own(view.bands.join(', '))),
      );
      which.value = (opens_first && view.indices[0]?.id) || kNone;
      opens_first = false;
      choose();
    },
  };
}
