// How true a map is and whether it is fit for use, in words: in the list, the head of a flight and its report alike. What
// holds, the server says (core/pipeline/report/judge_map.h); nothing is judged here.
/** @import { MapLimit, MapQuality } from '../shared/types.js' */
import { formatError } from '../shared/format.js';
import { number } from '../shared/language.js';
import { strings } from '../shared/strings.js';

/** @typedef {'good'|'amber'|'bad'} Grade */

/** @type {Record<MapQuality['status'], Grade>} */
const kGrades = { ready: 'good', limited: 'amber', doubtful: 'bad', unplaced: 'bad', unknown: 'amber' };

/** Of maps of before there was a word on it, as of imported ones, it is not known. @param {MapQuality|null|undefined} quality @returns {Grade} */
export const gradeOf = (quality) => kGrades[quality?.status ?? 'unknown'];

/** @param {MapQuality|null|undefined} quality */
export const statusWords = (quality) => strings.quality.statuses[quality?.status ?? 'unknown'];

/** @param {MapQuality|null|undefined} quality @returns {string} "±2.3 m"; empty where nothing supports a number */
export const accuracyMark = (quality) => (quality?.absolute.sigma_m ? `\u00b1${formatError(quality.absolute.sigma_m)}` : '');

/** @param {MapQuality} quality */
export function absoluteWords({ status, absolute, limits }) {
  const words = strings.quality;
  if (status === 'unknown') return words.unknown(words.imported);
  const few = limits.find(({ kind }) => kind === 'few_positions');
  if (absolute.by === 'none') return words.unknown(words.no_positions);
  if (absolute.by === 'hand' && absolute.sigma_m === null) return words.unknown(words.by_hand);
  if (absolute.sigma_m === null) return words.unknown(words.few(absolute.count, few?.of ?? absolute.count));
  return words.absolute(`\u00b1${formatError(absolute.sigma_m)}`, words.by[absolute.by](absolute.count));
}

/** @param {MapQuality} quality */
export function relativeWords({ status, relative }) {
  const words = strings.quality;
  if (status === 'unknown') return words.unknown(words.imported);
  if (relative.by === 'none' || relative.error_px === null) return words.unknown(words.no_ties);
  const pixels = words.pixels(number(relative.error_px, { maximumSignificantDigits: 2 }));
  return words.relative(relative.error_m === null ? pixels : `${formatError(relative.error_m)} (${pixels})`, words.seen[relative.by](relative.count));
}

/** @param {MapLimit} limit */
export const limitWords = ({ kind, count, of }) => strings.quality.limits[kind](count, of);

/** Do lengths, areas and the resolution mean something? @param {MapQuality|null|undefined} quality */
export const isScaleKnown = (quality) => !quality?.limits.some(({ kind }) => kind === 'scale_guessed');
