// The part of the layers card that lays a map's heights over it: shading of its slopes, and contours. Not there where the
// map has none.
/** @import { ContourCollection } from '../shared/types.js' */
/** @import { MapView } from '../map/map_view.js' */
/** @import { GeoJSONSource } from '../../vendor/maplibre-gl.mjs' */
import { showError } from '../shared/announce.js';
import { getContours } from '../shared/api.js';
import { checkRow, h } from '../shared/dom.js';
import { strings } from '../shared/flight_strings.js';
import { contour_layers } from '../map/map_style.js';
import { sourceBounds } from '../map/tile_addresses.js';
import { chosenUnits, units_chosen } from '../shared/units.js';
import { changeLayer } from './change_layer.js';
import { contourLayers, drawnContours, kContours } from './contour_lines.js';
import { reliefSource } from './relief.js';

const kHillshade = 'hillshade';

/**
 * A choice of something that is fetched before it is shown.
 * @template T
 * @param {string} label
 * @param {string} id
 * @param {{get: () => Promise<T>, lay: (got: T) => void, take: () => void}} acts take: also what is not there
 * @returns {{element: HTMLElement, reset: (is_offered: boolean) => void}}
 */
function layerChoice(label, id, { get, lay, take }) {
  let turn = 0;
  const { input, row: element } = checkRow(label, id, false, async (on) => {
    const own_turn = (turn += 1);
    take();
    if (!on) return;
    try {
      const got = await get();
      if (own_turn === turn) lay(got);
    } catch (error) {
      if (own_turn !== turn) return;
      input.checked = false;
      showError(error);
    }
  });
  return {
    element,
    reset(is_offered) {
      turn += 1;
      take();
      input.checked = false;
      element.hidden = !is_offered;
    },
  };
}

/** @param {MapView} view @returns {HTMLElement} */
export function heightLayers(view) {
  const words = strings.map;
  const hillshade = layerChoice(words.hillshade, 'show-hillshade', {
    get: () => reliefSource(view),
    lay(source) {
      // A source of its own: the library draws one that is the ground of three dimensions as well less well.
      view.map.addSource(kHillshade, { ...source, ...sourceBounds(view.bounds) });
      view.addBelowPhotos({ id: kHillshade, type: 'hillshade', source: kHillshade, paint: { 'hillshade-illumination-anchor': 'map' } }, contour_layers);
    },
    take: () => view.remove(kHillshade, [kHillshade]),
  });
  /** @type {ContourCollection|null} that are drawn */
  let drawn = null;
  const contours = layerChoice(words.contours, 'show-contours', {
    get: () => getContours(view.flight_id),
    lay(found) {
      drawn = found;
      view.map.addSource(kContours, { type: 'geojson', data: drawnContours(found, chosenUnits()) });
      for (const layer of contourLayers()) view.addBelowPhotos(layer);
    },
    take() {
      drawn = null;
      view.remove(kContours, contour_layers);
    },
  });
  units_chosen.addEventListener('change', () => {
    if (drawn) /** @type {GeoJSONSource} */ (view.map.getSource(kContours)).setData(drawnContours(drawn, chosenUnits()));
  });
  const element = h('div', { class: 'height-layers', hidden: true }, hillshade.element, contours.element, changeLayer(view));
  view.shown.addEventListener('change', () => {
    element.hidden = view.heights.length === 0;
    hillshade.reset(view.terrain !== '');
    contours.reset(view.heights.includes('dtm'));
  });
  return element;
}
