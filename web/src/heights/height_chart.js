// Heights along a line as a small chart: pointer or arrow keys go along it and say the height there.
/** @import { ProfileSample } from '../shared/types.js' */
/** @import { DrawnProfile } from './surface_profile.js' */
/** @import { Units } from '../shared/units.js' */
import { h, svg } from '../shared/dom.js';
import { strings } from '../shared/flight_strings.js';
import { heightIn, lengthIn, metresPer } from '../shared/units.js';

const kWidth = 300;
const kHeight = 116;
const kLetter = 6.5;  // about the width of a letter of a tick
const kRight = 6;
const kTop = 8;
const kBottom = 22;
const kTicks = 3;
const kKeySteps = 50;
// Of less the chart would be of what the ground is not known to.
const kMinRange_m = 1;

/** Along the line. @param {number} metres @param {Units} units */
const distanceIn = (metres, units) => (metres < 0.005 ? heightIn(0, units, [0]) : lengthIn(metres, units));

/** @typedef {ProfileSample & {height_m: number}} KnownSample */

/**
 * Round values between two, at least two of them.
 * @param {number} low
 * @param {number} high
 * @returns {number[]}
 */
export function roundTicks(low, high) {
  const rough = (high - low) / kTicks;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * (rough / power <= 1 ? 1 : rough / power <= 2 ? 2 : rough / power <= 5 ? 5 : 10);
  const ticks = [];
  for (let i = Math.ceil(low / step); i * step <= high + step * 1e-9; i += 1) ticks.push(i * step);
  return ticks;
}

/**
 * What the chart reaches over: what the ground does, and never so little that it shows mere noise.
 * @param {number} lowest_m
 * @param {number} highest_m
 * @returns {[number, number]}
 */
export function chartRange(lowest_m, highest_m) {
  const range = Math.max(highest_m - lowest_m, kMinRange_m) * 1.1;
  const middle = (lowest_m + highest_m) / 2;
  return [middle - range / 2, middle + range / 2];
}

/**
 * @param {ProfileSample[]} samples
 * @returns {KnownSample[][]} runs of samples that have a height
 */
export function knownRuns(samples) {
  /** @type {KnownSample[][]} */
  const runs = [];
  let is_in_run = false;
  for (const sample of samples) {
    if (sample.height_m !== null) {
      if (!is_in_run) runs.push([]);
      runs[runs.length - 1].push(/** @type {KnownSample} */ (sample));
    }
    is_in_run = sample.height_m !== null;
  }
  return runs;
}

/**
 * @param {ProfileSample[]} samples by distance, at least one
 * @param {number} distance_m
 * @returns {ProfileSample} the nearest
 */
export function sampleNear(samples, distance_m) {
  let from = 0;
  let to = samples.length - 1;
  while (to - from > 1) {
    const middle = (from + to) >> 1;
    if (samples[middle].distance_m <= distance_m) from = middle;
    else to = middle;
  }
  return distance_m - samples[from].distance_m <= samples[to].distance_m - distance_m ? samples[from] : samples[to];
}

/**
 * @param {DrawnProfile} profile that has heights
 * @param {Units} units
 * @param {(sample: ProfileSample|null) => void} on_point where on the line one is; null: nowhere
 * @returns {HTMLElement}
 */
export function heightChart(profile, units, on_point) {
  const words = strings.heights;
  const { samples } = profile;
  const length_m = Math.max(profile.length_m, 1e-3);
  const below_runs = knownRuns(profile.below);
  const ends_m = [profile.lowest_m ?? 0, profile.highest_m ?? 0, ...below_runs.flat().map(({ height_m }) => height_m)];
  const [low_m, high_m] = chartRange(Math.min(...ends_m), Math.max(...ends_m));
  const per_m = metresPer(units);
  const ticks = roundTicks(low_m / per_m, high_m / per_m).map((tick) => tick * per_m);
  const tick_words = ticks.map((tick) => heightIn(tick, units, ticks));
  const left = 8 + kLetter * Math.max(...tick_words.map(({ length }) => length));
  const x = (/** @type {number} */ distance_m) => left + ((kWidth - left - kRight) * distance_m) / length_m;
  const y = (/** @type {number} */ height_m) => kTop + ((kHeight - kTop - kBottom) * (high_m - height_m)) / (high_m - low_m);
  const at = (/** @type {number} */ value) => value.toFixed(1);
  const runs = knownRuns(samples);
  const points = (/** @type {KnownSample[]} */ run) => run.map((sample) => `${at(x(sample.distance_m))} ${at(y(sample.height_m))}`).join('L');
  const lineOf = (/** @type {KnownSample[][]} */ of) => of.map((run) => `M${points(run)}`).join('');
  const floor = at(kHeight - kBottom);
  const filled = runs.map((run) => `M${at(x(run[0].distance_m))} ${floor}L${points(run)}L${at(x(run[run.length - 1].distance_m))} ${floor}Z`).join('');
  const cursor_line = svg('line', { class: 'height-cursor', y1: kTop, y2: kHeight - kBottom, x1: 0, x2: 0 });
  const cursor_dot = svg('circle', { class: 'height-dot', r: 4 });
  const cursor = svg('g', { visibility: 'hidden' }, cursor_line, cursor_dot);
  const picture = svg(
    'svg',
    { class: 'height-picture', viewBox: `0 0 ${kWidth} ${kHeight}`, 'aria-hidden': 'true', focusable: 'false' },
    ...ticks.flatMap((tick, i) => [
      svg('line', { class: 'height-grid', x1: left, x2: kWidth - kRight, y1: at(y(tick)), y2: at(y(tick)) }),
      svg('text', { class: 'height-tick', x: left - 5, y: at(y(tick) + 3.5), 'text-anchor': 'end' }, tick_words[i]),
    ]),
    svg('path', { class: 'height-fill', d: filled }),
    svg('path', { class: 'height-line height-ground', d: lineOf(below_runs) }),
    svg('path', { class: 'height-line', d: lineOf(runs) }),
    svg('text', { class: 'height-tick', x: left, y: kHeight - 6, 'text-anchor': 'start' }, distanceIn(0, units)),
    svg('text', { class: 'height-tick', x: kWidth - kRight, y: kHeight - 6, 'text-anchor': 'end' }, lengthIn(profile.length_m, units)),
    cursor,
  );
  const told = h('p', { class: 'height-told fine', 'aria-hidden': 'true' }, words.how);
  const slider = h(
    'div',
    { class: 'height-slider', id: 'height-chart', role: 'slider', tabindex: 0, 'aria-label': words.along, 'aria-valuemin': 0, 'aria-valuemax': Math.round(profile.length_m), 'aria-valuenow': 0, 'aria-valuetext': distanceIn(0, units) },
    picture,
  );
  let distance_m = 0;
  const show = (/** @type {number} */ next_m) => {
    distance_m = Math.min(profile.length_m, Math.max(0, next_m));
    const sample = sampleNear(samples, distance_m);
    const where = distanceIn(sample.distance_m, units);
    const below_m = profile.below.length > 0 ? sampleNear(profile.below, distance_m).height_m : null;
    const here = sample.height_m === null ? '' : heightIn(sample.height_m, units);
    const words_here = here === '' ? words.unknown_at(where) : below_m === null ? words.at(where, here) : words.at_over(where, here, heightIn(below_m, units));
    cursor.setAttribute('visibility', 'visible');
    cursor_line.setAttribute('x1', at(x(sample.distance_m)));
    cursor_line.setAttribute('x2', at(x(sample.distance_m)));
    cursor_dot.setAttribute('visibility', sample.height_m === null ? 'hidden' : 'inherit');
    cursor_dot.setAttribute('cx', at(x(sample.distance_m)));
    cursor_dot.setAttribute('cy', at(y(sample.height_m ?? low_m)));
    slider.setAttribute('aria-valuenow', String(Math.round(sample.distance_m)));
    slider.setAttribute('aria-valuetext', words_here);
    told.textContent = words_here;
    on_point(sample);
  };
  const leave = () => {
    cursor.setAttribute('visibility', 'hidden');
    told.textContent = words.how;
    on_point(null);
  };
  const follow = (/** @type {PointerEvent} */ event) => {
    const box = picture.getBoundingClientRect();
    const in_picture = ((event.clientX - box.left) / box.width) * kWidth;
    show(((in_picture - left) / (kWidth - left - kRight)) * length_m);
  };
  slider.addEventListener('pointermove', follow);
  slider.addEventListener('pointerdown', follow);
  slider.addEventListener('pointerleave', () => document.activeElement !== slider && leave());
  slider.addEventListener('focus', () => show(distance_m));
  slider.addEventListener('blur', leave);
  slider.addEventListener('keydown', (event) => {
    const step_m = length_m / kKeySteps;
    /** @type {Record<string, number>} */
    const next = { ArrowRight: distance_m + step_m, ArrowUp: distance_m + step_m, ArrowLeft: distance_m - step_m, ArrowDown: distance_m - step_m, PageUp: distance_m + 10 * step_m, PageDown: distance_m - 10 * step_m, Home: 0, End: profile.length_m };
    if (!(event.key in next)) return;
    event.preventDefault();
    event.stopPropagation();
    show(next[event.key]);
  });
  const key = (/** @type {string} */ line, /** @type {string} */ label) => h('li', {}, h('span', { class: `height-key ${line}`, 'aria-hidden': 'true' }), label);
  const legend = profile.is_surface && h('ul', { class: 'height-legend fine', id: 'height-legend' }, key('', words.surface), below_runs.length > 0 && key('height-key-ground', words.ground));
  return h('div', { class: 'height-chart' }, slider, legend, told);
}
