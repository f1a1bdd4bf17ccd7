// What the map draws, as MapLibre style parts: a plain ground (no basemap, so nothing is fetched from elsewhere),
// the mosaic, the photos' footprints and cameras, the flight path, the measured line.
/** @import { PhotoCollection } from '../shared/types.js' */
/** @import { LayerSpecification, StyleSpecification, ExpressionSpecification } from '@maplibre/maplibre-gl-style-spec' */
import { goingOn } from './coordinates.js';

const kAlignedColour = '#1f77d0';
const kPoseOnlyColour = '#f28e1c';
const kErrorColours = ['#2b83ba', '#ffd34d', '#d7301f'];
export const kUnknownErrorColour = '#8a8f94';

/** @typedef {'placement'|'error'} ColourBy */

export const photo_layers = ['photos-fill', 'photos-line', 'cameras'];
export const path_layers = ['flight-path-casing', 'flight-path'];
export const contour_layers = ['contours-casing', 'contours', 'contours-label'];
export const height_layers = ['height-change', 'hillshade', ...contour_layers];

/** @returns {string} the page's ground colour, of the light or the dark scheme */
export function groundColour() {
  return getComputedStyle(document.documentElement).getPropertyValue('--ground').trim() || '#e3e6e3';
}

/** @returns {StyleSpecification} */
export function emptyStyle() {
  return {
    version: 8,
    sources: {},
    layers: [{ id: 'ground', type: 'background', paint: { 'background-color': groundColour() } }],
  };
}

/**
 * How far off photos may lie, as far as that is known.
 * @param {PhotoCollection|null} photos
 * @returns {{worst_m: number|null, lacks_some: boolean}} worst_m: null where it is known of none; lacks_some: it is not known of all
 */
export function errorsOf(photos) {
  const records = (photos?.features ?? []).map(({ properties }) => properties);
  const known_m = records.flatMap(({ error_radius_m }) => (typeof error_radius_m === 'number' ? [error_radius_m] : []));
  return { worst_m: known_m.length > 0 ? Math.max(...known_m) : null, lacks_some: known_m.length < records.length };
}

/**
 * @param {ColourBy} by
 * @param {number|null} worst_error_m null: none is known
 * @returns {ExpressionSpecification}
 */
export function photoColour(by, worst_error_m) {
  if (by === 'placement') return ['match', ['get', 'placement'], 'aligned', kAlignedColour, kPoseOnlyColour];
  const top = Math.max(worst_error_m ?? 0, 1e-3);
  /** @type {ExpressionSpecification} */
  const by_error = [
    'interpolate',
    ['linear'],
    ['coalesce', ['get', 'error_radius_m'], top],
    ...kErrorColours.flatMap((colour, i) => [(top * i) / (kErrorColours.length - 1), colour]),
  ];
  const is_known = /** @type {any} */ (['==', ['typeof', ['get', 'error_radius_m']], 'number']);
  return ['case', is_known, by_error, kUnknownErrorColour];
}

/** @type {ExpressionSpecification} */
const is_selected = ['boolean', ['feature-state', 'selected'], false];

/**
 * Close up the ground is what one looks at: the lines step back.
 * @param {boolean} visible false: only the chosen photo's
 * @returns {ExpressionSpecification}
 */
export const lineOpacity = (visible) => ['interpolate', ['linear'], ['zoom'], 18.5, ['case', is_selected, 1, visible ? 0.75 : 0], 20.5, ['case', is_selected, 1, visible ? 0.18 : 0]];

/**
 * Layers of the photos, bottom up.
 * @param {ExpressionSpecification} colour
 * @returns {LayerSpecification[]}
 */
export function photoLayers(colour) {
  return [
    { id: 'photos-fill', type: 'fill', source: 'photos', paint: { 'fill-color': colour, 'fill-opacity': ['case', is_selected, 0.22, 0] } },
    { id: 'photos-line', type: 'line', source: 'photos', paint: { 'line-color': colour, 'line-width': ['case', is_selected, 3, 1.2], 'line-opacity': lineOpacity(true) } },
    { id: 'flight-path-casing', type: 'line', source: 'flight-path', layout: { 'line-join': 'round' }, paint: { 'line-color': '#10201c', 'line-opacity': 0.55, 'line-width': 3 } },
    { id: 'flight-path', type: 'line', source: 'flight-path', layout: { 'line-join': 'round' }, paint: { 'line-color': '#ffffff', 'line-width': 1.4 } },
    {
      id: 'cameras',
      type: 'circle',
      source: 'cameras',
      paint: { 'circle-radius': ['interpolate', ['linear'], ['zoom'], 14, 2.5, 19, 5], 'circle-color': colour, 'circle-stroke-color': '#ffffff', 'circle-stroke-width': ['case', is_selected, 3, 1.5] },
    },
  ];
}

/** @param {string} id of the source @param {string} colour @returns {LayerSpecification[]} */
export function ownDataLayers(id, colour) {
  const of = (/** @type {string} */ kind) => /** @type {any} */ (['==', ['geometry-type'], kind]);
  return [
    { id: `${id}-fill`, type: 'fill', source: id, filter: of('Polygon'), paint: { 'fill-color': colour, 'fill-opacity': 0.18 } },
    { id: `${id}-line`, type: 'line', source: id, filter: ['!', of('Point')], layout: { 'line-join': 'round' }, paint: { 'line-color': colour, 'line-width': 2.5 } },
    { id: `${id}-point`, type: 'circle', source: id, filter: of('Point'), paint: { 'circle-radius': 5.5, 'circle-color': colour, 'circle-stroke-color': '#ffffff', 'circle-stroke-width': 2 } },
  ];
}

/** @returns {LayerSpecification[]} */
export const measureLayers = () => [
  { id: 'measure-fill', type: 'fill', source: 'measure', filter: ['==', ['geometry-type'], 'Polygon'], paint: { 'fill-color': '#ffffff', 'fill-opacity': 0.25 } },
  { id: 'measure-casing', type: 'line', source: 'measure', filter: ['==', ['geometry-type'], 'LineString'], paint: { 'line-color': '#10201c', 'line-width': 5, 'line-opacity': ['case', ['has', 'band'], 0.4, 0.8] } },
  { id: 'measure-band', type: 'line', source: 'measure', filter: ['has', 'band'], paint: { 'line-color': '#ffe14d', 'line-width': 2, 'line-dasharray': [3, 2] } },
  { id: 'measure-line', type: 'line', source: 'measure', filter: ['all', ['==', ['geometry-type'], 'LineString'], ['!', ['has', 'band']]], paint: { 'line-color': '#ffe14d', 'line-width': 2.5 } },
];

/**
 * @param {PhotoCollection} photos
 * @returns {GeoJSON.FeatureCollection} where the cameras were, with the records of the photos
 */
export function cameraPoints(photos) {
  return {
    type: 'FeatureCollection',
    features: photos.features.map(({ properties }) => ({
      type: 'Feature',
      properties: { ...properties },
      geometry: { type: 'Point', coordinates: [properties.camera_lon, properties.camera_lat] },
    })),
  };
}

/**
 * @param {PhotoCollection} photos
 * @returns {GeoJSON.FeatureCollection} the cameras joined in order of time (of name where no time is known)
 */
export function flightPath(photos) {
  const records = photos.features.map(({ properties }) => properties);
  records.sort((a, b) => {
    const [x, y] = [a.captured_at ?? '', b.captured_at ?? ''];
    if (x !== y) return x < y ? -1 : 1;
    return a.name < b.name ? -1 : 1;
  });
  const coordinates = goingOn(records.map((r) => [r.camera_lon, r.camera_lat]));
  return { type: 'FeatureCollection', features: records.length < 2 ? [] : [{ type: 'Feature', properties: {}, geometry: { type: 'LineString', coordinates } }] };
}
