// What a note is: a GeoJSON feature with a name and, perhaps, words; a point, a measured line or a measured area.
/** @import { LonLat } from '../map/geodesy.js' */
/** @import { Measurement } from '../map/measurement_files.js' */
import { goingOn } from '../map/coordinates.js';
import { boundsOf } from '../map/geodesy.js';
import { measurementOf, polygonOf, rounded } from '../map/measurement_files.js';
import { newId } from '../shared/api.js';

/** @typedef {GeoJSON.Feature<GeoJSON.Point|GeoJSON.LineString|GeoJSON.Polygon, {name: string, text?: string}> & {id: string}} Note */

export const kMaxNameBytes = 200;
export const kMaxTextBytes = 4000;

/** @param {string} text @returns {number} as the server counts */
export const bytesOf = (text) => new TextEncoder().encode(text).length;

/** @param {Note} note @returns {LonLat[]} of an area without the last one, which is its first */
function placesOf({ geometry }) {
  const places = geometry.type === 'Point' ? [geometry.coordinates] : geometry.type === 'LineString' ? geometry.coordinates : geometry.coordinates[0].slice(0, -1);
  return /** @type {LonLat[]} */ (goingOn(places));
}

/** @param {Note} note @returns {Measurement} */
export const measurementOfNote = (note) => ({ ...measurementOf(note.properties.name, placesOf(note), note.geometry.type === 'Polygon'), text: note.properties.text ?? '' });

/** As it is drawn: not round the Earth. @param {Note} note @returns {Note} */
export function drawnNote(note) {
  const { geometry } = note;
  if (geometry.type === 'LineString') return { ...note, geometry: { ...geometry, coordinates: goingOn(geometry.coordinates) } };
  return geometry.type === 'Polygon' ? { ...note, geometry: { ...geometry, coordinates: geometry.coordinates.map(goingOn) } } : note;
}

/** @param {Note} note */
export const boundsOfNote = (note) => boundsOf(placesOf(note));

/** Where its name stands on the map. @param {Note} note @returns {LonLat} */
export function labelPlace(note) {
  const places = placesOf(note);
  if (note.geometry.type !== 'Polygon') return places[Math.floor((places.length - 1) / 2)];
  return [places.reduce((sum, [lon]) => sum + lon, 0) / places.length, places.reduce((sum, [, lat]) => sum + lat, 0) / places.length];
}

/**
 * @param {string} name
 * @param {string} text '' for none
 * @param {Note['geometry']} geometry
 * @param {string} [id] of a note that this is in place of
 * @returns {Note}
 */
export const noteOf = (name, text, geometry, id = newId()) => ({ type: 'Feature', id, geometry, properties: text ? { name, text } : { name } });

/** @param {LonLat[]} places @param {'distance'|'area'} kind @returns {Note['geometry']} */
export const geometryOf = (places, kind) => (kind === 'area' ? polygonOf(places) : { type: 'LineString', coordinates: places.map(rounded) });
