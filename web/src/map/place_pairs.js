// What pairs of places, where the map shows a thing and where it is, say of the map: whether they lie too near together,
// and what they do to it. The same rules as the server's, which decides. Pure; places are [longitude, latitude] in degrees.
/** @import { Bounds } from '../shared/types.js' */
/** @import { LonLat } from './geodesy.js' */
import { wrapLongitude } from './coordinates.js';
import { boundsOf, geodesicLength } from './geodesy.js';

/** @typedef {{shown: LonLat, is: LonLat}} PlacePair */

// Of the map's extent: nearer together, a small slip turns and scales the whole map.
const kNearShare = 0.05;

/** @param {LonLat[]} places @returns {number} metres across the box around them */
function spread(places) {
  const [west, south, east, north] = boundsOf(places.map(([lon, lat]) => [places[0][0] + wrapLongitude(lon - places[0][0]), lat]));
  return geodesicLength([west, south], [east, north]);
}

/** @param {LonLat[]} shown @param {Bounds} bounds of the map */
export function lieNear(shown, [west, south, east, north]) {
  return shown.length > 1 && spread(shown) < kNearShare * geodesicLength([west, south], [east, north]);
}

/** @typedef {{x: number, y: number}} Spot of a plane */

/**
 * What brings points to others by least squares, both from their middles, as one complex factor.
 * @param {Spot[]} from
 * @param {Spot[]} to
 * @returns {{re: number, im: number, square: number}} square: the sum of how far the first lie from their middle, squared; where it is 0 there is no factor
 */
export function factorOf(from, to) {
  let [re, im, square] = [0, 0, 0];
  from.forEach((a, i) => {
    re += to[i].x * a.x + to[i].y * a.y;
    im += to[i].y * a.x - to[i].x * a.y;
    square += a.x ** 2 + a.y ** 2;
  });
  return { re: re / square, im: im / square, square };
}

/**
 * By least squares on the plane around each side's middle, as one complex factor.
 * @param {PlacePair[]} pairs one or more
 * @returns {{shift_m: number, scale: number, turn_deg: number, miss_m: number}|null} turn: clockwise; miss: of the worst
 *   pair; null where the places shown, or the true ones, are all the same
 */
export function movement(pairs) {
  const sides = /** @type {const} */ (['shown', 'is']).map((side) => {
    const places = pairs.map((pair) => pair[side]);
    const lons = places.map(([lon]) => wrapLongitude(lon - places[0][0]));
    const middle = { lon: places[0][0] + mean(lons), lat: mean(places.map(([, lat]) => lat)) };
    const points = places.map(([, lat], i) => {
      const east_m = geodesicLength([middle.lon, middle.lat], [places[0][0] + lons[i], middle.lat]);
      const north_m = geodesicLength([middle.lon, middle.lat], [middle.lon, lat]);
      return { x: Math.sign(places[0][0] + lons[i] - middle.lon) * east_m, y: Math.sign(lat - middle.lat) * north_m };
    });
    return { middle, points };
  });
  const [from, to] = sides;
  const shift_m = geodesicLength([from.middle.lon, from.middle.lat], [to.middle.lon, to.middle.lat]);
  if (pairs.length === 1) return { shift_m, scale: 1, turn_deg: 0, miss_m: 0 };
  const { re, im, square } = factorOf(from.points, to.points);
  if (square === 0 || (re === 0 && im === 0)) return null;
  const misses_m = from.points.map((a, i) => Math.hypot(re * a.x - im * a.y - to.points[i].x, im * a.x + re * a.y - to.points[i].y));
  return { shift_m, scale: Math.hypot(re, im), turn_deg: (-Math.atan2(im, re) * 180) / Math.PI, miss_m: Math.max(...misses_m) };
}

const mean = (/** @type {number[]} */ values) => values.reduce((a, b) => a + b, 0) / values.length;
