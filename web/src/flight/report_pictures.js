// The report as pictures: how many photos see each spot, how far the photos may be off, where the time went.
/** @import { PhotoCollection, PhotoRecord, Report } from '../shared/types.js' */
/** @import { Units } from '../shared/units.js' */
import { h, svg } from '../shared/dom.js';
import { formatDuration } from '../shared/format.js';
import { lonBeside } from '../map/coordinates.js';
import { boundsOf, isInside } from '../map/geodesy.js';
import { stageName } from './job_view.js';
import { number } from '../shared/language.js';
import { strings } from '../shared/flight_strings.js';
import { errorIn, lengthIn } from '../shared/units.js';

/**
 * How many footprints cover each cell of a grid over their common bounds.
 * @param {PhotoCollection} photos
 * @param {number} longest_side cells along the longer side
 * @returns {{width: number, height: number, counts: Uint16Array, most: number}|null} row 0 is the northernmost
 */
export function coverageGrid(photos, longest_side) {
  const written = photos.features.map((feature) => feature.geometry?.coordinates?.[0] ?? []).filter((ring) => ring.length > 3);
  if (written.length === 0) return null;
  // Across the antimeridian the numbers of some go on, and those of others begin anew.
  const rings = written.map((ring) => {
    const turn_deg = lonBeside(ring[0][0], written[0][0][0]) - ring[0][0];
    return ring.map(([lon, lat]) => [lon + turn_deg, lat]);
  });
  const [west, south, east, north] = boundsOf(rings.flat());
  const squeeze = Math.cos((((south + north) / 2) * Math.PI) / 180);
  const wide = Math.max((east - west) * squeeze, 1e-12);
  const high = Math.max(north - south, 1e-12);
  const cells = longest_side / Math.max(wide, high);
  const width = Math.max(1, Math.round(wide * cells));
  const height = Math.max(1, Math.round(high * cells));
  const counts = new Uint16Array(width * height);
  const column = (/** @type {number} */ lon) => ((lon - west) / (east - west)) * width;
  const row = (/** @type {number} */ lat) => ((north - lat) / (north - south)) * height;
  for (const ring of rings) {
    const cell_ring = ring.map(([lon, lat]) => [column(lon), row(lat)]);
    const [left, top, right, bottom] = boundsOf(cell_ring);
    for (let y = Math.max(0, Math.floor(top)); y < Math.min(height, bottom); y += 1) {
      for (let x = Math.max(0, Math.floor(left)); x < Math.min(width, right); x += 1) {
        if (isInside([x + 0.5, y + 0.5], cell_ring)) counts[y * width + x] += 1;
      }
    }
  }
  return { width, height, counts, most: counts.reduce((most, count) => Math.max(most, count), 0) };
}

/**
 * @param {PhotoCollection} photos
 * @returns {HTMLElement|null}
 */
export function coveragePicture(photos) {
  const grid = coverageGrid(photos, 180);
  if (!grid) return null;
  const canvas = h('canvas', { class: 'coverage', width: grid.width, height: grid.height, role: 'img', 'aria-label': strings.report.coverage_text(grid.most) });
  const context = canvas.getContext('2d');
  if (!context) return null;
  const image = context.createImageData(grid.width, grid.height);
  grid.counts.forEach((count, i) => {
    if (count === 0) return;
    // One photo is nearly white-blue, ten or more deep blue: overlap beyond that changes nothing for the map.
    const depth = Math.min(1, Math.log2(count) / Math.log2(10));
    image.data.set([190 - 170 * depth, 222 - 140 * depth, 235 - 75 * depth, 255], i * 4);
  });
  context.putImageData(image, 0, 0);
  return figure(strings.report.coverage, canvas, strings.report.coverage_text(grid.most));
}

/**
 * @param {string} title
 * @param {Node} picture
 * @param {string} text
 */
function figure(title, picture, text) {
  return h('figure', { class: 'picture' }, h('figcaption', {}, h('strong', {}, title), h('span', { class: 'muted' }, text)), picture);
}

/**
 * @param {number[]} values
 * @param {number} bins
 * @returns {{from: number, to: number, count: number}[]} equal steps from 0
 */
export function histogram(values, bins) {
  const top = Math.max(...values, 1e-6);
  const result = Array.from({ length: bins }, (_, i) => ({ from: (top * i) / bins, to: (top * (i + 1)) / bins, count: 0 }));
  for (const value of values) result[Math.min(bins - 1, Math.floor((value / top) * bins))].count += 1;
  return result;
}

/** @param {number[]} radii_m that are known, rising @param {number} photos of how many @param {Units} units */
export function errorWords(radii_m, photos, units) {
  const words = strings.report;
  const known = words.errors_text(errorIn(radii_m[Math.floor((radii_m.length - 1) / 2)], units), errorIn(radii_m[radii_m.length - 1], units));
  return radii_m.length < photos ? `${known} ${words.errors_unknown(photos - radii_m.length)}` : known;
}

/**
 * @param {PhotoCollection} photos
 * @param {Units} units
 * @returns {HTMLElement|null}
 */
export function errorPicture(photos, units) {
  const radii = photos.features
    .map(({ properties }) => /** @type {PhotoRecord} */ (properties).error_radius_m)
    .filter((radius) => typeof radius === 'number' && Number.isFinite(radius))
    .map(Number)
    .sort((a, b) => a - b);
  if (radii.length < 2) return null;
  const bars = histogram(radii, 10);
  const most = Math.max(...bars.map(({ count }) => count));
  const text = errorWords(radii, photos.features.length, units);
  const chart = svg('svg', { class: 'histogram', viewBox: '0 0 200 66', role: 'img', 'aria-label': text });
  bars.forEach(({ from, to, count }, i) => {
    const height = (count / most) * 48;
    const label = strings.report.error_bar(count, lengthIn(from, units), lengthIn(to, units));
    chart.append(
      svg('rect', { x: i * 20 + 1, y: 50 - height, width: 18, height, rx: 1.5, class: 'bar-fill' }, svg('title', {}, label)),
    );
  });
  chart.append(
    svg('line', { x1: 0, x2: 200, y1: 50.5, y2: 50.5, class: 'axis' }),
    svg('text', { x: 1, y: 62, class: 'axis-text' }, number(0)),
    svg('text', { x: 199, y: 62, class: 'axis-text', 'text-anchor': 'end' }, lengthIn(bars[bars.length - 1].to, units)),
  );
  return figure(strings.report.errors, chart, text);
}

/**
 * @param {Report} report
 * @returns {HTMLElement|null}
 */
export function timingPicture(report) {
  const all = report.timings ?? [];
  const total_s = all.reduce((sum, { wall_s }) => sum + wall_s, 0);
  // What took next to no time explains nothing.
  const timings = all.filter(({ wall_s }) => wall_s > 0.005 * total_s);
  if (timings.length === 0) return null;
  const longest_s = Math.max(...timings.map(({ wall_s }) => wall_s));
  const list = h('dl', { class: 'timings' });
  for (const { stage, wall_s } of timings) {
    const bar = h('span', { class: 'timing-bar' });
    bar.style.setProperty('--share', String(wall_s / longest_s));
    list.append(h('div', {}, h('dt', {}, stageName(stage)), h('dd', {}, bar, h('span', {}, formatDuration(wall_s)))));
  }
  return figure(strings.report.timings, list, `${strings.report.total_time} ${formatDuration(total_s)}`);
}
