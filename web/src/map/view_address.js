// Where the user has moved the map to, in the page's address (#/flights/ID?at=ZOOM/LAT/LON/BEARING): a reload or a sent
// link shows the same.
/** @typedef {{zoom: number, lat: number, lon: number, bearing: number}} ViewPlace */

/** @param {string} hash @returns {ViewPlace|null} null where it names no place */
export function placeOfHash(hash) {
  const text = new URLSearchParams(hash.split('?')[1] ?? '').get('at');
  const [zoom, lat, lon, bearing = 0] = (text ?? '').split('/').map(Number);
  if (text === null || ![zoom, lat, lon, bearing].every(Number.isFinite)) return null;
  if (zoom < 0 || zoom > 24 || Math.abs(lat) > 85 || Math.abs(lon) > 180) return null;
  return { zoom, lat, lon, bearing };
}

/** @param {string} hash @param {ViewPlace} place @returns {string} the hash with this place */
export function hashWithPlace(hash, { zoom, lat, lon, bearing }) {
  const turned = Math.round(bearing) === 0 ? '' : `/${Math.round(bearing)}`;
  return `${hash.split('?')[0]}?at=${zoom.toFixed(2)}/${lat.toFixed(7)}/${lon.toFixed(7)}${turned}`;
}
