// A place on the ground in the forms people read aloud: decimal degrees, degrees-minutes-seconds, UTM. WGS84.
// UTM by the Krueger series of the transverse Mercator projection to the 4th order in n (Karney 2011, "Transverse
// Mercator with an accuracy of a few nanometers", section 3): below a micrometre inside a zone.

export const kSemiMajor_m = 6378137;
export const kFlattening = 1 / 298.257223563;

/** @typedef {'decimal'|'dms'|'utm'} CoordinateForm */
/** @type {CoordinateForm[]} */
export const coordinate_forms = ['decimal', 'dms', 'utm'];

/**
 * Longitude brought into -180..180.
 * @param {number} lon_deg
 * @returns {number}
 */
export function wrapLongitude(lon_deg) {
  if (lon_deg >= -180 && lon_deg <= 180) return lon_deg;  // exactly: small differences must keep their digits
  return ((((lon_deg + 180) % 360) + 360) % 360) - 180;
}

/**
 * The same longitude, by whole turns, so that it lies next to another as their numbers go.
 * @param {number} lon_deg
 * @param {number} other_deg
 * @returns {number}
 */
export const lonBeside = (lon_deg, other_deg) => lon_deg + 360 * Math.round((other_deg - lon_deg) / 360);

/** @param {[number, number]} place @returns {[number, number]} the same with a longitude that programs take */
export const onEarth = ([lon_deg, lat_deg]) => [wrapLongitude(lon_deg), lat_deg];

/**
 * Places one after the other across the antimeridian, where their numbers go on: a line through them does not go round the Earth,
 * but for one that says so, from -180 to 180.
 * @param {number[][]} places
 * @returns {number[][]}
 */
export function goingOn(places) {
  let before_deg = places[0]?.[0] ?? 0;
  let turn_deg = 0;
  return places.map(([lon_deg, ...rest]) => {
    const step_deg = lon_deg - before_deg;
    if (Math.abs(step_deg) > 180 && Math.abs(step_deg) < 360) turn_deg -= 360 * Math.sign(step_deg);
    before_deg = lon_deg;
    return [lon_deg + turn_deg, ...rest];
  });
}

/**
 * The UTM zone with the exceptions of Norway and Svalbard.
 * @param {number} lon_deg
 * @param {number} lat_deg
 * @returns {number}
 */
export function utmZone(lon_deg, lat_deg) {
  const lon = wrapLongitude(lon_deg);
  if (lat_deg >= 56 && lat_deg < 64 && lon >= 3 && lon < 12) return 32;
  if (lat_deg >= 72 && lat_deg <= 84 && lon >= 0 && lon < 42) return lon < 9 ? 31 : lon < 21 ? 33 : lon < 33 ? 35 : 37;
  return Math.floor((lon + 180) / 6) + 1;
}

/**
 * @param {number} lon_deg
 * @param {number} lat_deg
 * @returns {{zone: number, north: boolean, easting_m: number, northing_m: number}|null} null near the poles
 */
export function utm(lon_deg, lat_deg) {
  if (!(lat_deg >= -80 && lat_deg <= 84)) return null;
  const zone = utmZone(lon_deg, lat_deg);
  const lon_rad = (wrapLongitude(lon_deg - (zone * 6 - 183)) * Math.PI) / 180;
  const lat_rad = (lat_deg * Math.PI) / 180;
  const n = kFlattening / (2 - kFlattening);
  const e = Math.sqrt(kFlattening * (2 - kFlattening));
  const alpha = [
    n / 2 - (2 * n ** 2) / 3 + (5 * n ** 3) / 16 + (41 * n ** 4) / 180,
    (13 * n ** 2) / 48 - (3 * n ** 3) / 5 + (557 * n ** 4) / 1440,
    (61 * n ** 3) / 240 - (103 * n ** 4) / 140,
    (49561 * n ** 4) / 161280,
  ];
  const rectifying_m = (kSemiMajor_m / (1 + n)) * (1 + n ** 2 / 4 + n ** 4 / 64);
  const s = Math.sin(lat_rad);
  const t = Math.sinh(Math.atanh(s) - e * Math.atanh(e * s));
  const xi = Math.atan2(t, Math.cos(lon_rad));
  const eta = Math.asinh(Math.sin(lon_rad) / Math.hypot(t, Math.cos(lon_rad)));
  let north = xi;
  let east = eta;
  alpha.forEach((a, i) => {
    const k = 2 * (i + 1);
    north += a * Math.sin(k * xi) * Math.cosh(k * eta);
    east += a * Math.cos(k * xi) * Math.sinh(k * eta);
  });
  return {
    zone,
    north: lat_deg >= 0,
    easting_m: 500_000 + 0.9996 * rectifying_m * east,
    northing_m: 0.9996 * rectifying_m * north + (lat_deg >= 0 ? 0 : 10_000_000),
  };
}

/**
 * @param {number} angle_deg
 * @param {string} positive letter
 * @param {string} negative letter
 * @returns {string}
 */
function dms(angle_deg, positive, negative) {
  // Rounded once, in the smallest unit, so that 59.999" never prints as 60.00".
  const hundredths = Math.round(Math.abs(angle_deg) * 360_000);
  const degrees = Math.floor(hundredths / 360_000);
  const minutes = Math.floor((hundredths % 360_000) / 6000);
  const seconds = (hundredths % 6000) / 100;
  return `${degrees}° ${String(minutes).padStart(2, '0')}′ ${seconds.toFixed(2).padStart(5, '0')}″ ${
    angle_deg < 0 ? negative : positive
  }`;
}

/**
 * @param {number} lon_deg
 * @param {number} lat_deg
 * @param {CoordinateForm} form
 * @returns {string} latitude first, as charts and phones do
 */
export function formatCoordinates(lon_deg, lat_deg, form) {
  const lon = wrapLongitude(lon_deg);
  if (form === 'dms') return `${dms(lat_deg, 'N', 'S')}  ${dms(lon, 'E', 'W')}`;
  if (form === 'utm') {
    const place = utm(lon, lat_deg);
    if (place) {
      return `${place.zone}${place.north ? 'N' : 'S'}  ${place.easting_m.toFixed(2)} E  ${place.northing_m.toFixed(2)} N`;
    }
  }
  return `${lat_deg.toFixed(7)}, ${lon.toFixed(7)}`;
}
