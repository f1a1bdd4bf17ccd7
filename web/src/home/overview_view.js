// What part of the world the overview shows, and which marks fall together there. Pure functions.
// World units: Web Mercator, 0..1 from 180 degrees west and from north to south.
/** @import { Bounds, Flight } from '../shared/types.js' */

/** @typedef {{x: number, y: number, scale: number}} View the centre in world units; pixels a world */
/** @typedef {{left: number, top: number, right: number, bottom: number}} Box in world units */
/** @typedef {{flight: Flight, box: Box}} Placed */
/** @typedef {{members: Placed[], x_px: number, y_px: number, box: Box}} Group around a place of the screen */

// About half a metre a pixel: the length of a field fills the window.
const kClosest = 256 * 2 ** 18;
// A flight alone is shown with its surroundings.
const kFitClosest = 256 * 2 ** 17;
const kApart_px = 38;
const kAround_m = 40_075_016.686;  // the equator

/** Where it lies: of its map, or of the preview until then. @param {Flight} flight @returns {Bounds|null} null where that is not known */
export function placeOf(flight) {
  return flight.georeferenced === false ? null : (flight.bounds ?? flight.preview?.bounds ?? null);
}

/** The same as tile_addresses.js has of zoom 0, which would be one request more for the first view. @param {number} lon_deg @param {number} lat_deg */
export const worldPosition = (lon_deg, lat_deg) => ({ x: (lon_deg + 180) / 360, y: 0.5 - Math.atanh(Math.sin((lat_deg * Math.PI) / 180)) / (2 * Math.PI) });

/** @param {Bounds} bounds @returns {Box} */
export function boxOf([west, south, east, north]) {
  const from = worldPosition(west, north);
  const to = worldPosition(east, south);
  return { left: from.x, top: from.y, right: to.x, bottom: to.y };
}

/** @param {Box[]} boxes at least one @returns {Box} */
export const around = (boxes) => ({
  left: Math.min(...boxes.map(({ left }) => left)),
  top: Math.min(...boxes.map(({ top }) => top)),
  right: Math.max(...boxes.map(({ right }) => right)),
  bottom: Math.max(...boxes.map(({ bottom }) => bottom)),
});

/**
 * @param {View} view
 * @param {number} width
 * @param {number} height
 * @returns {View} the same within the world and the zooms there are
 */
export function bounded(view, width, height) {
  const scale = Math.min(kClosest, Math.max(Math.min(width, height) * 0.9, view.scale));
  return { x: Math.min(1, Math.max(0, view.x)), y: Math.min(1, Math.max(0, view.y)), scale };
}

/**
 * @param {Box} box
 * @param {number} width
 * @param {number} height
 * @param {number} margin_px
 * @param {number} [closest]
 * @returns {View} that shows all of it
 */
export function fitted(box, width, height, margin_px, closest = kFitClosest) {
  const room = { x: Math.max(40, width - 2 * margin_px), y: Math.max(40, height - 2 * margin_px) };
  const scale = Math.min(closest, room.x / Math.max(1e-9, box.right - box.left), room.y / Math.max(1e-9, box.bottom - box.top));
  return bounded({ x: (box.left + box.right) / 2, y: (box.top + box.bottom) / 2, scale }, width, height);
}

/** @param {Group} group @param {View} view @param {number} width @param {number} height @returns {View|null} that parts it; null where none does */
export function parted(group, view, width, height) {
  const next = fitted(group.box, width, height, 90, kClosest);
  return next.scale > 1.5 * view.scale && groups(group.members, next, width, height).length > 1 ? next : null;
}

/**
 * Flights whose marks would cover each other are one group.
 * @param {Placed[]} placed
 * @param {View} view
 * @param {number} width
 * @param {number} height
 * @returns {Group[]} of those in sight
 */
export function groups(placed, view, width, height) {
  /** @type {Map<string, Group[]>} */
  const cells = new Map();
  /** @type {Group[]} */
  const found = [];
  for (const one of placed) {
    const x_px = width / 2 + ((one.box.left + one.box.right) / 2 - view.x) * view.scale;
    const y_px = height / 2 + ((one.box.top + one.box.bottom) / 2 - view.y) * view.scale;
    if (x_px < -kApart_px || y_px < -kApart_px || x_px > width + kApart_px || y_px > height + kApart_px) continue;
    const [column, row] = [Math.floor(x_px / kApart_px), Math.floor(y_px / kApart_px)];
    const near = [-1, 0, 1]
      .flatMap((i) => [-1, 0, 1].flatMap((j) => cells.get(`${column + i} ${row + j}`) ?? []))
      .find((group) => Math.hypot(group.x_px - x_px, group.y_px - y_px) < kApart_px);
    if (near) {
      near.members.push(one);
      near.box = around([near.box, one.box]);
      continue;
    }
    const group = { members: [one], x_px, y_px, box: one.box };
    found.push(group);
    const key = `${column} ${row}`;
    cells.set(key, [...(cells.get(key) ?? []), group]);
  }
  return found;
}

/** On the ground, at the centre. @param {View} view */
export const metresOfPixel = ({ y, scale }) => kAround_m / Math.cosh(Math.PI * (1 - 2 * y)) / scale;
