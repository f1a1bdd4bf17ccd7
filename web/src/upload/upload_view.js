// An upload under way: the whole, the files being sent, what failed and why.
/** @import { UploadSession } from './uploads.js' */
/** @import { UploadItem } from './upload_queue.js' */
import { announce } from '../shared/announce.js';
import { h, put } from '../shared/dom.js';
import { dotted, formatBytes, formatDuration, formatPercent } from '../shared/format.js';
import { button, icon } from '../shared/icons.js';
import { strings } from '../shared/flight_strings.js';
import { optionsButton } from '../flight/options_dialog.js';
import { serverVerdictView, verdictView } from './verdict_view.js';

/**
 * @param {UploadSession} session
 * @returns {{element: HTMLElement, close: () => void}}
 */
export function uploadView(session) {
  const words = strings.upload;
  const queue = session.queue;
  const bar = h('progress', { class: 'bar', max: 1, value: 0, 'aria-label': words.total, id: 'upload-progress' });
  const percent = h('strong', { class: 'big-number' });
  const counts = h('span', { class: 'muted', id: 'upload-counts' });
  const pace = h('p', { class: 'muted pace' });
  const sending = h('ul', { class: 'sending' });
  const trouble = h('div', { class: 'trouble', role: 'status' });
  const verdict = h('div');
  const server_verdict = h('div');
  const failures = h('div', { id: 'upload-failures' });
  const pause = button('', () => (queue.picture.state === 'paused' ? queue.start() : queue.pause()), { id: 'upload-pause' });
  const stop = button(words.stop, () => session.stop(), { class: 'button small quiet' });

  /** @type {Map<UploadItem, {row: HTMLLIElement, bar: HTMLProgressElement}>} */
  const rows = new Map();
  const drawSending = () => {
    const active = queue.items.filter((item) => item.state === 'sending');
    for (const [item, { row }] of rows) {
      if (item.state !== 'sending') {
        row.remove();
        rows.delete(item);
      }
    }
    for (const item of active) {
      let entry = rows.get(item);
      if (!entry) {
        const file_bar = h('progress', { class: 'bar thin', max: 1, value: 0, 'aria-label': words.file_progress(item.name) });
        const row = h('li', {}, h('span', { class: 'file-name' }, item.name), h('span', { class: 'muted' }, formatBytes(item.bytes)), file_bar);
        entry = { row, bar: file_bar };
        rows.set(item, entry);
        sending.append(row);
      }
      entry.bar.value = item.bytes ? item.sent_bytes / item.bytes : 0;
    }
  };

  const trouble_text = h('span');
  const retry_now = button(words.retry_now, () => queue.retryNow(), { id: 'upload-retry-now' });
  let shown_trouble = '';
  // Said at once; the seconds are counted without being said again.
  const drawTrouble = () => {
    const { retry } = queue.picture;
    const reason = retry?.reason ?? session.trouble;
    if (reason !== shown_trouble) {
      shown_trouble = reason;
      put(trouble, reason && h('p', { class: 'callout callout-warning', id: 'upload-trouble' }, icon('warning'), h('span', {}, reason, ' ', trouble_text)), retry && retry_now);
    }
    trouble_text.textContent = retry ? words.again_in(Math.max(0, Math.ceil((retry.at_ms - performance.now()) / 1000))) : session.waits_for_map ? '' : words.again_soon;
  };

  let shown_server_verdict = /** @type {typeof session.server_verdict} */ (null);
  let shown_verdict = /** @type {typeof session.verdict} */ (null);
  let shown_failures = '';
  const drawFailures = () => {
    const failed = queue.items.filter((item) => item.state === 'failed');
    const finished = queue.picture.state === 'finished';
    const key = JSON.stringify([failed.map(({ name, reason }) => [name, reason]), finished, session.ignored.length]);
    if (key === shown_failures) return;
    shown_failures = key;
    put(
      failures,
      failed.length > 0 &&
        h(
          'div',
          { class: 'callout callout-warning' },
          h('p', { class: 'callout-title' }, icon('warning'), words.failed(failed.length)),
          reasonList(failed),
          h(
            'div',
            { class: 'row' },
            button(strings.errors.retry, () => queue.retryFailed(), { picture: 'retry', class: 'button small primary' }),
            finished &&
              queue.picture.done > 0 &&
              button(words.go_on_without, () => session.startJob()),
          ),
        ),
      session.ignored.length > 0 &&
        h('details', { class: 'ignored' }, h('summary', {}, words.ignored(session.ignored.length)), reasonList(session.ignored)),
    );
  };

  const draw = () => {
    const picture = queue.picture;
    const fraction = picture.bytes ? picture.sent_bytes / picture.bytes : 0;
    bar.value = fraction;
    percent.textContent = formatPercent(fraction);
    counts.textContent = words.of(picture.done, picture.files);
    const is_paused = picture.state === 'paused' && session.trouble === '';  // else it waits to know what the server has
    pace.textContent = dotted(
      is_paused ? words.paused : '',
      `${formatBytes(picture.sent_bytes)} / ${formatBytes(picture.bytes)}`,
      picture.bytes_per_s > 0 && picture.state === 'running' ? words.speed(formatBytes(picture.bytes_per_s)) : '',
      picture.left_s !== null ? words.left(formatDuration(picture.left_s)) : '',
      picture.was_there > 0 ? words.skipped(picture.was_there) : '',
    );
    const label = is_paused ? words.resume : words.pause;
    if (pause.textContent !== label) put(pause, icon(is_paused ? 'play' : 'pause'), label);
    pause.hidden = !is_paused && picture.state !== 'running';
    if (session.verdict !== shown_verdict && session.verdict) put(verdict, verdictView(session.verdict));
    shown_verdict = session.verdict;
    if (session.server_verdict !== shown_server_verdict && session.server_verdict) {
      put(server_verdict, serverVerdictView(session.server_verdict, false));
    }
    shown_server_verdict = session.server_verdict;
    drawTrouble();
    drawSending();
    drawFailures();
    announce(`${words.heading} ${percent.textContent}`, { is_progress: true });
  };
  session.addEventListener('change', draw);
  draw();
  const clock = setInterval(draw, 1000);  // seconds go by also where nothing moves

  const element = h(
    'section',
    { class: 'block card', 'aria-labelledby': 'upload-heading', id: 'upload' },
    h('div', { class: 'row between' }, h('h2', { id: 'upload-heading' }, words.heading), counts),
    h('div', { class: 'progress-row' }, percent, bar),
    pace,
    trouble,
    verdict,
    server_verdict,
    sending,
    failures,
    h('div', { class: 'row' }, pause, stop, optionsButton(session.flight_id)),
  );
  return {
    element,
    close: () => {
      clearInterval(clock);
      session.removeEventListener('change', draw);
    },
  };
}

/** @param {{name: string, reason: string}[]} entries */
export function reasonList(entries) {
  return h(
    'ul',
    { class: 'reasons' },
    ...entries.map(({ name, reason }) => h('li', {}, h('span', { class: 'file-name' }, name), h('span', { class: 'muted' }, reason))),
  );
}
