// Where a map shows a surveyed point, as far as is known: by its own mark, by its survey where the map has its place, by
// the other points that are marked where it has none. Pure; places are [longitude, latitude] in degrees.
/** @import { LonLat } from '../map/geodesy.js' */
/** @import { ControlPoint } from './control_lists.js' */

/** @typedef {{shown: LonLat, is: LonLat}} KnownPair where the map shows a point, and where it was surveyed */

const kMinSpread = 1e-9;

/** On the plane around a place. @param {LonLat} place @param {LonLat} origin */
const flat = ([lon, lat], [lon0, lat0]) => ({ x: (lon - lon0) * Math.cos((lat0 * Math.PI) / 180), y: lat - lat0 });

/** @param {{x: number, y: number}[]} points */
const middleOf = (points) => ({ x: points.reduce((sum, { x }) => sum + x, 0) / points.length, y: points.reduce((sum, { y }) => sum + y, 0) / points.length });

/**
 * The turn, scale and shift of the plane that brings surveyed places to where the map shows them, by least squares.
 * @param {KnownPair[]} pairs one only shifts
 * @returns {((is: LonLat) => LonLat)|null} null where they say nothing
 */
export function shownFromSurveyed(pairs) {
  if (pairs.length === 0) return null;
  const [shown0, is0] = [pairs[0].shown, pairs[0].is];
  const [to, from] = [pairs.map(({ shown }) => flat(shown, shown0)), pairs.map(({ is }) => flat(is, is0))];
  const [to_middle, from_middle] = [middleOf(to), middleOf(from)];
  let [re, im, square] = [0, 0, 0];
  from.forEach((point, i) => {
    const [a, b] = [{ x: point.x - from_middle.x, y: point.y - from_middle.y }, { x: to[i].x - to_middle.x, y: to[i].y - to_middle.y }];
    re += b.x * a.x + b.y * a.y;
    im += b.y * a.x - b.x * a.y;
    square += a.x ** 2 + a.y ** 2;
  });
  if (pairs.length > 1 && square < kMinSpread ** 2) return null;
  [re, im] = pairs.length > 1 ? [re / square, im / square] : [1, 0];
  return (is) => {
    const point = flat(is, is0);
    const [x, y] = [point.x - from_middle.x, point.y - from_middle.y];
    const at = { x: to_middle.x + re * x - im * y, y: to_middle.y + im * x + re * y };
    return [shown0[0] + at.x / Math.cos((shown0[1] * Math.PI) / 180), shown0[1] + at.y];
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
