// Measuring on the map: a path's length or a polygon's area, by pointer or by keyboard (the map's centre).
/** @import { LonLat } from './geodesy.js' */
/** @import { MapView } from './map_view.js' */
import { announce } from '../shared/announce.js';
import { h } from '../shared/dom.js';
import { formatArea, formatLength } from '../shared/format.js';
import { pathLength, polygonArea } from './geodesy.js';
import { icon } from '../shared/icons.js';
import { measureLayers } from './map_style.js';
import { crossesItself } from './ring_crossing.js';
import { strings } from '../shared/strings.js';

/** @typedef {'distance'|'area'} MeasureKind */

/**
 * @param {LonLat[]} places
 * @param {MeasureKind} kind
 * @returns {GeoJSON.FeatureCollection}
 */
function drawing(places, kind) {
  const ring = kind === 'area' && places.length > 2 ? [...places, places[0]] : places;
  /** @type {GeoJSON.Feature[]} */
  const features = places.map((place) => ({ type: 'Feature', properties: {}, geometry: { type: 'Point', coordinates: place } }));
  if (ring.length > 1) features.push({ type: 'Feature', properties: {}, geometry: { type: 'LineString', coordinates: ring } });
  if (ring.length > 3) features.push({ type: 'Feature', properties: {}, geometry: { type: 'Polygon', coordinates: [ring] } });
  return { type: 'FeatureCollection', features };
}

/**
 * @param {MapView} view
 * @param {{on_change: (kind: MeasureKind|null) => void}} listener
 */
export function measureTool(view, listener) {
  const words = strings.measure;
  /** @type {MeasureKind|null} */
  let kind = null;
  /** @type {LonLat[]} */
  let places = [];

  const title = h('h2', { class: 'card-title' });
  const result = h('output', { class: 'measure-result', id: 'measure-result' });
  const more = h('p', { class: 'muted' });
  const button = (/** @type {string} */ label, /** @type {() => void} */ run) =>
    h('button', { type: 'button', class: 'button small', on: { click: run } }, label);
  const element = h(
    'section',
    { class: 'measure-card floating', id: 'measure-card', 'aria-label': words.distance, hidden: true },
    h(
      'div',
      { class: 'row between card-head' },
      title,
      h('button', { type: 'button', class: 'icon-button', 'aria-label': words.close, title: words.close, on: { click: () => end() } }, icon('close')),
    ),
    result,
    more,
    h(
      'div',
      { class: 'row' },
      button(words.add, () => add([view.map.getCenter().lng, view.map.getCenter().lat])),
      button(words.undo, () => {
        places.pop();
        draw();
      }),
      button(words.clear, () => {
        places = [];
        draw();
      }),
    ),
  );
  const cross = h('div', { class: 'centre-cross', 'aria-hidden': 'true', hidden: true });

  const draw = () => {
    const source = view.map.getSource('measure');
    if (source) /** @type {any} */ (source).setData(drawing(places, kind ?? 'distance'));
    if (!kind) return;
    const length = pathLength(kind === 'area' && places.length > 2 ? [...places, places[0]] : places);
    if (kind === 'distance') {
      result.textContent = places.length > 1 ? formatLength(length) : '';
      more.textContent = places.length > 1 ? '' : words.hint;
    } else {
      const is_crossing = places.length > 3 && crossesItself(places);
      result.textContent = places.length > 2 && !is_crossing ? formatArea(polygonArea(places)) : '';
      more.textContent = is_crossing ? words.crossing : places.length > 2 ? `${words.perimeter} ${formatLength(length)}` : words.hint;
      more.classList.toggle('amber', is_crossing);
      if (is_crossing) announce(words.crossing);
    }
    if (kind === 'distance') more.classList.remove('amber');
    if (result.textContent) announce(result.textContent);
  };

  /** @param {LonLat} place */
  const add = (place) => {
    places.push(place);
    draw();
  };

  const end = () => {
    if (!kind) return;
    kind = null;
    places = [];
    draw();
    element.hidden = true;
    cross.hidden = true;
    view.map.getCanvas().style.removeProperty('cursor');
    view.map.doubleClickZoom.enable();
    listener.on_change(null);
  };
  element.addEventListener('keydown', (event) => {
    if (event.key === 'Escape') end();
  });

  return {
    element,
    cross,
    add,
    end,
    get kind() {
      return kind;
    },
    /** @param {MeasureKind} next */
    start(next) {
      if (kind === next) {
        end();
        return;
      }
      // Points of a path are no corners of an outline.
      places = [];
      kind = next;
      if (!view.map.getSource('measure')) {
        view.map.addSource('measure', { type: 'geojson', data: drawing([], next) });
        for (const layer of measureLayers()) view.map.addLayer(layer);
      } else {
        for (const layer of measureLayers()) view.map.moveLayer(layer.id);
      }
      title.textContent = words[next];
      element.setAttribute('aria-label', words[next]);
      element.hidden = false;
      cross.hidden = false;
      view.map.getCanvas().style.cursor = 'crosshair';
      view.map.doubleClickZoom.disable();
      draw();
      listener.on_change(next);
    },
  };
}
