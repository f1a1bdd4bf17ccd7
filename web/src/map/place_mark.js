// A mark where the map lies, while it is too small on the screen to be seen, or has no tiles: from afar one finds it.
/** @import { Bounds } from '../shared/types.js' */
/** @import { Map as MapLibreMap, Point } from '../../vendor/maplibre-gl.mjs' */
import { tileBox } from './tile_addresses.js';

const kMark = 'place-mark';
const kSmallest_px = 28;
const kWorld_px = 512;  // of MapLibre's zoom 0

/**
 * @param {Bounds} bounds
 * @param {number} min_zoom of MapLibre, from which the tiles are drawn
 * @returns {number} the zoom up to which the mark is shown
 */
function markZoom(bounds, min_zoom) {
  const { width, height } = tileBox(bounds, 0);
  const span = Math.max(width, height, 1e-9);
  return Math.max(min_zoom, Math.min(24, Math.log2(kSmallest_px / (kWorld_px * span))));
}

/**
 * @param {MapLibreMap} map
 * @returns {{show: (bounds: Bounds, min_zoom: number) => void, hide: () => void, isAt: (point: Point) => boolean}}
 */
export function placeMark(map) {
  const hide = () => {
    if (map.getLayer(kMark)) map.removeLayer(kMark);
    if (map.getSource(kMark)) map.removeSource(kMark);
  };
  return {
    hide,
    show(bounds, min_zoom) {
      hide();
      const [west, south, east, north] = bounds;
      map.addSource(kMark, { type: 'geojson', data: { type: 'Feature', properties: {}, geometry: { type: 'Point', coordinates: [(west + east) / 2, (south + north) / 2] } } });
      map.addLayer({
        id: kMark,
        type: 'circle',
        source: kMark,
        maxzoom: markZoom(bounds, min_zoom),
        paint: { 'circle-radius': 8, 'circle-color': '#0b6e5f', 'circle-stroke-color': '#ffffff', 'circle-stroke-width': 3 },
      });
    },
    isAt(point) {
      if (!map.getLayer(kMark)) return false;
      const box = /** @type {[[number, number], [number, number]]} */ ([[point.x - 12, point.y - 12], [point.x + 12, point.y + 12]]);
      return map.queryRenderedFeatures(box, { layers: [kMark] }).length > 0;
    },
  };
}
