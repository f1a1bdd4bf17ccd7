// A small picture of a finished map, drawn from the few tiles of the zoom at which it is about as large as wanted.
/** @import { Flight } from '../shared/types.js' */
import { authorization } from '../shared/access.js';
import { getTileJson } from '../shared/api.js';
import { ownHost, tilePosition } from '../map/tile_addresses.js';

/**
 * @param {Flight} flight
 * @param {HTMLCanvasElement} canvas filled with the map, centred
 * @returns {Promise<void>}
 */
export async function drawThumbnail(flight, canvas) {
  if (!flight.bounds || !flight.tilejson) return;
  const [west, south, east, north] = flight.bounds;
  const size = Math.max(canvas.width, canvas.height);
  const tilejson = await getTileJson(flight.tilejson);
  const tile_px = tilejson.tileSize ?? 256;
  const at0 = { from: tilePosition(west, north, 0), to: tilePosition(east, south, 0) };
  const span = Math.max(at0.to.x - at0.from.x, at0.to.y - at0.from.y, 1e-9) * tile_px;
  const wanted = Math.ceil(Math.log2(size / span));
  const zoom = Math.max(flight.min_zoom ?? 0, Math.min(flight.max_zoom ?? 22, wanted));
  const from = tilePosition(west, north, zoom);
  const to = tilePosition(east, south, zoom);
  const scale = size / (Math.max(to.x - from.x, to.y - from.y) * tile_px);
  const columns = Math.floor(to.x) - Math.floor(from.x) + 1;
  const rows = Math.floor(to.y) - Math.floor(from.y) + 1;
  if (columns * rows > 16) return;  // a strange pyramid; the list can do without its picture
  const template = ownHost(tilejson.tiles[0]);
  const context = canvas.getContext('2d');
  if (!context) return;
  const left = (canvas.width - (to.x - from.x) * tile_px * scale) / 2;
  const top = (canvas.height - (to.y - from.y) * tile_px * scale) / 2;
  const jobs = [];
  for (let x = Math.floor(from.x); x <= Math.floor(to.x); x += 1) {
    for (let y = Math.floor(from.y); y <= Math.floor(to.y); y += 1) {
      const address = template.replace('{z}', String(zoom)).replace('{x}', String(x)).replace('{y}', String(y));
      jobs.push(
        loadImage(address).then((image) => {
          if (!image) return;
          const side = tile_px * scale;
          context.drawImage(image, left + (x - from.x) * side, top + (y - from.y) * side, side, side);
        }),
      );
    }
  }
  await Promise.all(jobs);
}

/**
 * @param {string} address
 * @returns {Promise<ImageBitmap|null>} null where there is no tile
 */
async function loadImage(address) {
  const response = await fetch(address, { headers: authorization() });
  if (response.status !== 200) return null;
  return createImageBitmap(await response.blob());
}
