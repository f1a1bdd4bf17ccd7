// The verdicts in words: the page's own, from the photos' first bytes, at the top of the upload, and the server's, of
// the files that it has. Only the server, which will make the map, can say that all is well.
/** @import { ServerVerdict } from '../shared/types.js' */
/** @import { Verdict } from './verdict.js' */
import { h } from '../shared/dom.js';
import { dotted, formatDuration, formatGsd } from '../shared/format.js';
import { icon } from '../shared/icons.js';
import { list } from '../shared/language.js';
import { saidOf, whyLeftOut } from '../shared/remarks.js';
import { strings } from '../shared/flight_strings.js';
import { areaIn, chosenUnits, inUnits, lengthIn } from '../shared/units.js';

const kNamed = 3;

/** @param {string[]} names @returns {string[]} the first, and how many more there are */
const shortened = (names) => (names.length <= kNamed ? names : [...names.slice(0, kNamed), strings.verdict.others(names.length - kNamed)]);

/**
 * @param {Verdict} verdict
 * @returns {{facts: string, warnings: string[]}}
 */
export function verdictWords(verdict) {
  const words = strings.verdict;
  const is_open = verdict.archives > 0 || verdict.films > 0;  // what is missing may be in there
  const facts = dotted(
    verdict.photos > 0 || !is_open ? strings.flights.photos(verdict.photos) : '',
    verdict.camera,
    verdict.span_m > 0 ? words.span(lengthIn(verdict.span_m, chosenUnits())) : '',
    verdict.duration_s > 0 ? words.duration(formatDuration(verdict.duration_s)) : '',
    verdict.films > 0 ? words.films(verdict.films) : '',
    verdict.logs > 0 ? words.logs(verdict.logs) : '',
    verdict.archives > 0 ? words.archives(verdict.archives) : '',
  );
  const warnings = [];
  const without = verdict.photos - verdict.with_position;
  if (verdict.photos === 0 && !is_open) warnings.push(words.no_photos);
  else if (without > 0 && without === verdict.photos && verdict.logs === 0 && !is_open) warnings.push(words.no_position);
  else if (without > 0) warnings.push(verdict.logs > 0 ? words.some_from_log(without) : words.some_without(without));
  if (verdict.far.length > 0) warnings.push(words.far(verdict.far.length, list(shortened(verdict.far))));
  if (verdict.photos === 1 && !is_open) warnings.push(words.single);
  // Turning to the next strip takes a while; a pause of minutes is a change of battery or a lost card.
  if (verdict.usual_gap_s > 0 && verdict.longest_gap_s > Math.max(120, 30 * verdict.usual_gap_s)) {
    warnings.push(words.gap(formatDuration(verdict.longest_gap_s)));
  }
  return { facts, warnings };
}

/**
 * @param {Verdict} verdict
 * @returns {HTMLElement}
 */
export function verdictView(verdict) {
  const { warnings } = verdictWords(verdict);
  const notes = h('ul', { class: 'verdict-warnings' }, ...warnings.map((text) => h('li', {}, icon('warning'), h('span', {}, text))));
  const good = verdict.photos > 0 ? h('p', { class: 'muted' }, strings.verdict.good) : null;
  return h('div', { class: 'verdict', id: 'verdict' }, inUnits(() => h('p', { class: 'muted' }, verdictWords(verdict).facts)), warnings.length > 0 ? notes : good);
}

const kShownReasons = 5;

/**
 * @param {ServerVerdict} verdict
 * @param {boolean} is_of_all false: of the first files alone
 * @returns {{title: string, facts: string, warnings: string[], is_good: boolean}}
 */
function serverVerdictWords(verdict, is_of_all) {
  const words = strings.verdict.server;
  const left_out = verdict.left_out ?? [];
  const by_images = verdict.photos_by_images ?? 0;
  const warnings = [
    ...(left_out.length > 0 ? [words.left_out(left_out.length)] : []),
    ...left_out.slice(0, kShownReasons).map((one) => `${one.name}: ${whyLeftOut(one)}`),
    ...saidOf(verdict).map(({ text }) => text),
  ];
  const is_good = warnings.length === 0 && by_images === 0 && verdict.photos_placeable > 0;
  const facts = dotted(
    words.placeable(verdict.photos_placeable, verdict.photos_readable),
    verdict.gsd_m > 0 ? formatGsd(verdict.gsd_m) : '',
    // The ground and the time of the first photos say nothing of those of the flight.
    is_of_all && verdict.area_m2 > 0 ? areaIn(verdict.area_m2, chosenUnits()) : '',
    is_of_all && verdict.expected_seconds > 0 ? words.time(formatDuration(verdict.expected_seconds)) : '',
  );
  return { title: is_of_all ? words.title : words.title_of_first(verdict.photos_readable + left_out.length), facts, warnings, is_good };
}

/** @param {ServerVerdict} verdict @param {boolean} [is_of_all] */
export const serverVerdictView = (verdict, is_of_all = true) => inUnits(() => serverVerdict(verdict, is_of_all));

/** @param {ServerVerdict} verdict @param {boolean} is_of_all */
function serverVerdict(verdict, is_of_all) {
  const { title, facts, warnings, is_good } = serverVerdictWords(verdict, is_of_all);
  return h(
    'div',
    { class: `verdict verdict-${is_good ? 'good' : 'amber'}`, id: 'server-verdict' },
    h('p', { class: is_good ? 'good' : 'amber' }, icon(is_good ? 'check' : 'warning'), h('strong', {}, title)),
    h('p', { class: 'muted' }, facts),
    warnings.length > 0 && h('ul', { class: 'verdict-warnings' }, ...warnings.map((text) => h('li', {}, h('span', {}, text)))),
  );
}
