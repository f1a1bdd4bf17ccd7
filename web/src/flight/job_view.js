// A job in the panel: stage, progress, time left, cancel.
/** @import { Job } from '../shared/types.js' */
import { announce, showError } from '../shared/announce.js';
import { cancelJob } from '../shared/api.js';
import { h } from '../shared/dom.js';
import { dotted, formatDuration, formatPercent } from '../shared/format.js';
import { button, runOnce } from '../shared/icons.js';
import { strings } from '../shared/flight_strings.js';
import { jobWorkers } from './job_workers.js';

/** @param {string|undefined} stage @returns {string} in words; an unknown stage by its own name */
export function stageName(stage) {
  if (!stage) return '';
  const known = strings.job.stages[stage];
  if (known) return known;
  const words = stage.replaceAll('_', ' ');
  return words.charAt(0).toUpperCase() + words.slice(1);
}

/** @param {Job} job @returns {string} how long it will take, as far as that is known */
function timeLeft(job) {
  if (job.eta_s === null || job.eta_s === undefined) return '';
  if ((job.eta_high_s ?? job.eta_s) < 1) return strings.job.almost_done;
  const [low, high] = [job.eta_low_s, job.eta_high_s].map((seconds) => formatDuration(seconds ?? job.eta_s ?? 0));
  return low === high ? strings.job.left(formatDuration(job.eta_s)) : strings.job.left_between(low, high);
}

/**
 * @param {string} job_id
 * @param {boolean} may_cancel
 * @param {string} heading
 * @returns {{element: HTMLElement, update: (job: Job) => void, lost: () => void}}
 */
export function jobView(job_id, may_cancel, heading = strings.job.heading) {
  const words = strings.job;
  const bar = h('progress', { class: 'bar', max: 1, 'aria-label': words.progress, id: 'job-progress' });
  const percent = h('strong', { class: 'big-number' });
  const stage = h('span', { class: 'stage-name', id: 'job-stage' });
  const note = h('p', { class: 'muted', id: 'job-note' });
  const cancel = button(words.cancel, () => runOnce(cancel, () => cancelJob(job_id), showError), { id: 'job-cancel' });
  const workers = jobWorkers();
  const element = h(
    'section',
    { class: 'block card', 'aria-labelledby': 'job-heading', id: 'job' },
    h('h2', { id: 'job-heading' }, heading),
    h('div', { class: 'progress-row' }, percent, bar),
    stage,
    note,
    workers.element,
    may_cancel && h('div', { class: 'row' }, cancel),
  );
  return {
    element,
    update(job) {
      const waiting = job.state === 'accepted';
      const fraction = job.progress ?? 0;
      if (waiting) bar.removeAttribute('value');
      else bar.value = fraction;
      percent.textContent = waiting ? '' : formatPercent(fraction);
      percent.hidden = waiting;
      stage.textContent = stageName(waiting ? 'queued' : job.stage);
      note.textContent = dotted(
        waiting || job.message === stage.textContent ? '' : job.message,
        timeLeft(job),
        (job.attempts ?? 0) > 1 ? words.attempt(job.attempts ?? 0) : '',
      );
      workers.update(job);
      announce(`${stage.textContent} ${percent.textContent}`, { is_progress: true });
    },
    lost() {
      note.textContent = words.lost;
    },
  };
}
