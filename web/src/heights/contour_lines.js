// Lines of equal height of the ground, every fifth one stronger and with its height beside it.
/** @import { ContourCollection } from '../shared/types.js' */
/** @import { Units } from '../shared/units.js' */
/** @import { ExpressionSpecification, LayerSpecification } from '@maplibre/maplibre-gl-style-spec' */
import { contour_layers } from '../map/map_style.js';
import { heightIn } from '../shared/units.js';

export const kContours = 'contours';
const kStrong = 5;
const kSame_m = 1e-4;  // of heights that were rounded on their way
const kColour = '#6b3410';

/**
 * @param {number[]} heights_m
 * @returns {number} how far apart contours are; 0 where all have one height
 */
export function contourStep(heights_m) {
  const sorted = [...new Set(heights_m)].sort((a, b) => a - b);
  const steps = sorted.slice(1).map((height_m, i) => height_m - sorted[i]).filter((step_m) => step_m > kSame_m);
  return steps.length > 0 ? Math.min(...steps) : 0;
}

/**
 * @param {ContourCollection} contours
 * @param {Units} units
 * @returns {GeoJSON.FeatureCollection<GeoJSON.LineString, {is_strong: boolean, label: string}>} as they are drawn
 */
export function drawnContours({ features }, units) {
  const heights_m = features.map(({ properties }) => properties.height_m);
  const step_m = contourStep(heights_m);
  const isStrong = (/** @type {number} */ height_m) => step_m === 0 || Math.round(height_m / step_m) % kStrong === 0;
  return {
    type: 'FeatureCollection',
    features: features.map(({ geometry, properties: { height_m } }) => ({ type: 'Feature', geometry, properties: { is_strong: isStrong(height_m), label: heightIn(height_m, units, heights_m) } })),
  };
}

/** Bottom up. @returns {LayerSpecification[]} */
export function contourLayers() {
  const [casing, line, label] = contour_layers;
  /** @type {ExpressionSpecification} */
  const is_strong = ['boolean', ['get', 'is_strong'], false];
  /** @returns {ExpressionSpecification} */
  const width = (/** @type {number} */ weak, /** @type {number} */ strong) => ['case', is_strong, strong, weak];
  return [
    { id: casing, type: 'line', source: kContours, layout: { 'line-join': 'round' }, paint: { 'line-color': '#ffffff', 'line-opacity': 0.4, 'line-width': width(2.2, 3.6) } },
    { id: line, type: 'line', source: kContours, layout: { 'line-join': 'round' }, paint: { 'line-color': kColour, 'line-width': width(0.8, 1.8) } },
    {
      id: label,
      type: 'symbol',
      source: kContours,
      filter: is_strong,
      // The library draws letters by itself, from the fonts of the system: the style names no glyphs.
      layout: { 'symbol-placement': 'line', 'text-field': ['get', 'label'], 'text-font': ['sans-serif'], 'text-size': 11 },
      paint: { 'text-color': kColour, 'text-halo-color': '#ffffff', 'text-halo-width': 1.5 },
    },
  ];
}
