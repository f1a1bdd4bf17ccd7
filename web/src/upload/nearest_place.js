// The town or village near which a photo was taken, for the name of a flight that nobody named: from lists that came with the
// page (vendor/places, of GeoNames), so that nobody learns of it.

const kSquare_deg = 15;  // as scripts/vendor.js cuts them
const kFurthest_km = 25;
const kKmOfDegree = 111.2;
const kPatience_ms = 2000;

/** @param {number} lat_deg @param {number} lon_deg @returns {string} the list that has what is near */
export function squareOf(lat_deg, lon_deg) {
  const column = Math.floor(((((lon_deg + 180) % 360) + 360) % 360) / kSquare_deg);
  return `${Math.floor((Math.min(Math.max(lat_deg, -90), 89.99) + 90) / kSquare_deg)}_${column}`;
}

/**
 * Of a city one is near further off than of a village.
 * @param {string} list a line each: name, latitude, longitude in hundredths of a degree, how far it counts
 * @param {number} lat_deg
 * @param {number} lon_deg
 * @returns {string} '' where none is near
 */
export function nearestIn(list, lat_deg, lon_deg) {
  let nearest = '', least = Infinity;
  const shrinks = Math.cos((lat_deg * Math.PI) / 180);
  for (const line of list.split('\n')) {
    const [name, lat, lon, counts] = line.split('\t');
    if (counts === undefined) continue;
    const east_deg = ((lon_deg - Number(lon) / 100 + 540) % 360) - 180;
    const km = kKmOfDegree * Math.hypot(lat_deg - Number(lat) / 100, east_deg * shrinks);
    if (km <= kFurthest_km && km / Number(counts) < least) [nearest, least] = [name, km / Number(counts)];
  }
  return nearest;
}

/** @param {number} lat_deg @param {number} lon_deg @returns {Promise<string>} '' where none is near, or nobody says */
export async function nearestPlace(lat_deg, lon_deg) {
  try {
    const list = await fetch(new URL(`../../vendor/places/${squareOf(lat_deg, lon_deg)}.txt`, import.meta.url), { signal: AbortSignal.timeout(kPatience_ms) });
    return list.ok ? nearestIn(await list.text(), lat_deg, lon_deg) : '';  // the sea has no list
  } catch (error) {
    console.debug('no list of places', error);
    return '';  // an upload waits for no name
  }
}
