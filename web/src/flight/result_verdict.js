// How good a map is, in a sentence and a colour, above its report.
/** @import { Report } from '../shared/types.js' */
/** @import { Grade } from './flight_words.js' */
import { h } from '../shared/dom.js';
import { icon } from '../shared/icons.js';
import { strings } from '../shared/flight_strings.js';
import { gradeOf, isScaleKnown, limitWords, statusWords } from './flight_words.js';

/** Is the size or the north of an unplaced map guessed? Those that a log gave are not. @param {Report} report */
export function isGuessed(report) {
  if (report.is_placed !== false) return false;
  if (!report.quality) return report.alignment?.placed_by !== 'records';
  return !isScaleKnown(report.quality) || report.quality.limits.some(({ kind }) => kind === 'north_guessed');
}

/** Do its lengths, areas and resolution mean something? @param {Report} report */
export const hasScale = (report) => (report.quality ? isScaleKnown(report.quality) : !isGuessed(report));

/**
 * @param {Report} report
 * @returns {{grade: Grade, title: string, sentences: string[]}}
 */
export function resultWords(report) {
  const words = strings.report.verdict;
  const sentences = (report.quality?.limits ?? []).map(limitWords);
  if (report.is_placed === false && hasScale(report)) sentences.push(words.unplaced_measured);
  if (!report.quality && report.photos.total > 0) sentences.push(words.unjudged);
  if (sentences.length === 0) sentences.push(words.good(report.photos.total));
  return { grade: gradeOf(report.quality), title: statusWords(report.quality), sentences };
}

/**
 * @param {Report} report
 * @returns {HTMLElement}
 */
export function resultView(report) {
  const { grade, title, sentences } = resultWords(report);
  return h(
    'div',
    { class: `result-verdict result-${grade}`, id: 'result-verdict' },
    icon(grade === 'good' ? 'check' : 'warning'),
    h('div', {}, h('p', {}, h('strong', {}, `${title}.`), ' ', sentences[0]), sentences.length > 1 && h('p', {}, sentences.slice(1).join(' '))),
  );
}
