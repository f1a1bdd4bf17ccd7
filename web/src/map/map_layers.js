// The layers beside a map: which photo a pixel came from, how far off it may lie, how high the ground is. Source and
// layer as MapLibre wants them, and the legend. A map made without layers has none to offer.
/** @import { LayerLegends, TileJson } from '../shared/types.js' */
/** @import { LayerSpecification, SourceSpecification } from '@maplibre/maplibre-gl-style-spec' */
import { h } from '../shared/dom.js';
import { strings } from '../shared/flight_strings.js';
import { chosenUnits, heightIn, lengthIn } from '../shared/units.js';
import { ownHost, sourceBounds } from './tile_addresses.js';

/** @typedef {'photo'|'error'|'height'} LayerKind */

export const kOverlay = 'overlay';

// From low to high: green valleys, brown slopes, white tops.
const kHeightColours = ['#1a6b4a', '#7fb069', '#e8d8a0', '#b07d4f', '#fafafa'];

/** @param {[number, number]} range_m @returns {[number, string][]} */
function heightStops([least_m, most_m]) {
  const top_m = Math.max(most_m, least_m + 0.1);
  return kHeightColours.map((colour, i) => [least_m + ((top_m - least_m) * i) / (kHeightColours.length - 1), colour]);
}

/** What a source needs to know of its tiles, but for where they end. @param {TileJson} tilejson */
export const tilesOf = (tilejson) => ({
  tiles: tilejson.tiles.map(ownHost),
  tileSize: tilejson.tileSize ?? 256,
  minzoom: tilejson.minzoom ?? 0,
  maxzoom: tilejson.maxzoom ?? 22,
});

/**
 * @param {LayerKind} kind
 * @param {TileJson} tilejson
 * @param {LayerLegends} legends
 * @param {number} opacity 0..1
 * @returns {{source: SourceSpecification, layer: LayerSpecification}}
 */
export function overlayParts(kind, tilejson, legends, opacity) {
  const tiles = { ...tilesOf(tilejson), ...sourceBounds(tilejson.bounds) };
  if (kind === 'height' && legends.height) {
    const stops = heightStops(legends.height.range_m);
    // Where nothing is known the code reads as the lowest height there is.
    const unknown = [-32768, 'rgba(0, 0, 0, 0)', stops[0][0] - 1, 'rgba(0, 0, 0, 0)'];
    const colour = /** @type {any} */ (['interpolate', ['linear'], ['elevation'], ...unknown, ...stops.flat()]);
    return {
      source: { type: 'raster-dem', encoding: 'terrarium', ...tiles },
      layer: { id: kOverlay, type: 'color-relief', source: kOverlay, paint: { 'color-relief-color': colour, 'color-relief-opacity': opacity } },
    };
  }
  return {
    source: { type: 'raster', ...tiles },
    layer: { id: kOverlay, type: 'raster', source: kOverlay, paint: { 'raster-opacity': opacity, 'raster-resampling': 'nearest' } },
  };
}

/** The property that holds an overlay's opacity. @param {LayerKind} kind */
export const overlayOpacity = (kind) => (kind === 'height' ? 'color-relief-opacity' : 'raster-opacity');

/**
 * @param {string[]} colours
 * @param {string} least
 * @param {string} most
 */
function ramp(colours, least, most) {
  const bar = h('div', { class: 'layer-ramp', 'aria-hidden': 'true' });
  bar.style.backgroundImage = `linear-gradient(90deg, ${colours.join(', ')})`;
  return [bar, h('div', { class: 'row between muted' }, h('span', {}, least), h('span', {}, most))];
}

/**
 * @param {LayerKind} kind
 * @param {LayerLegends} legends
 * @returns {Node[]}
 */
export function overlayLegend(kind, legends) {
  if (kind === 'error' && legends.error) {
    const stops = legends.error.stops;
    return ramp(stops.map(({ colour }) => colour), lengthIn(stops[0].error_radius_m, chosenUnits()), lengthIn(stops[stops.length - 1].error_radius_m, chosenUnits()));
  }
  if (kind === 'height' && legends.height) {
    const [least_m, most_m] = legends.height.range_m;
    return ramp(kHeightColours, heightIn(least_m, chosenUnits()), heightIn(most_m, chosenUnits()));
  }
  return [h('p', { class: 'muted' }, strings.map.overlay_photo)];
}
