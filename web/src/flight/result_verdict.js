// How good a map is, in a sentence and a colour: green when every photo is aligned, amber when some are left out or lie by
// their records alone, red when nothing says where the map lies.
/** @import { PhotoCollection, Report } from '../shared/types.js' */
import { h } from '../shared/dom.js';
import { formatError } from '../shared/format.js';
import { icon } from '../shared/icons.js';
import { isWhole } from './flight_words.js';
import { strings } from '../shared/flight_strings.js';

/** @typedef {'good'|'amber'|'bad'} Grade */

// What a receiver of a phone or a drone is good for: a map that lies further off than that is not where one looks for it.
const kUsualError_m = 10;

/** Are the size and the north of an unplaced map guessed? Those that a log gave are not. @param {Report} report */
export const isGuessed = (report) => report.is_placed === false && report.alignment?.placed_by !== 'records';

/**
 * @param {Report} report
 * @param {PhotoCollection|null} photos
 * @returns {{grade: Grade, accuracy: string, sentences: string[]}} accuracy: '' where it is not known
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
  const accuracy = radius_m === null ? '' : words.accuracy(formatError(radius_m));
  return { grade: report.is_placed === false ? 'bad' : isWhole(report.photos) && !is_far_off ? 'good' : 'amber', accuracy, sentences };
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
  const { grade, accuracy, sentences } = resultWords(report, photos);
  return h(
    'div',
    { class: `result-verdict result-${grade}`, id: 'result-verdict' },
    icon(grade === 'good' ? 'check' : 'warning'),
    h('div', {}, h('p', {}, h('strong', {}, strings.report.titles[grade]), ' ', accuracy || sentences[0]), (accuracy || sentences.length > 1) && h('p', {}, (accuracy ? sentences : sentences.slice(1)).join(' '))),
  );
}
