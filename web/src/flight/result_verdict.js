// How good a map is, in a sentence and a colour: green when every photo is aligned, amber when some are left out or lie by
// their records alone, red when nothing says where the map lies.
/** @import { Flight, PhotoCollection, PhotoCounts, Report } from '../shared/types.js' */
import { h } from '../shared/dom.js';
import { formatError } from '../shared/format.js';
import { icon } from '../shared/icons.js';
import { strings } from '../shared/strings.js';

/** @typedef {'good'|'amber'|'bad'} Grade */

// What a receiver of a phone or a drone is good for: a map that lies further off than that is not where one looks for it.
const kUsualError_m = 10;

/** Are the size and the north of an unplaced map guessed? Those that a log gave are not. @param {Report} report */
export const isGuessed = (report) => report.is_placed === false && report.alignment?.placed_by !== 'records';

/** @param {PhotoCounts|null|undefined} photos @returns {boolean} whether all are aligned */
export const isWhole = (photos) => !photos || (photos.left_out === 0 && photos.pose_only === 0);

/**
 * The state of a flight with a map, in two or three words.
 * @param {Flight} flight
 * @returns {{text: string, is_whole: boolean}}
 */
export function readyWords(flight) {
  const photos = flight.photos;
  if (!photos || isWhole(photos)) return { text: strings.states.ready, is_whole: true };
  return { text: photos.left_out > 0 ? strings.states.ready_without(photos.left_out) : strings.states.ready_unaligned(photos.pose_only), is_whole: false };
}

/**
 * @param {Report} report
 * @param {PhotoCollection|null} photos
 * @returns {{grade: Grade, sentences: string[]}}
 */
export function resultWords(report, photos) {
  const words = strings.report.verdict;
  const { total, aligned, pose_only, left_out } = report.photos;
  const sentences = [];
  if (report.is_placed === false) sentences.push(isGuessed(report) ? words.unplaced : words.unplaced_measured);
  if (left_out > 0) sentences.push(words.left_out(left_out, total));
  if (aligned === 0 && pose_only > 1) sentences.push(words.none_aligned);
  else if (pose_only > 0) sentences.push(words.pose_only(pose_only));
  const radius_m = report.is_placed === false ? null : medianError(photos);
  const is_far_off = radius_m !== null && radius_m > kUsualError_m;
  if (sentences.length === 0) sentences.push(words.good(total));
  if (is_far_off) sentences.push(words.far_off);
  if (radius_m !== null) sentences.push(words.accuracy(formatError(radius_m)));
  return { grade: report.is_placed === false ? 'bad' : isWhole(report.photos) && !is_far_off ? 'good' : 'amber', sentences };
}

/** @param {PhotoCollection|null} photos @returns {number|null} metres */
function medianError(photos) {
  const radii = (photos?.features ?? [])
    .map(({ properties }) => properties.error_radius_m)
    .filter((radius) => typeof radius === 'number' && Number.isFinite(radius))
    .map(Number)
    .sort((a, b) => a - b);
  return radii.length > 0 ? radii[Math.floor((radii.length - 1) / 2)] : null;
}

/**
 * @param {Report} report
 * @param {PhotoCollection|null} photos
 * @returns {HTMLElement}
 */
export function resultView(report, photos) {
  const { grade, sentences } = resultWords(report, photos);
  return h(
    'div',
    { class: `result-verdict result-${grade}`, id: 'result-verdict' },
    icon(grade === 'good' ? 'check' : 'warning'),
    h('p', {}, sentences.join(' ')),
  );
}
