// Where a map shows a surveyed point, as far as is known: by its own mark, by its survey where the map has its place, by
// the other points that are marked where it has none. Pure; places are [longitude, latitude] in degrees.
/** @import { LonLat } from '../map/geodesy.js' */
/** @import { ControlPoint } from './control_lists.js' */
import { wrapLongitude } from '../map/coordinates.js';
import { factorOf } from '../map/place_pairs.js';

/** @typedef {{shown: LonLat, is: LonLat}} KnownPair where the map shows a point, and where it was surveyed */

const kMinSpread = 1e-9;

/** On the plane around a place. @param {LonLat} place @param {LonLat} origin */
const flat = ([lon, lat], [lon0, lat0]) => ({ x: wrapLongitude(lon - lon0) * Math.cos((lat0 * Math.PI) / 180), y: lat - lat0 });

/** @param {import('../map/place_pairs.js').Spot[]} points as they lie from their middle */
function fromMiddle(points) {
  const middle = { x: points.reduce((sum, { x }) => sum + x, 0) / points.length, y: points.reduce((sum, { y }) => sum + y, 0) / points.length };
  return { middle, points: points.map(({ x, y }) => ({ x: x - middle.x, y: y - middle.y })) };
}

/**
 * The turn, scale and shift of the plane that brings surveyed places to where the map shows them, by least squares.
 * @param {KnownPair[]} pairs one only shifts
 * @returns {((is: LonLat) => LonLat)|null} null where they say nothing
 */
export function shownFromSurveyed(pairs) {
  if (pairs.length === 0) return null;
  const [shown0, is0] = [pairs[0].shown, pairs[0].is];
  const [to, from] = [fromMiddle(pairs.map(({ shown }) => flat(shown, shown0))), fromMiddle(pairs.map(({ is }) => flat(is, is0)))];
  const factor = factorOf(from.points, to.points);
  if (pairs.length > 1 && factor.square < kMinSpread ** 2) return null;
  const { re, im } = pairs.length > 1 ? factor : { re: 1, im: 0 };
  return (is) => {
    const point = flat(is, is0);
    const [x, y] = [point.x - from.middle.x, point.y - from.middle.y];
    const at = { x: to.middle.x + re * x - im * y, y: to.middle.y + im * x + re * y };
    return [wrapLongitude(shown0[0] + at.x / Math.cos((shown0[1] * Math.PI) / 180)), shown0[1] + at.y];
  };
}

/**
 * @param {ControlPoint} point
 * @param {Map<string, LonLat>} shown where the map shows points by their own marks, by name
 * @param {ControlPoint[]} points all
 * @param {boolean} is_placed the map has its place on Earth
 * @returns {LonLat|null} null where nothing tells
 */
export function guessedPlace(point, shown, points, is_placed) {
  const own = shown.get(point.name);
  if (own) return own;
  if (point.lon === undefined || point.lat === undefined) return null;
  /** @type {KnownPair[]} */
  const pairs = points.flatMap(({ name, lon, lat }) => {
    const place = shown.get(name);
    return place && lon !== undefined && lat !== undefined ? [{ shown: place, is: /** @type {LonLat} */ ([lon, lat]) }] : [];
  });
  if (is_placed && pairs.length < 2) return shownFromSurveyed(pairs)?.([point.lon, point.lat]) ?? [point.lon, point.lat];
  return pairs.length > 1 ? (shownFromSurveyed(pairs)?.([point.lon, point.lat]) ?? null) : null;
}
