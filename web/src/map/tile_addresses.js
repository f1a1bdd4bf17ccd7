// Which tile lies where, and under what address.
/** @import { Bounds } from '../shared/types.js' */
import { at } from '../shared/router.js';

/**
 * Web Mercator position in tiles of a zoom level.
 * @param {number} lon_deg
 * @param {number} lat_deg
 * @param {number} zoom
 * @returns {{x: number, y: number}}
 */
export function tilePosition(lon_deg, lat_deg, zoom) {
  const sin = Math.sin((lat_deg * Math.PI) / 180);
  const n = 2 ** zoom;
  return { x: ((lon_deg + 180) / 360) * n, y: (0.5 - Math.atanh(sin) / (2 * Math.PI)) * n };
}

/** The corners of bounds in tiles of a zoom level. @param {Bounds} bounds @param {number} zoom */
export function tileBox([west, south, east, north], zoom) {
  const from = tilePosition(west, north, zoom);
  const to = tilePosition(east, south, zoom);
  return { from, to, width: to.x - from.x, height: to.y - from.y };
}

/** Does a map lie across the antimeridian? Then its bounds go on beyond it. @param {Bounds} bounds */
export const isAcross = ([west, , east]) => west < -180 || east > 180;

/**
 * Where a source has tiles, as the library takes it: it cuts bounds off at the antimeridian, so that half of a map across that
 * would be missing.
 * @param {Bounds|null|undefined} bounds
 * @returns {{bounds?: Bounds}} empty: everywhere
 */
export const sourceBounds = (bounds) => (!bounds || isAcross(bounds) ? {} : { bounds });

/**
 * Tile addresses of the own host only: whatever name the server believes to have, the page asks where it came from.
 * @param {string} template
 * @returns {string}
 */
export function ownHost(template) {
  const braces = template.replaceAll('{', '%7B').replaceAll('}', '%7D');
  const url = new URL(braces, location.href);
  return (location.origin + at(url.pathname) + url.search).replaceAll('%7B', '{').replaceAll('%7D', '}');
}

/**
 * @param {Bounds} bounds
 * @param {number} min_zoom
 * @param {number} max_zoom
 * @returns {{z: number, x: number, y: number}[]} the tiles of these zooms that touch the bounds; beyond the antimeridian they are at the other end
 */
export function tilesIn(bounds, min_zoom, max_zoom) {
  const tiles = [];
  for (let z = min_zoom; z <= max_zoom; z += 1) {
    const { from, to } = tileBox(bounds, z);
    const around = 2 ** z;
    for (let x = Math.floor(from.x); x <= Math.floor(to.x); x += 1) {
      for (let y = Math.floor(from.y); y <= Math.floor(to.y); y += 1) tiles.push({ z, x: ((x % around) + around) % around, y });
    }
  }
  return tiles;
}

/**
 * @param {Bounds} bounds
 * @returns {number} the finest zoom whose tiles are as large as the bounds or larger: four of them cover these at most
 */
export function zoomOfFew(bounds) {
  const { width, height } = tileBox(bounds, 0);
  return Math.floor(-Math.log2(Math.max(width, height)));
}
