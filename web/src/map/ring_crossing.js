// Does an outline cross itself? Then it encloses no area that one could mean.
/** @import { LonLat } from './geodesy.js' */

/** @param {LonLat} a @param {LonLat} b @param {LonLat} c @returns {number} which side of a-b c lies on: -1, 0, 1 */
const side = (a, b, c) => Math.sign((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));

/** @param {LonLat} a @param {LonLat} b @param {LonLat} p on the line through a and b @returns {boolean} between them */
const isBetween = (a, b, p) =>
  Math.min(a[0], b[0]) <= p[0] && p[0] <= Math.max(a[0], b[0]) && Math.min(a[1], b[1]) <= p[1] && p[1] <= Math.max(a[1], b[1]);

/** @param {LonLat} a @param {LonLat} b @param {LonLat} c @param {LonLat} d @returns {boolean} whether a-b and c-d touch */
function doMeet(a, b, c, d) {
  const [of_c, of_d, of_a, of_b] = [side(a, b, c), side(a, b, d), side(c, d, a), side(c, d, b)];
  if (of_c * of_d < 0 && of_a * of_b < 0) return true;
  return (
    (of_c === 0 && isBetween(a, b, c)) ||
    (of_d === 0 && isBetween(a, b, d)) ||
    (of_a === 0 && isBetween(c, d, a)) ||
    (of_b === 0 && isBetween(c, d, b))
  );
}

/**
 * @param {LonLat[]} ring corners; the last is joined to the first; narrower than half the globe
 * @returns {boolean}
 */
export function crossesItself(ring) {
  // A corner set twice in the same place (a double click) is one.
  const corners = ring.filter(([lon, lat], i) => {
    const [next_lon, next_lat] = ring[(i + 1) % ring.length];
    return lon !== next_lon || lat !== next_lat;
  });
  // Across the date line the numbers go on.
  const places = corners.map(([lon, lat]) => /** @type {LonLat} */ ([corners[0][0] + ((((lon - corners[0][0] + 540) % 360) + 360) % 360) - 180, lat]));
  const n = places.length;
  for (let i = 0; i < n; i += 1) {
    for (let k = i + 2; k < n; k += 1) {
      if (i === 0 && k === n - 1) continue;  // these two are neighbours as well
      if (doMeet(places[i], places[i + 1], places[k], places[(k + 1) % n])) return true;
    }
  }
  return false;
}
