// A measurement as a file that other programs open. WGS84, longitude first, as both formats have it.
/** @import { LonLat } from './geodesy.js' */
import { xmlText } from '../flight/connect_files.js';

/**
 * @typedef {object} Measurement
 * @property {string} name
 * @property {LonLat[]} places at least two; of an area at least three, its outline not closed
 * @property {number} length_m of the path, or around the area
 * @property {number|null} area_m2 null for a path
 */

const kDigits = 9;
const rounded = (/** @type {LonLat} */ place) => place.map((degrees) => Number(degrees.toFixed(kDigits)));

/** An outline as RFC 7946 wants it: closed, anticlockwise. @param {LonLat[]} places */
function ring(places) {
  const twice = places.reduce((sum, [x, y], i) => {
    const [next_x, next_y] = places[(i + 1) % places.length];
    return sum + (next_x - x) * (next_y + y);
  }, 0);
  const turned = twice > 0 ? [...places].reverse() : places;
  return [...turned, turned[0]];
}

/** @param {LonLat[]} places @returns {GeoJSON.Polygon} */
export const polygonOf = (places) => ({ type: 'Polygon', coordinates: [ring(places).map(rounded)] });

/** @param {Measurement} measurement @returns {string} GeoJSON */
export function measurementGeoJson({ name, places, length_m, area_m2 }) {
  const millimetres = (/** @type {number} */ value) => Number(value.toFixed(3));
  const feature =
    area_m2 === null
      ? { type: 'Feature', properties: { name, length_m: millimetres(length_m) }, geometry: { type: 'LineString', coordinates: places.map(rounded) } }
      : { type: 'Feature', properties: { name, area_m2: millimetres(area_m2), perimeter_m: millimetres(length_m) }, geometry: polygonOf(places) };
  return `${JSON.stringify({ type: 'FeatureCollection', features: [feature] }, null, 2)}\n`;
}

/** @param {Measurement} measurement @returns {string} KML 2.2 */
export function measurementKml({ name, places, length_m, area_m2 }) {
  const line = (/** @type {LonLat[]} */ of) => `<coordinates>${of.map((place) => rounded(place).join(',')).join(' ')}</coordinates>`;
  const geometry = area_m2 === null ? `<LineString><tessellate>1</tessellate>${line(places)}</LineString>` : `<Polygon><outerBoundaryIs><LinearRing>${line(ring(places))}</LinearRing></outerBoundaryIs></Polygon>`;
  const data = (/** @type {string} */ key, /** @type {number} */ value) => `<Data name="${key}"><value>${value.toFixed(3)}</value></Data>`;
  const values = area_m2 === null ? data('length_m', length_m) : data('area_m2', area_m2) + data('perimeter_m', length_m);
  return `<?xml version="1.0" encoding="UTF-8"?>
<kml xmlns="http://www.opengis.net/kml/2.2"><Document><Placemark>
  <name>${xmlText(name)}</name>
  <ExtendedData>${values}</ExtendedData>
  ${geometry}
</Placemark></Document></kml>
`;
}
