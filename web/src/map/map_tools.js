// What floats over the map: the tool column, the layers card with its legend, and the coordinates.
/** @import { MapView } from './map_view.js' */
/** @import { CoordinateForm } from './coordinates.js' */
import { showNote } from '../shared/announce.js';
import { getLegends, getTileJson } from '../shared/api.js';
import { heightLayers } from '../heights/height_layers.js';
import { heightReadout } from '../heights/height_readout.js';
import { relief } from '../heights/relief.js';
import { indexSection } from '../indices/index_section.js';
import { keepBasemap, offeredBasemaps, shownBasemap } from './basemap.js';
import { coordinate_forms, formatCoordinates } from './coordinates.js';
import { checkRow, h, onEscape, put } from '../shared/dom.js';
import { pointedPlace } from '../shared/follow_pointer.js';
import { compassNeedle, toolButton } from '../shared/icons.js';
import { overlayLegend } from './map_layers.js';
import { kUnknownErrorColour } from './map_style.js';
import { ownDataView } from './own_data_view.js';
import { fixed, keepChoice, keptChoice } from '../shared/language.js';
import { chosenUnits, heightUnit, lengthIn, units_chosen } from '../shared/units.js';
import { strings } from '../shared/flight_strings.js';
import { ownHost } from './tile_addresses.js';

const kNarrow = '(max-width: 760px)';  // as in the styles

/**
 * @param {MapView} view
 * @param {{fit: () => void, measure: (kind: 'distance'|'area') => void, compare: () => void, layers: () => void, download: (wish: import('../shared/api.js').ExportWish) => void}} actions layers: they are about to show; download: of a map as somebody wants it
 */
export function mapTools(view, actions) {
  const words = strings.map;
  const needle = compassNeedle();
  const layers_button = toolButton('layers', words.layers, () => chooseLayers(), 'tool-layers');
  const distance = toolButton('ruler', words.distance, () => actions.measure('distance'), 'tool-distance');
  const area = toolButton('area', words.area, () => actions.measure('area'), 'tool-area');
  const three_d = toolButton(h('span', { class: 'tool-text' }, words.three_d_short), words.three_d, null, 'tool-3d');
  const standing = relief(view, three_d);
  const compare = toolButton('compare', words.compare, () => actions.compare(), 'tool-compare');
  const column = h(
    'div',
    { class: 'tools', role: 'group', 'aria-label': words.layers },
    h(
      'div',
      { class: 'tool-group' },
      toolButton('plus', strings.page.zoom_in, () => view.map.zoomIn()),
      toolButton('minus', strings.page.zoom_out, () => view.map.zoomOut()),
      toolButton(needle, words.north, () => view.map.resetNorth()),
      toolButton('fit', words.fit, actions.fit, 'tool-fit'),
    ),
    h('div', { class: 'tool-group' }, layers_button, three_d, distance, area, compare),
  );
  const turn = () => needle.style.setProperty('transform', `rotate(${-view.map.getBearing()}deg)`);
  view.map.on('rotate', turn);

  const card = layersCard(view, actions.download);
  let opened_itself = false;
  const toggleLayers = (open = card.element.hidden, shows_index = false) => {
    card.element.hidden = !open;
    layers_button.setAttribute('aria-expanded', String(open));
    if (!open) return;
    actions.layers();
    card.draw(shows_index);
  };
  const chooseLayers = () => {
    opened_itself = false;
    toggleLayers();
  };
  layers_button.setAttribute('aria-expanded', 'false');
  layers_button.setAttribute('aria-controls', card.element.id);
  onEscape(card.element, () => {
    toggleLayers(false);
    layers_button.focus();
  });

  return {
    column,
    layers: card.element,
    coordinates: coordinateReadout(view),
    /**
     * Who flew bands wants what is made of them: the card opens with the first index. A phone has no room for card and map.
     * @param {boolean} is_new another flight's map, or the first one after its preview
     */
    drawLayers(is_new) {
      const was_hidden = card.element.hidden;
      const opens = is_new && view.has_bands && !matchMedia(kNarrow).matches;
      if (opens) toggleLayers(true, true);
      else if (is_new && opened_itself) toggleLayers(false);
      else card.draw(false);
      if (is_new) opened_itself = opens && (was_hidden || opened_itself);
    },
    closeLayers: () => toggleLayers(false),
    /** For what a tilted map is of no use to. */
    keepLevel: standing.keepLevel,
    /** @param {'distance'|'area'|null} kind */
    showMeasuring(kind) {
      distance.setAttribute('aria-pressed', String(kind === 'distance'));
      area.setAttribute('aria-pressed', String(kind === 'area'));
    },
  };
}

/** @param {MapView} view @param {(wish: import('../shared/api.js').ExportWish) => void} download */
function layersCard(view, download) {
  const words = strings.map;
  const opacity = h('input', { type: 'range', id: 'opacity', min: 0, max: 100, step: 1, value: Math.round(view.opacity * 100) });
  opacity.addEventListener('input', () => view.setOpacity(Number(opacity.value) / 100));
  const by = h(
    'select',
    { id: 'colour-by', class: 'field' },
    h('option', { value: 'placement' }, words.by_placement),
    h('option', { value: 'error' }, words.by_error),
  );
  const legend = h('div', { class: 'map-legend' });
  const draw = () => {
    if (view.colour_by === 'placement') {
      const entry = (/** @type {'aligned'|'pose_only'} */ kind) => h('li', {}, h('span', { class: `dot dot-${kind}` }), strings.placement[kind]);
      put(legend, h('ul', { class: 'legend' }, entry('aligned'), entry('pose_only')));
    } else {
      const { worst_m, lacks_some } = view.errors;
      const unknown = h('span', { class: 'dot' });
      unknown.style.background = kUnknownErrorColour;
      put(
        legend,
        worst_m !== null && h('div', { class: 'error-ramp', 'aria-hidden': 'true' }),
        worst_m !== null && h('div', { class: 'row between muted' }, h('span', {}, `0\u00a0${heightUnit(chosenUnits())}`), h('span', {}, lengthIn(worst_m, chosenUnits()))),
        lacks_some && h('ul', { class: 'legend', id: 'error-unknown' }, h('li', {}, unknown, strings.photo.unknown)),
      );
    }
  };
  units_chosen.addEventListener('change', draw);
  by.addEventListener('change', () => {
    view.setColourBy(/** @type {any} */ (by.value));
    // Who chooses colours for the photos wants to see them.
    view.setFootprints(true);
    footprints.checked = true;
    draw();
  });
  const { input: footprints, row: footprints_row } = checkRow(words.footprints, 'show-footprints', view.shows_footprints, (on) => view.setFootprints(on));
  const basemap = h('select', { id: 'basemap', class: 'field' });
  const drawBasemaps = async () => {
    const { server, public: left } = await offeredBasemaps();
    const kinds = /** @type {const} */ (['none', 'land', ...(server ? ['server'] : [])]);
    put(
      basemap,
      ...kinds.map((kind) => h('option', { value: kind }, words.basemaps[/** @type {'none'|'land'|'server'} */ (kind)])),
      left.length > 0 && h('optgroup', { label: words.public_basemaps }, ...left.map(({ name, title }) => h('option', { value: `public:${name}` }, title))),
    );
    basemap.value = await shownBasemap();
    basemap_note.hidden = left.length === 0;
  };
  const basemap_note = h('p', { class: 'muted fine', id: 'basemap-note', hidden: true }, words.public_basemaps_note);
  basemap.addEventListener('change', () => {
    const kind = /** @type {import('./basemap.js').BasemapKind} */ (basemap.value);
    keepBasemap(kind);
    void view.setBasemap(kind);
  });
  const overlay = overlayChooser(view);
  const index = indexSection(view, download);
  const element = h(
    'section',
    { class: 'layers-card floating', id: 'layers-card', 'aria-label': words.layers, hidden: true },
    h('label', { for: 'opacity', class: 'small-label' }, words.opacity),
    opacity,
    index.element,
    overlay.element,
    heightLayers(view),
    footprints_row,
    checkRow(words.path, 'show-path', view.shows_path, (on) => view.setPath(on)).row,
    h('label', { for: 'colour-by', class: 'small-label' }, words.colour),
    by,
    legend,
    h('label', { for: 'basemap', class: 'small-label' }, words.basemap),
    basemap,
    basemap_note,
    ownDataView(view),
  );
  return {
    element,
    /** @param {boolean} shows_index */
    draw: (shows_index) => {
      draw();
      overlay.draw();
      void index.draw(shows_index);
      void drawBasemaps();
    },
  };
}

/**
 * Which of the map's layers lies over it, and what its colours mean. Not there where the map has none.
 * @param {MapView} view
 */
function overlayChooser(view) {
  const words = strings.map;
  const choice = h('select', { id: 'overlay', class: 'field' });
  const legend = h('div', { class: 'map-legend' });
  const element = h('div', { class: 'overlay-choice', hidden: true }, h('label', { for: 'overlay', class: 'small-label' }, words.overlay), choice, legend);
  let turn = 0;
  /** @type {import('../shared/types.js').LayerLegends} of what is shown */
  let shown = {};
  const drawLegend = () => put(legend, ...(view.overlay ? overlayLegend(view.overlay, shown) : []));
  units_chosen.addEventListener('change', drawLegend);
  /** @type {import('../shared/types.js').MapLayer|null} that is chosen and on its way */
  let awaited = null;
  choice.addEventListener('change', async () => {
    const own_turn = (turn += 1);
    const layer = view.layers.find(({ id }) => id === choice.value);
    awaited = layer ?? null;
    view.hideOverlay();
    put(legend);
    if (!layer) return;
    // No other choice, nor another map, meanwhile.
    const isWanted = () => own_turn === turn && view.layers.includes(layer);
    try {
      const [tilejson, legends] = await Promise.all([getTileJson(ownHost(layer.tilejson)), getLegends(ownHost(layer.legends))]);
      if (!isWanted()) return;
      awaited = null;
      view.showOverlay(layer.id, tilejson, legends);
      shown = legends;
      drawLegend();
    } catch (error) {
      if (!isWanted()) return;
      awaited = null;
      choice.value = 'none';
      showNote(/** @type {Error} */ (error).message, { is_error: true });
    }
  });
  return {
    element,
    draw() {
      element.hidden = view.layers.length === 0;
      const kinds = /** @type {const} */ (['none', ...view.layers.map(({ id }) => id)]);
      put(choice, ...kinds.map((kind) => h('option', { value: kind }, words.overlays[kind])));
      choice.value = view.overlay || (awaited && view.layers.includes(awaited) ? awaited.id : 'none');
      drawLegend();
    },
  };
}

/**
 * Coordinates and height under the cursor, or of the centre where there is no cursor; a click changes their form.
 * @param {MapView} view
 */
function coordinateReadout(view) {
  const words = strings.map;
  /** @type {CoordinateForm} */
  let form = /** @type {CoordinateForm} */ (keptChoice('skyquilt.coordinates') ?? 'decimal');
  if (!coordinate_forms.includes(form)) form = 'decimal';
  const text = h('span', { class: 'mono', id: 'coordinates' });
  const zoom = h('span', { class: 'muted mono' });
  const height = heightReadout(view);
  const origin = h('span', { class: 'visually-hidden' });
  const element = h('button', { type: 'button', class: 'coordinates', title: words.format }, origin, text, height.element, zoom);
  const draw = () => {
    const { is_cursor, place } = pointed;
    text.textContent = formatCoordinates(place.lng, place.lat, form);
    height.of(place);
    zoom.textContent = `z ${fixed(view.map.getZoom(), 1)}`;
    origin.textContent = `${is_cursor ? words.cursor : words.centre} `;
  };
  const pointed = pointedPlace(view.map, draw);
  view.map.on('move', draw);
  element.addEventListener('click', () => {
    form = coordinate_forms[(coordinate_forms.indexOf(form) + 1) % coordinate_forms.length];
    keepChoice('skyquilt.coordinates', form);
    draw();
  });
  draw();
  return element;
}
