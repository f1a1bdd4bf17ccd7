// Measuring on the map: a path's length with that of each part, or an outline's area, by pointer or by keyboard (the
// map's centre). A band runs from the last point to where the next would be. Points can be dragged; what was done is
// undone step by step; the result is saved as a file, kept as a note, an area taken to cut an export.
/** @import { LonLat } from './geodesy.js' */
/** @import { MapView } from './map_view.js' */
/** @import { Measurement } from './measurement_files.js' */
/** @import { Units } from '../shared/units.js' */
import { announce } from '../shared/announce.js';
import { h } from '../shared/dom.js';
import { showDownloads } from '../flight/flight_actions.js';
import { isScaleKnown } from '../flight/flight_words.js';
import { lonBeside } from './coordinates.js';
import { geodesicLength } from './geodesy.js';
import { button, iconButton } from '../shared/icons.js';
import { heightProfile } from '../heights/height_profile.js';
import { volumeSection } from '../heights/volume_section.js';
import { measureLayers } from './map_style.js';
import { measureMarks } from './measure_marks.js';
import { measurementOf, polygonOf, savingRow } from './measurement_files.js';
import { crossesItself } from './ring_crossing.js';
import { strings } from '../shared/flight_strings.js';
import { areaIn, chosenUnits, keepUnits, lengthIn } from '../shared/units.js';

/** @typedef {'distance'|'area'} MeasureKind */
/** @typedef {(places: LonLat[], kind: MeasureKind, name: string) => void} Keeper */

/**
 * @param {LonLat[]} places
 * @param {MeasureKind} kind
 * @param {LonLat|null} next where another place would be
 * @returns {GeoJSON.FeatureCollection}
 */
function drawing(places, kind, next) {
  const ring = kind === 'area' && places.length > 2 ? [...places, places[0]] : places;
  /** @type {GeoJSON.Feature[]} */
  const features = places.map((place) => ({ type: 'Feature', properties: {}, geometry: { type: 'Point', coordinates: place } }));
  if (ring.length > 1) features.push({ type: 'Feature', properties: {}, geometry: { type: 'LineString', coordinates: ring } });
  if (ring.length > 3) features.push({ type: 'Feature', properties: {}, geometry: { type: 'Polygon', coordinates: [ring] } });
  if (next && places.length > 0) {
    const band = [places[places.length - 1], next, ...(kind === 'area' && places.length > 1 ? [places[0]] : [])];
    features.push({ type: 'Feature', properties: { band: true }, geometry: { type: 'LineString', coordinates: band } });
  }
  return { type: 'FeatureCollection', features };
}

/**
 * @param {MapView} view
 * @param {{on_change: (kind: MeasureKind|null) => void, outlines: () => import('./outlines.js').Outline[]}} listener outlines: on
 *   the map, the one that is drawn first
 */
export function measureTool(view, listener) {
  const words = strings.measure;
  /** @type {MeasureKind|null} */
  let kind = null;
  /** @type {LonLat[]} */
  let places = [];
  /** @type {LonLat[][]} what the points were before each change */
  let before = [];
  /** @type {LonLat|null} below the pointer, or in the middle of a map that fingers or keys move */
  let next_place = null;
  let is_pointed = false;
  /** @type {import('../shared/types.js').Flight|null} whose map it is */
  let flight = null;
  /** @type {Units} */
  let units = chosenUnits();

  const title = h('h2', { class: 'card-title' });
  const result = h('output', { class: 'measure-result', id: 'measure-result' });
  const more = h('p', { class: 'muted' });
  const no_scale = h('p', { class: 'fine amber', id: 'measure-no-scale', hidden: true }, strings.quality.limits.scale_guessed());
  const unit_choice = h(
    'select',
    { class: 'field units', id: 'units', 'aria-label': words.units, on: { change: () => setUnits(/** @type {Units} */ (unit_choice.value)) } },
    ...Object.entries(words.unit_names).map(([value, label]) => h('option', { value }, label)),
  );
  const undo_button = button(strings.flights.undo, () => undo(), { id: 'measure-undo' });
  const saving = savingRow('measure', () => {
    const found = measured();
    return found && kind && { file: words.file_name[kind], measurements: [found] };
  });
  const heights = heightProfile(view);
  const volume = volumeSection(view);
  /** @type {Keeper|null} */
  let keeper = null;
  const keep_button = button(strings.notes.keep, () => keep(), { id: 'measure-keep' });
  const export_button = button(strings.exports.drawn_go, () => flight && showDownloads(flight, listener.outlines(), { cut_to: 0 }), { id: 'measure-export' });
  const element = h(
    'section',
    { class: 'measure-card no-print', id: 'measure-card', 'aria-label': words.distance, hidden: true },
    h(
      'div',
      { class: 'row between card-head' },
      title,
      h('div', { class: 'measure-head' }, unit_choice,
        iconButton('close', words.close, () => end())),
    ),
    result,
    no_scale,
    more,
    h('div', { class: 'row' }, button(words.add, () => add(view.map.getCenter().toArray())), undo_button, button(words.clear, () => change([]))),
    saving,
    h('div', { class: 'row measure-save' }, keep_button, export_button),
    heights.element,
    volume.element,
  );
  const cross = h('div', { class: 'centre-cross', 'aria-hidden': 'true', hidden: true });
  const marks = measureMarks(view, {
    on_grab: () => {
      before.push([...places]);
      next_place = null;
    },
    on_move: (index, place) => {
      places[index] = [lonBeside(place[0], places[index][0]), place[1]];
      draw(false);
    },
    on_drop: () => {
      showHeights();
      tell();
    },
    on_remove: (index) => change(places.filter((_, i) => i !== index)),
  });

  const isCrossing = () => kind === 'area' && places.length > 3 && crossesItself(places);
  /** @returns {Measurement|null} null while there is nothing to measure */
  const measured = () => {
    if (!kind || places.length < (kind === 'area' ? 3 : 2) || isCrossing()) return null;
    return measurementOf(words[kind], places, kind === 'area');
  };
  const tell = () => {
    if (isCrossing()) announce(words.crossing);
    else if (result.textContent) announce(result.textContent);
  };
  const showHeights = () => {
    heights.show(kind === 'distance' ? [...places] : [], units);
    volume.show(kind === 'area' && measured() ? [...places] : [], units);
  };
  const drawLines = () => {
    const source = view.map.getSource('measure');
    if (source) /** @type {any} */ (source).setData(drawing(places, kind ?? 'distance', next_place));
  };
  /** @param {boolean} [tells] false: while a point is dragged */
  const draw = (tells = true) => {
    drawLines();
    const is_ring = kind === 'area' && places.length > 2;
    const ends = is_ring ? [...places, places[0]] : places;
    marks.show(places, ends.slice(1).map((to, i) => ({ from: ends[i], to, text: lengthIn(geodesicLength(ends[i], to), units) })));
    if (tells) showHeights();
    if (!kind) return;
    const found = measured();
    const is_crossing = isCrossing();
    result.textContent = !found ? '' : found.area_m2 === null ? lengthIn(found.length_m, units) : areaIn(found.area_m2, units);
    more.textContent = is_crossing ? words.crossing : !found ? words.hint : found.area_m2 === null ? '' : `${words.perimeter} ${lengthIn(found.length_m, units)}`;
    more.classList.toggle('amber', is_crossing);
    saving.hidden = !found;
    keep_button.hidden = !found || !keeper;
    export_button.hidden = !found || found.area_m2 === null || !flight;
    undo_button.disabled = before.length === 0;
    if (tells) tell();
  };
  /** @param {LonLat[]} next */
  const change = (next) => {
    before.push([...places]);
    places = next;
    next_place = null;
    draw();
  };
  const undo = () => {
    const last = before.pop();
    if (!last) return;
    places = last;
    draw();
  };
  /** Across the antimeridian the numbers go on. @param {LonLat} place @returns {LonLat} */
  const goneOn = ([lon, lat]) => [lonBeside(lon, places.at(-1)?.[0] ?? lon), lat];
  /** @param {LonLat} place */
  const add = (place) => change([...places, goneOn(place)]);
  /** @param {Units} next */
  const setUnits = (next) => {
    units = next;
    keepUnits(next);
    view.setUnits(next);
    draw();
  };
  const keep = () => {
    const found = measured();
    if (!found || !kind || !keeper) return;
    const [now, is, name] = [keeper, kind, `${words[kind]} ${result.textContent}`];
    end();
    now(found.places, is, name);
  };

  const end = () => {
    if (!kind) return;
    kind = null;
    places = [];
    before = [];
    next_place = null;
    draw();
    view.hideCard(element);
    document.body.removeAttribute('data-measuring');
    cross.hidden = true;
    view.map.getCanvas().style.removeProperty('cursor');
    view.map.doubleClickZoom.enable();
    listener.on_change(null);
  };
  const onKey = (/** @type {KeyboardEvent} */ event) => {
    if (!kind) return;
    if (event.key === 'Escape') end();
    if (event.target instanceof HTMLInputElement || event.target instanceof HTMLSelectElement) return;  // what is typed there is its own
    const is_undo = event.key === 'Backspace' || (event.key.toLowerCase() === 'z' && (event.ctrlKey || event.metaKey));
    if (!is_undo) return;
    event.preventDefault();
    undo();
  };
  /** @param {LonLat|null} place */
  const aimAt = (place) => {
    if (!kind || places.length === 0) return;
    next_place = place && goneOn(place);
    drawLines();
  };
  const canvas = view.map.getCanvasContainer();
  canvas.addEventListener('pointermove', (event) => {
    // With a button down the map comes along, or a point does. Fingers point at nothing between two taps.
    if (event.pointerType === 'touch' || event.buttons !== 0) return;
    is_pointed = true;
    const box = canvas.getBoundingClientRect();
    aimAt(view.map.unproject([event.clientX - box.left, event.clientY - box.top]).toArray());
  });
  canvas.addEventListener('pointerleave', (event) => {
    if (event.pointerType === 'touch') return;
    is_pointed = false;
    aimAt(null);
  });
  view.map.on('move', () => {
    if (!is_pointed) aimAt(view.map.getCenter().toArray());
  });
  element.addEventListener('keydown', onKey);
  canvas.addEventListener('keydown', onKey);

  return {
    element,
    cross,
    add,
    end,
    /** @returns {import('./outlines.js').Outline|null} the area that is drawn */
    get outline() {
      const found = measured();
      return found && found.area_m2 !== null ? { name: strings.exports.drawn(areaIn(found.area_m2, units)), geometry: polygonOf(found.places) } : null;
    },
    get kind() {
      return kind;
    },
    /** @param {Keeper|null} next who keeps what is measured; null: it is only saved as a file */
    keepBy(next) {
      keeper = next;
      draw(false);
    },
    /** @param {import('../shared/types.js').Flight|null} next null: a preview */
    ofFlight(next) {
      flight = next;
      no_scale.hidden = isScaleKnown(next?.quality);
      heights.of(next);
      showHeights();  // of a map that was made anew there are others
    },
    /** @param {MeasureKind} next */
    start(next) {
      if (kind === next) {
        end();
        return;
      }
      // Points of a path are no corners of an outline.
      places = [];
      before = [];
      kind = next;
      units = chosenUnits();
      unit_choice.value = units;
      if (!view.map.getSource('measure')) {
        view.map.addSource('measure', { type: 'geojson', data: drawing([], next, null) });
        for (const layer of measureLayers()) view.map.addLayer(layer);
      } else {
        for (const layer of measureLayers()) view.map.moveLayer(layer.id);
      }
      title.textContent = words[next];
      element.setAttribute('aria-label', words[next]);
      element.hidden = false;
      document.body.setAttribute('data-measuring', '');
      cross.hidden = false;
      view.map.getCanvas().style.cursor = 'crosshair';
      view.map.doubleClickZoom.disable();
      draw();
      listener.on_change(next);
    },
  };
}
