// Reads a user's own GeoJSON or KML, to be laid over the map. It stays in the browser. What cannot be read is refused
// with a message that says what to do; sizes are bounded, so that no file stalls the page.
import { goingOn, lonBeside } from './coordinates.js';
import { boundsOf } from './geodesy.js';
import { strings } from '../shared/flight_strings.js';

const kMaxBytes = 20_000_000;
const kMaxPoints = 200_000;
const kDeepest = 8;

/** A file that cannot be laid over the map; the message can be shown. */
export class OwnDataError extends Error {}

const words = () => strings.own_data.faults;

/**
 * @param {string} name of the file
 * @param {string} text
 * @returns {GeoJSON.FeatureCollection} with at least one feature; longitude and latitude alone
 */
export function readOwnData(name, text) {
  if (text.length > kMaxBytes) throw new OwnDataError(words().large);
  const trimmed = text.replace(/^\ufeff/, '').trimStart();
  if (trimmed.startsWith('PK')) throw new OwnDataError(words().zipped);
  const counter = { points: 0 };
  const features = trimmed.startsWith('<') ? fromKml(trimmed, counter) : fromGeoJson(trimmed, counter);
  if (features.length === 0) throw new OwnDataError(words().empty(name));
  return { type: 'FeatureCollection', features: features.map((feature) => ({ ...feature, geometry: drawn(feature.geometry) })) };
}

/** @param {File} file @returns {Promise<GeoJSON.FeatureCollection>} */
export async function readOwnFile(file) {
  if (file.size > kMaxBytes) throw new OwnDataError(words().large);
  return readOwnData(file.name, await file.text());
}

/** @param {File} file @param {unknown} error @returns {string} why it is not taken */
export const ownDataFault = (file, error) => `${file.name}: ${error instanceof OwnDataError ? error.message : words().unread}`;

/** @typedef {{points: number}} Counter */

/**
 * @param {unknown} place
 * @param {Counter} counter
 * @returns {[number, number]}
 */
function checked(place, counter) {
  const [lon, lat] = Array.isArray(place) ? place : [];
  if (typeof lon !== 'number' || typeof lat !== 'number' || !Number.isFinite(lon) || !Number.isFinite(lat)) throw new OwnDataError(words().broken);
  if (Math.abs(lon) > 360 || Math.abs(lat) > 90) throw new OwnDataError(words().projected);
  counter.points += 1;
  if (counter.points > kMaxPoints) throw new OwnDataError(words().many(kMaxPoints));
  return [lon, lat];
}

/** How deep the coordinates of a geometry are nested. @type {Record<string, number>} */
const kDepths = { Point: 0, MultiPoint: 1, LineString: 1, MultiLineString: 2, Polygon: 2, MultiPolygon: 3 };

/** An outline and its holes, also across the antimeridian. @param {number[][][]} rings */
function ringsGoingOn(rings) {
  const places = goingOn(rings.flat());
  let at = 0;
  return rings.map(({ length }) => places.slice(at, (at += length)));
}

/** Nothing that crosses the antimeridian goes round the Earth. @param {any} geometry @returns {any} */
function drawn({ type, coordinates }) {
  if (type === 'LineString') return { type, coordinates: goingOn(coordinates) };
  if (type === 'MultiLineString') return { type, coordinates: coordinates.map(goingOn) };
  if (type === 'Polygon') return { type, coordinates: ringsGoingOn(coordinates) };
  return { type, coordinates: type === 'MultiPolygon' ? coordinates.map(ringsGoingOn) : coordinates };
}

/** @param {unknown} coordinates @param {number} depth @param {Counter} counter @returns {any} */
function checkedAll(coordinates, depth, counter) {
  if (depth === 0) return checked(coordinates, counter);
  if (!Array.isArray(coordinates)) throw new OwnDataError(words().broken);
  return coordinates.map((inner) => checkedAll(inner, depth - 1, counter));
}

/**
 * @param {any} geometry
 * @param {Counter} counter
 * @param {number} [nested]
 * @returns {any[]} geometries without collections
 */
function geometries(geometry, counter, nested = 0) {
  if (geometry === null || geometry === undefined) return [];
  if (nested > kDeepest) throw new OwnDataError(words().broken);
  if (geometry.type === 'GeometryCollection' && Array.isArray(geometry.geometries)) return geometry.geometries.flatMap((/** @type {any} */ inner) => geometries(inner, counter, nested + 1));
  const depth = Object.hasOwn(kDepths, geometry.type ?? '') ? kDepths[geometry.type] : -1;
  if (depth < 0) throw new OwnDataError(words().broken);
  return [{ type: geometry.type, coordinates: checkedAll(geometry.coordinates, depth, counter) }];
}

/** @param {string} text @param {Counter} counter @returns {GeoJSON.Feature[]} */
function fromGeoJson(text, counter) {
  /** @type {any} */
  let document;
  try {
    document = JSON.parse(text);
  } catch {
    throw new OwnDataError(words().neither);
  }
  const crs = document?.crs?.properties?.name;
  if (typeof crs === 'string' && !/CRS84|EPSG:{1,2}4326$/i.test(crs)) throw new OwnDataError(words().projected);
  const found = document?.type === 'FeatureCollection' ? document.features : document?.type === 'Feature' ? [document] : [{ type: 'Feature', geometry: document }];
  if (!Array.isArray(found)) throw new OwnDataError(words().broken);
  return found.flatMap((feature) => geometries(feature?.geometry, counter).map((geometry) => ({ type: /** @type {const} */ ('Feature'), properties: {}, geometry })));
}

/** @param {string} text @param {Counter} counter @returns {GeoJSON.Feature[]} */
function fromKml(text, counter) {
  // Entities make a small file large; KML has no use for them.
  if (/<!(DOCTYPE|ENTITY)/i.test(text)) throw new OwnDataError(words().broken);
  const document = new DOMParser().parseFromString(text, 'application/xml');
  if (document.querySelector('parsererror')) throw new OwnDataError(words().xml);
  if (document.documentElement.localName !== 'kml') throw new OwnDataError(words().neither);
  const line = (/** @type {Element|null|undefined} */ element) =>
    (element?.getElementsByTagNameNS('*', 'coordinates')[0]?.textContent ?? '')
      .trim()
      .split(/\s+/)
      .filter(Boolean)
      .map((place) => checked(place.split(',').map(Number), counter));
  const inner = (/** @type {Element} */ element, /** @type {string} */ name) => [...element.getElementsByTagNameNS('*', name)];
  /** @type {any[]} */
  const found = [];
  for (const placemark of inner(document.documentElement, 'Placemark')) {
    for (const point of inner(placemark, 'Point')) found.push({ type: 'Point', coordinates: line(point)[0] });
    for (const path of inner(placemark, 'LineString')) found.push({ type: 'LineString', coordinates: line(path) });
    for (const polygon of inner(placemark, 'Polygon')) {
      const rings = [...inner(polygon, 'outerBoundaryIs'), ...inner(polygon, 'innerBoundaryIs')].map(line);
      if (rings.length > 0) found.push({ type: 'Polygon', coordinates: rings });
    }
  }
  return found.filter(({ coordinates }) => coordinates?.length > 0).map((geometry) => ({ type: 'Feature', properties: {}, geometry }));
}

/** Of parts on both sides of the antimeridian they go on beyond it. @param {GeoJSON.FeatureCollection} data */
export function boundsOfData(data) {
  /** @type {(coordinates: any) => number[][][]} */
  const linesIn = (coordinates) => (typeof coordinates[0]?.[0] === 'number' ? [coordinates] : coordinates.flatMap(linesIn));
  const lines = data.features.flatMap(({ geometry }) => {
    const { type, coordinates } = /** @type {any} */ (geometry);
    return type === 'Point' ? [[coordinates]] : type === 'MultiPoint' ? coordinates.map((/** @type {number[]} */ place) => [place]) : linesIn(coordinates);
  });
  const beside = lines.map((line) => {
    const turn_deg = lonBeside(line[0][0], lines[0][0][0]) - line[0][0];
    return line.map((/** @type {number[]} */ [lon, lat]) => [lon + turn_deg, lat]);
  });
  const [plain, turned] = [boundsOf(lines.flat()), boundsOf(beside.flat())];
  return turned[2] - turned[0] < plain[2] - plain[0] ? turned : plain;
}
