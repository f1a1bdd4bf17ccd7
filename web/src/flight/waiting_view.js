// A flight whose files are there and whose map is not begun, nor its next one after an upload that was stopped: what the server
// has of it, what it lacks, what it makes of it, and how to go on.
/** @import { Flight } from '../shared/types.js' */
import { getVerdict, listFiles } from '../shared/api.js';
import { h, put } from '../shared/dom.js';
import { mayChange } from './flight_words.js';
import { button, icon } from '../shared/icons.js';
import { strings } from '../shared/flight_strings.js';
import { whatIsMissing } from '../upload/upload_memory.js';
import { stoppedUploadOf } from '../upload/drop_zone.js';
import { resumeUpload } from '../upload/uploads.js';
import { serverVerdictView } from '../upload/verdict_view.js';

/**
 * @param {Flight} flight
 * @param {{start: (label: string, kind: 'primary'|'') => HTMLElement, add: () => HTMLElement, options: () => HTMLElement, on_resume: () => void,
 *          signal: AbortSignal}} parts
 * @returns {{element: HTMLElement, close: () => void}}
 */
export function waitingView(flight, parts) {
  const words = strings.upload;
  const is_uploaded = flight.state !== 'empty';
  let closed = false;
  const text = h('div');
  const actions = h('div', { class: 'row' });
  const box = h('div', { class: 'callout', id: 'waiting' }, text, mayChange(flight) && actions);
  const verdict = h('div');
  const element = h('div', {}, box, verdict);

  /** @param {{files: number, missing: string[]}|null} known */
  const draw = (known) => {
    const lacks = known ? known.missing.length : 0;
    const stopped = stoppedUploadOf(flight.id);
    box.classList.toggle('callout-warning', lacks > 0);
    put(
      text,
      flight.job?.state === 'dismissed' && h('p', {}, strings.job.cancelled),
      is_uploaded && lacks > 0 && h('p', { class: 'callout-title' }, icon('warning'), words.there_of((known?.files ?? 0) - lacks, known?.files ?? 0)),
      is_uploaded && lacks > 0 && h('p', {}, words.missing(lacks)),
      is_uploaded && lacks === 0 && flight.job?.state !== 'dismissed' && h('p', {}, known ? words.start_hint(known.files) : words.there(flight.file_count)),
      (lacks > 0 || !known) && !stopped && h('p', { class: 'muted' }, strings.drop.resume_hint),
    );
    const resume = () => {
      if (stopped) resumeUpload(stopped);
      parts.on_resume();
    };
    put(
      actions,
      stopped && button(words.go_on, resume, { picture: 'play', class: 'button small primary', id: 'upload-resume' }),
      is_uploaded && parts.start(lacks > 0 ? words.start_without(lacks) : words.start, lacks > 0 ? '' : 'primary'),
      parts.add(),
      is_uploaded && parts.options(),
    );
  };

  // Buttons that could make a map with holes come when it is known whether there are any.
  put(text, h('p', {}, words.there(flight.file_count)));
  if (!is_uploaded) draw(null);
  else {
    listFiles(flight.id).then(
      (stored) => closed || draw(whatIsMissing(flight.id, stored)),
      () => closed || draw(null),  // what is missing cannot be told; what is there was
    );
    getVerdict(flight.id, parts.signal).then(
      (found) => closed || (found && put(verdict, serverVerdictView(found))),
      (error) => console.debug('no verdict', error),  // only logs so far, say
    );
  }
  return { element, close: () => void (closed = true) };
}
