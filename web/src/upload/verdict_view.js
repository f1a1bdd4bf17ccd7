// The verdict in words, at the top of the upload.
/** @import { Verdict } from './verdict.js' */
import { h } from '../shared/dom.js';
import { formatDuration, formatLength } from '../shared/format.js';
import { icon } from '../shared/icons.js';
import { strings } from '../shared/strings.js';

/**
 * @param {Verdict} verdict
 * @returns {{facts: string, warnings: string[]}}
 */
export function verdictWords(verdict) {
  const words = strings.verdict;
  const facts = [
    verdict.photos > 0 || verdict.archives === 0 ? strings.flights.photos(verdict.photos) : '',
    verdict.camera,
    verdict.span_m > 0 ? words.span(formatLength(verdict.span_m)) : '',
    verdict.duration_s > 0 ? words.duration(formatDuration(verdict.duration_s)) : '',
    verdict.logs > 0 ? words.logs(verdict.logs) : '',
    verdict.archives > 0 ? words.archives(verdict.archives) : '',
  ];
  const warnings = [];
  const without = verdict.photos - verdict.with_position;
  const is_open = verdict.archives > 0;  // what is missing may be in there
  if (verdict.photos === 0 && !is_open) warnings.push(words.no_photos);
  else if (without > 0 && without === verdict.photos && verdict.logs === 0 && !is_open) warnings.push(words.no_position);
  else if (without > 0) warnings.push(verdict.logs > 0 ? words.some_from_log(without) : words.some_without(without));
  if (verdict.far.length > 0) warnings.push(words.far(verdict.far.length, verdict.far.slice(0, 3).join(', ')));
  if (verdict.photos === 1 && !is_open) warnings.push(words.single);
  // Turning to the next strip takes a while; a pause of minutes is a change of battery or a lost card.
  if (verdict.usual_gap_s > 0 && verdict.longest_gap_s > Math.max(120, 30 * verdict.usual_gap_s)) {
    warnings.push(words.gap(formatDuration(verdict.longest_gap_s)));
  }
  return { facts: facts.filter(Boolean).join(' · '), warnings };
}

/**
 * @param {Verdict} verdict
 * @returns {HTMLElement}
 */
export function verdictView(verdict) {
  const { facts, warnings } = verdictWords(verdict);
  const list = h('ul', { class: 'verdict-warnings' }, ...warnings.map((text) => h('li', {}, icon('warning'), h('span', {}, text))));
  const good = verdict.photos > 0 ? h('p', { class: 'good' }, icon('check'), strings.verdict.good) : null;
  return h('div', { class: 'verdict', id: 'verdict' }, h('p', { class: 'muted' }, facts), warnings.length > 0 ? list : good);
}
