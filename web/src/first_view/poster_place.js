// Where the whole map lies on the screen: of bounds that the map library fits into a container, or of a view that was
// asked for. Web Mercator, which the library draws and the poster is drawn in; px of the page.
/** @import { Bounds } from '../shared/types.js' */
/** @import { ViewPlace } from '../map/view_address.js' */
import { tileBox, tilePosition } from '../map/tile_addresses.js';

/** @typedef {{top: number, right: number, bottom: number, left: number}} Padding px that other things cover */

/** Room that the page's tools take from the map. @type {Padding} */
export const kStagePadding = { top: 28, left: 28, right: 64, bottom: 48 };
/** The same of the bare map. @type {Padding} */
export const kEmbedPadding = { top: 24, left: 24, right: 24, bottom: 24 };

export const kMaxZoom = 24;
const kWorld_px = 512;  // at zoom 0

/**
 * @typedef {object} PosterPlace
 * @property {number} left px from the container's left, before it is turned
 * @property {number} top
 * @property {number} width
 * @property {number} height
 * @property {number} bearing degrees clockwise from north that point up; the picture is turned the other way around the
 *   container's middle
 */

/**
 * @param {Bounds} bounds
 * @param {{width: number, height: number}} container
 * @param {Padding} padding
 * @returns {PosterPlace|null} null where there is no room
 */
export function fittedPlace(bounds, { width, height }, padding) {
  const box = tileBox(bounds, 0);
  const room = { x: width - padding.left - padding.right, y: height - padding.top - padding.bottom };
  if (room.x <= 0 || room.y <= 0 || box.width <= 0 || box.height <= 0) return null;
  const scale = Math.min(room.x / box.width, room.y / box.height, kWorld_px * 2 ** kMaxZoom);
  const size = { width: box.width * scale, height: box.height * scale };
  return { left: padding.left + (room.x - size.width) / 2, top: padding.top + (room.y - size.height) / 2, ...size, bearing: 0 };
}

/**
 * @param {Bounds} bounds
 * @param {{width: number, height: number}} container
 * @param {ViewPlace} view
 * @returns {PosterPlace}
 */
export function viewedPlace(bounds, { width, height }, { zoom, lat, lon, bearing }) {
  const scale = kWorld_px * 2 ** zoom;
  const centre = tilePosition(lon, lat, 0);
  const box = tileBox(bounds, 0);
  return {
    left: width / 2 + (box.from.x - centre.x) * scale,
    top: height / 2 + (box.from.y - centre.y) * scale,
    width: box.width * scale,
    height: box.height * scale,
    bearing,
  };
}
