// Who works on which part of a large flight, and which workers take nothing because their machines are in trouble. The server
// tells this to those who run it alone.
/** @import { Job } from '../shared/types.js' */
import { serverWords } from '../shared/api.js';
import { h } from '../shared/dom.js';
import { formatDate } from '../shared/format.js';
import { number } from '../shared/language.js';
import { strings } from '../shared/flight_strings.js';

/** @param {HTMLElement} list @param {string[]} lines what does not change stays, so that it can be read and selected */
function show(list, lines) {
  list.hidden = lines.length === 0;
  const shown = [...list.children].map((item) => item.textContent);
  if (shown.join('\n') !== lines.join('\n')) list.replaceChildren(...lines.map((line) => h('li', {}, line)));
}

/** @param {string} iso */
const at = (iso) => formatDate(iso, { with_time: true });

/** @returns {{element: HTMLElement, update: (job: Job) => void}} */
export function jobWorkers() {
  const words = strings.job;
  const summary = h('summary', {});
  const held = h('ul', { class: 'reasons' });
  const parts = h('details', { class: 'left-out', id: 'job-parts', hidden: true }, summary, held);
  const resting = h('ul', { class: 'reasons' });
  const aside = h('details', { class: 'left-out', id: 'job-aside', hidden: true, open: true }, h('summary', {}, words.workers_aside), resting);
  return {
    element: h('div', {}, parts, aside),
    update(job) {
      const of_job = job.parts ?? [];
      parts.hidden = of_job.length === 0;
      summary.textContent = words.parts(of_job.length);
      show(
        held,
        of_job.map(({ kind, part, worker, since, attempt }) =>
          [`${words.part_kinds[kind] ?? kind} ${number(part)}`, worker, words.since(at(since)), words.attempt(attempt)].join(' · '),
        ),
      );
      const of_server = job.workers_aside ?? [];
      aside.hidden = of_server.length === 0;
      show(
        resting,
        of_server.map(({ worker, until, code, message }) => `${words.aside(worker, at(until))} · ${serverWords(code, message)}`),
      );
    },
  };
}
