// What the list, the head of an open flight and the comparison say of a flight in a few words.
/** @import { Flight } from '../shared/types.js' */
import { h } from '../shared/dom.js';
import { formatBytes, formatCaptureDay, formatDate, formatGsd, formatPercent } from '../shared/format.js';
import { strings } from '../shared/strings.js';
import { uploadOf } from '../upload/drop_zone.js';
import { accuracyMark, gradeOf, isScaleKnown, statusWords } from './quality_words.js';

/**
 * @param {Flight} flight
 * @returns {HTMLElement} the state as a coloured word
 */
export function stateChip(flight) {
  const upload = uploadOf(flight.id);
  const state = upload ? 'uploading' : flight.state;
  let text = strings.states[state] ?? state;
  if (state === 'ready') text = statusWords(flight.quality);
  if (state === 'processing' && flight.job?.progress) text += ` ${formatPercent(flight.job.progress)}`;
  if (upload) {
    const { sent_bytes, bytes } = upload.queue.picture;
    if (bytes > 0) text += ` ${formatPercent(sent_bytes / bytes)}`;
  }
  const of_map = { good: 'ready', amber: 'amber', bad: 'failed' }[gradeOf(flight.quality)];
  return h('span', { class: `chip chip-${state === 'ready' ? of_map : state}` }, text);
}

/**
 * @param {Flight} flight
 * @returns {string}
 */
export function flightFacts(flight) {
  // What has arrived so far, the upload itself says.
  if (!flight.photos && uploadOf(flight.id)) return formatDate(flight.created_at);
  const photos = flight.photos ? strings.flights.photos(flight.photos.total) : strings.flights.files(flight.file_count);
  return [takenDay(flight), photos, accuracyMark(flight.quality), flight.bytes > 0 ? formatBytes(flight.bytes) : '', flight.file_count > 0 ? strings.flights.uploaded(formatDate(flight.created_at)) : formatDate(flight.created_at)]
    .filter(Boolean)
    .join(' · ');
}

/** The same in a row of the list, where there is room for what tells flights apart. @param {Flight} flight @returns {string[]} lines */
export function shortFacts(flight) {
  const photos = flight.photos ? strings.flights.photos(flight.photos.total) : strings.flights.files(flight.file_count);
  const day = takenDay(flight) || (flight.file_count > 0 ? strings.flights.uploaded(formatDate(flight.created_at)) : formatDate(flight.created_at));
  const gsd = flight.gsd_m && isScaleKnown(flight.quality) ? formatGsd(flight.gsd_m) : '';
  return [day, [photos, gsd || (flight.bytes > 0 ? formatBytes(flight.bytes) : ''), accuracyMark(flight.quality)].filter(Boolean).join(' · ')];
}

/** A map of others: without its photos it can be neither moved nor made again. @param {Flight} flight */
export const isImported = ({ photos }) => photos?.total === 0;

/** When its photos were taken. @param {Flight} flight @returns {string} empty where that is not known */
export const takenDay = (flight) => (flight.captured ? formatCaptureDay(flight.captured) : '');

/** May this client change it? @param {Flight} flight */
export const mayChange = (flight) => flight.may_change !== false;

