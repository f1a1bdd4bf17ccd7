// The map of all flights beside the list: the outlines of the land and a mark for each flight, its picture where there
// is room. Drawn here and not by the map library, which weighs more than all the rest of the first view.
/** @import { Bounds, Flight } from '../shared/types.js' */
import { thumbnailPath } from '../shared/api.js';
import { h, onEscape, put } from '../shared/dom.js';
import { distanceTold, roundLength } from '../shared/format.js';
import { button, toolButton } from '../shared/icons.js';
import { parseRoute, routeHash } from '../shared/router.js';
import { fixed, number } from '../shared/language.js';
import { strings } from '../shared/strings.js';

// World units: Web Mercator, 0..1 from 180 degrees west and from north to south.
/** @typedef {{x: number, y: number, scale: number}} View the centre in world units; pixels a world */
/** @typedef {{left: number, top: number, right: number, bottom: number}} Box in world units */
/** @typedef {{flight: Flight, box: Box}} Placed */
/** @typedef {{members: Placed[], x_px: number, y_px: number, box: Box}} Group around a place of the screen */

const kMargin_px = 80;  // the tools do not cover a mark
const kStep = 2;
const kNames = 14;  // of marks in sight that are named; more would cover each other
const kPicture_px = 44;
const kScale_px = 120;  // at most
const kSteepest_deg = 85.05;
// About half a metre a pixel: the length of a field fills the window.
const kClosest = 256 * 2 ** 18;
// A flight alone is shown with its surroundings.
const kFitClosest = 256 * 2 ** 17;
const kApart_px = 38;
const kGrid_px = 150;  // between two lines of the grid, at least
const kLabel_px = 64;  // what a label of them may take
const kAround_m = 40_075_016.686;  // the equator

/**
 * @param {{on_point: (id: string) => void}} listener the flight whose mark is pointed at; '' for none
 * @returns {{element: HTMLElement, show: (flights: Flight[]) => void, point: (id: string) => void}}
 */
export function overviewMap(listener) {
  const words = strings.overview;
  const canvas = h('canvas', { class: 'overview-land', 'aria-hidden': 'true' });
  const marks = h('div', { class: 'overview-marks' });
  const bar = h('p', { class: 'overview-scale', 'aria-hidden': 'true' });
  const choice = h('div', { class: 'overview-choice floating', id: 'overview-choice', hidden: true });
  const element = h(
    'section',
    { class: 'overview', id: 'overview', 'aria-label': words.label },
    canvas,
    marks,
    choice,
    h('div', { class: 'tools' }, h('div', { class: 'tool-group' }, toolButton('plus', strings.page.zoom_in, () => zoom(kStep)), toolButton('minus', strings.page.zoom_out, () => zoom(1 / kStep)), toolButton('fit', words.fit, () => fit()))),
    h('div', { class: 'overview-foot' }, bar, h('p', { class: 'overview-makers' }, words.makers)),
  );
  /** @type {Placed[]} */
  let placed = [];
  /** @type {View} */
  let view = { x: 0.5, y: 0.5, scale: 256 };
  let is_moved = false;
  /** @type {Path2D|null} */
  let land = null;
  let pointed = '';
  let is_asked = false;
  /** @type {Map<string, HTMLElement>} */
  let shown = new Map();
  const size = () => /** @type {[number, number]} */ ([element.clientWidth, element.clientHeight]);

  const draw = () => {
    is_asked = false;
    const [width, height] = size();
    if (width === 0 || height === 0) return;
    view = bounded(view, width, height);
    drawLand(canvas, land, view, width, height);
    drawScale(bar, view);
    const found = groups(placed, view, width, height);
    const is_named = found.length <= kNames;
    marks.classList.toggle('named', is_named);
    /** @type {Map<string, HTMLElement>} */
    const next = new Map();
    for (const group of found) {
      const key = group.members.map(({ flight }) => `${flight.id} ${flight.revision} ${flight.state} ${flight.name}`).join('|');
      const mark = shown.get(key) ?? (group.members.length > 1 ? groupMark(group) : flightMark(group.members[0].flight));
      const width_px = (group.box.right - group.box.left) * view.scale;
      const height_px = (group.box.bottom - group.box.top) * view.scale;
      const is_picture = group.members.length === 1 && is_named && Boolean(group.members[0].flight.tilejson) && Math.min(width_px, height_px) >= kPicture_px;
      mark.classList.toggle('has-picture', is_picture);
      mark.style.transform = `translate(${group.x_px.toFixed(1)}px, ${group.y_px.toFixed(1)}px)`;
      drawFootprint(mark, group, is_picture, width_px, height_px);
      next.set(key, mark);
      if (!mark.isConnected) marks.append(mark);
    }
    for (const [key, mark] of shown) if (!next.has(key)) mark.remove();
    shown = next;
    drawPointed();
  };
  const redraw = () => {
    if (is_asked) return;
    is_asked = true;
    requestAnimationFrame(draw);
  };

  /** @param {Flight} flight */
  const flightMark = (flight) =>
    h(
      'a',
      { class: `overview-mark mark-${flight.state}`, href: routeHash({ view: 'flight', id: flight.id }), 'data-ids': flight.id, 'aria-label': flight.name, draggable: 'false', on: pointing(flight.id) },
      h('span', { class: 'mark-dot' }),
      h('span', { class: 'mark-name' }, flight.name),
    );
  /** @param {Group} group */
  const groupMark = (group) =>
    button(number(group.members.length), () => openGroup(group), { class: 'overview-mark mark-group', 'data-ids': group.members.map(({ flight }) => flight.id).join(' '),
      'aria-label': words.group(group.members.length), title: words.group(group.members.length) });
  /** @param {string} id */
  const pointing = (id) => ({
    pointerenter: () => listener.on_point(id),
    pointerleave: () => listener.on_point(''),
  });

  const drawPointed = () => {
    for (const mark of shown.values()) mark.classList.toggle('pointed', pointed !== '' && (mark.dataset.ids ?? '').split(' ').includes(pointed));
  };

  /** @param {Group} group */
  const openGroup = (group) => {
    const next = parted(group, view, ...size());
    if (next) {
      move(next);
      return;
    }
    // All of one place: the names tell them apart.
    put(choice, h('ul', {}, ...group.members.map(({ flight }) => h('li', {}, h('a', { href: routeHash({ view: 'flight', id: flight.id }) }, flight.name)))));
    choice.hidden = false;
    choice.querySelector('a')?.focus();
  };
  onEscape(choice, () => (choice.hidden = true));

  /** @param {View} next */
  const move = (next) => {
    view = next;
    is_moved = true;
    choice.hidden = true;
    redraw();
  };
  const fit = () => {
    is_moved = false;
    choice.hidden = true;
    if (placed.length > 0) view = fitted(around(placed.map(({ box }) => box)), ...size(), kMargin_px);
    redraw();
  };
  /** @param {number} by @param {number} [x_px] from the middle, stays where it is @param {number} [y_px] */
  const zoom = (by, x_px = 0, y_px = 0) => {
    const next = bounded({ ...view, scale: view.scale * by }, ...size());
    const kept = 1 / view.scale - 1 / next.scale;
    move({ ...next, x: view.x + x_px * kept, y: view.y + y_px * kept });
  };
  const follow = async () => {
    const { followPointer } = await import('../shared/follow_pointer.js');
    followPointer(element, { pan: (x_px, y_px) => move({ ...view, x: view.x - x_px / view.scale, y: view.y - y_px / view.scale }), zoom });
  };
  // Nobody moves the map before there is a pointer over it.
  element.addEventListener('pointerenter', () => void follow().catch((error) => console.debug('the map does not follow the pointer', error)), { once: true });

  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', redraw);
  let is_land_asked = false;
  const askLand = () => {
    if (is_land_asked) return;
    is_land_asked = true;
    void loadLand().then((path) => {
      land = path;
      redraw();
    });
  };
  // With the list; who opens a flight is not kept waiting for it.
  if (parseRoute(location.hash).view === 'home') askLand();
  new ResizeObserver(() => (is_moved ? redraw() : fit())).observe(element);

  return {
    element,
    show(flights) {
      askLand();
      const before = new Set(placed.map(({ flight }) => flight.id));
      placed = flights.flatMap((flight) => {
        const bounds = placeOf(flight);
        return bounds ? [{ flight, box: boxOf(bounds) }] : [];
      });
      const is_other = placed.length < before.size || placed.some(({ flight }) => !before.has(flight.id));
      // A search moves the view; one flight more, while someone looks at the map, does not.
      if (is_other && (!is_moved || placed.length < before.size)) fit();
      else redraw();
    },
    point(id) {
      pointed = id;
      drawPointed();
    },
  };
}

/**
 * The footprint at its true size, with the map in it where it is large enough.
 * @param {HTMLElement} mark
 * @param {Group} group
 * @param {boolean} is_picture
 * @param {number} width_px
 * @param {number} height_px
 */
function drawFootprint(mark, group, is_picture, width_px, height_px) {
  let image = mark.querySelector('img');
  if (!is_picture) {
    image?.remove();
    return;
  }
  const { flight } = group.members[0];
  if (!image && !mark.dataset.has_none) {
    image = h('img', { class: 'mark-picture', alt: '', src: thumbnailPath(flight), draggable: 'false', fetchpriority: 'low' });
    image.addEventListener('error', () => {
      mark.dataset.has_none = 'yes';  // not asked for again at each move
      image?.remove();
    });
    mark.prepend(image);
  }
  if (!image) return;
  mark.style.setProperty('--below', `${Math.max(27, height_px / 2 + 18)}px`);
  image.style.width = `${width_px}px`;
  image.style.height = `${height_px}px`;
}

/** @param {HTMLElement} bar @param {View} view */
function drawScale(bar, view) {
  const metres = metresOfPixel(view);
  const length_m = roundLength(metres * kScale_px);
  bar.textContent = distanceTold(length_m);
  bar.style.width = `${length_m / metres}px`;
}

/** @returns {Promise<Path2D|null>} in world units; null where they cannot be had: the overview is of use without them */
async function loadLand() {
  try {
    const response = await fetch(new URL('../../vendor/land.geojson', import.meta.url).href);
    return response.ok ? pathOf(await response.json()) : null;
  } catch (error) {
    console.debug('no outlines of the land', error);
    return null;
  }
}

/** @param {GeoJSON.FeatureCollection|GeoJSON.Feature} land @returns {Path2D} */
function pathOf(land) {
  const path = new Path2D();
  for (const { geometry } of land.type === 'FeatureCollection' ? land.features : [land]) {
    const polygons = geometry.type === 'MultiPolygon' ? geometry.coordinates : geometry.type === 'Polygon' ? [geometry.coordinates] : [];
    for (const ring of polygons.flat()) {
      for (const outline of outlinesOf(ring)) {
        outline.forEach(({ x, y }, i) => (i === 0 ? path.moveTo(x, y) : path.lineTo(x, y)));
        path.closePath();
      }
    }
  }
  return path;
}

/**
 * A ring in world units, of one piece where it crosses the antimeridian: there it leaves the world, and enters it once
 * more from the other side. One round a pole goes by way of the pole.
 * @param {GeoJSON.Position[]} ring
 * @returns {{x: number, y: number}[][]}
 */
export function outlinesOf(ring) {
  let turns = 0;
  const outline = ring.map(([lon, lat], i) => {
    const step = i === 0 ? 0 : lon - ring[i - 1][0];
    if (Math.abs(step) > 180) turns -= Math.sign(step);
    const { x, y } = worldPosition(lon, Math.min(kSteepest_deg, Math.max(-kSteepest_deg, lat)));
    return { x: x + turns, y };
  });
  if (turns !== 0) {
    const pole = outline[0].y > 0.5 ? 1 : 0;
    outline.push({ x: outline[outline.length - 1].x, y: pole }, { x: outline[0].x, y: pole });
  }
  const at = (/** @type {number} */ worlds) => outline.map(({ x, y }) => ({ x: x + worlds, y }));
  return [outline, ...(outline.some(({ x }) => x > 1) ? [at(-1)] : []), ...(outline.some(({ x }) => x < 0) ? [at(1)] : [])];
}

/**
 * @param {HTMLCanvasElement} canvas
 * @param {Path2D|null} land
 * @param {View} view
 * @param {number} width
 * @param {number} height
 */
function drawLand(canvas, land, view, width, height) {
  const fine = Math.min(2, devicePixelRatio);
  const [columns, rows] = [Math.round(width * fine), Math.round(height * fine)];
  if (canvas.width !== columns || canvas.height !== rows) Object.assign(canvas, { width: columns, height: rows });
  const context = canvas.getContext('2d');
  if (!context) return;
  const style = getComputedStyle(document.documentElement);
  context.setTransform(1, 0, 0, 1, 0, 0);
  context.fillStyle = style.getPropertyValue('--ground');
  context.fillRect(0, 0, canvas.width, canvas.height);
  // Close up the coarse outline would be wrong by kilometres.
  const zoom = Math.log2(view.scale / 512);
  const strength = Math.min(1, Math.max(0, (10 - zoom) / 2));
  if (land && strength > 0) {
    context.globalAlpha = strength;
    context.setTransform(view.scale * fine, 0, 0, view.scale * fine, (width / 2 - view.x * view.scale) * fine, (height / 2 - view.y * view.scale) * fine);
    context.save();
    context.beginPath();
    context.rect(0, 0, 1, 1);
    context.clip();
    context.fillStyle = style.getPropertyValue('--land');
    context.fill(land);
    context.strokeStyle = style.getPropertyValue('--line-strong');
    context.lineWidth = 0.7 / view.scale;
    context.globalAlpha *= 0.7;
    context.stroke(land);
    context.restore();
    context.globalAlpha = 1;
  }
  drawGrid(context, view, width, height, fine);
}

/**
 * Meridians and parallels with their degrees: also a part of the world without coasts says where it is.
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {number} width
 * @param {number} height
 * @param {number} fine pixels of the screen in one of the page
 */
function drawGrid(context, view, width, height, fine) {
  const { line_digits, step_deg } = gridOf(view.scale);
  const style = getComputedStyle(document.documentElement);
  const [north, south, east, west] = strings.overview.sides;
  const label = (/** @type {number} */ degrees, /** @type {string} */ above, /** @type {string} */ below) =>
    `${fixed(Math.abs(degrees), line_digits)}°${degrees === 0 ? '' : `\u00a0${degrees > 0 ? above : below}`}`;
  const steps = (/** @type {number} */ from, /** @type {number} */ to) => {
    const first = Math.ceil(from / step_deg);
    return Array.from({ length: Math.max(0, Math.floor(to / step_deg) - first + 1) }, (_, i) => (first + i) * step_deg);
  };
  const lon_of = (/** @type {number} */ x_px) => (view.x + (x_px - width / 2) / view.scale) * 360 - 180;
  const lat_of = (/** @type {number} */ y_px) => (180 / Math.PI) * Math.asin(Math.tanh(2 * Math.PI * (0.5 - view.y - (y_px - height / 2) / view.scale)));
  context.setTransform(fine, 0, 0, fine, 0, 0);
  context.font = '11px system-ui, sans-serif';
  context.textBaseline = 'top';
  context.fillStyle = style.getPropertyValue('--muted');
  context.strokeStyle = style.getPropertyValue('--line-strong');
  context.lineWidth = 1 / fine;
  context.globalAlpha = 0.45;
  context.beginPath();
  const meridians = steps(Math.max(-180, lon_of(0)), Math.min(180, lon_of(width)));
  const parallels = steps(Math.max(-kSteepest_deg, lat_of(height)), Math.min(kSteepest_deg, lat_of(0)));
  const x_of = (/** @type {number} */ lon) => width / 2 + (worldPosition(lon, 0).x - view.x) * view.scale;
  const y_of = (/** @type {number} */ lat) => height / 2 + (worldPosition(0, lat).y - view.y) * view.scale;
  for (const lon of meridians) {
    context.moveTo(x_of(lon), 0);
    context.lineTo(x_of(lon), height);
  }
  for (const lat of parallels) {
    context.moveTo(0, y_of(lat));
    context.lineTo(width, y_of(lat));
  }
  context.stroke();
  context.globalAlpha = 1;
  // Not below the tools, the scale and each other.
  for (const lon of meridians) if (x_of(lon) > kLabel_px && x_of(lon) < width - 2 * kLabel_px) context.fillText(label(lon, east, west), x_of(lon) + 4, 5);
  for (const lat of parallels) if (y_of(lat) > 20 && y_of(lat) < height - kLabel_px) context.fillText(label(lat, north, south), 6, y_of(lat) + 4);
}

/** How far apart the lines of a grid are, at least kGrid_px. @param {number} scale pixels a world */
export function gridOf(scale) {
  const least_deg = (kGrid_px / scale) * 360;
  if (least_deg > 20) return { step_deg: least_deg > 45 ? 90 : 45, line_digits: 0 };
  const power = 10 ** Math.floor(Math.log10(least_deg));
  const step_deg = power * (least_deg <= 2 * power ? 2 : least_deg <= 5 * power ? 5 : 10);
  return { step_deg, line_digits: Math.max(0, -Math.floor(Math.log10(step_deg) + 1e-9)) };
}

// What part of the world is shown, and which marks fall together there: pure functions.

/** Where it lies: of its map, or of the preview until then. @param {Flight} flight @returns {Bounds|null} null where that is not known */
export function placeOf(flight) {
  return flight.georeferenced === false ? null : (flight.bounds ?? flight.preview?.bounds ?? null);
}

/** The same as tile_addresses.js has of zoom 0, which would be one request more for the first view. @param {number} lon_deg @param {number} lat_deg */
const worldPosition = (lon_deg, lat_deg) => ({ x: (lon_deg + 180) / 360, y: 0.5 - Math.atanh(Math.sin((lat_deg * Math.PI) / 180)) / (2 * Math.PI) });

/** @param {Bounds} bounds @returns {Box} */
export function boxOf([west, south, east, north]) {
  const from = worldPosition(west, north);
  const to = worldPosition(east, south);
  return { left: from.x, top: from.y, right: to.x, bottom: to.y };
}

/** @param {Box[]} boxes at least one @returns {Box} */
const around = (boxes) => ({
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
function bounded(view, width, height) {
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
const metresOfPixel = ({ y, scale }) => kAround_m / Math.cosh(Math.PI * (1 - 2 * y)) / scale;
