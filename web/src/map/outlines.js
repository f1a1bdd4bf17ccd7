// Areas on the map that a map can be cut to: what is drawn with the area tool, noted areas, and the polygons of a user's own
// files.
import { onEarth } from './coordinates.js';

/** @typedef {{name: string, geometry: GeoJSON.Polygon|GeoJSON.MultiPolygon}} Outline */

/** @param {import('../notes/note_shape.js').Note[]} notes @returns {Outline[]} */
export const outlinesOfNotes = (notes) => notes.flatMap(({ geometry, properties }) => (geometry.type === 'Polygon' ? [{ name: properties.name, geometry }] : []));

/**
 * @param {string} name of the file
 * @param {GeoJSON.FeatureCollection} data
 * @returns {Outline|null} all its polygons as one; null where it has none
 */
export function outlineOf(name, data) {
  const drawn = data.features.flatMap(({ geometry }) => (geometry.type === 'Polygon' ? [geometry.coordinates] : geometry.type === 'MultiPolygon' ? geometry.coordinates : []));
  const polygons = drawn.map((rings) => rings.map((ring) => ring.map(([lon, lat]) => onEarth([lon, lat]))));
  if (polygons.length === 0) return null;
  return { name, geometry: polygons.length === 1 ? { type: 'Polygon', coordinates: polygons[0] } : { type: 'MultiPolygon', coordinates: polygons } };
}
