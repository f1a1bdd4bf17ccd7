// What the list, the head of an open flight and the comparison say of a flight in a few words.
/** @import { Flight, PhotoCounts } from '../shared/types.js' */
import { h } from '../shared/dom.js';
import { formatBytes, formatCaptureDay, formatDate, formatGsd, formatPercent } from '../shared/format.js';
import { strings } from '../shared/strings.js';
import { uploadOf } from '../upload/drop_zone.js';

/** @param {PhotoCounts|null|undefined} photos @returns {boolean} whether all are aligned */
export const isWhole = (photos) => !photos || (photos.left_out === 0 && photos.pose_only === 0);

/**
 * The state of a flight with a map, in two or three words.
 * @param {Flight} flight
 * @returns {{text: string, is_whole: boolean}}
 */
export function readyWords(flight) {
  const photos = flight.photos;
  if (!photos || isWhole(photos)) return { text: strings.states.ready, is_whole: true };
  return { text: photos.left_out > 0 ? strings.states.ready_without(photos.left_out) : strings.states.ready_unaligned(photos.pose_only), is_whole: false };
}

/**
 * @param {Flight} flight
 * @returns {HTMLElement} the state as a coloured word
 */
export function stateChip(flight) {
  const upload = uploadOf(flight.id);
  const state = upload ? 'uploading' : flight.state;
  let text = strings.states[state] ?? state;
  const ready = readyWords(flight);
  if (state === 'ready') text = ready.text;
  if (state === 'processing' && flight.job?.progress) text += ` ${formatPercent(flight.job.progress)}`;
  if (upload) {
    const { sent_bytes, bytes } = upload.queue.picture;
    if (bytes > 0) text += ` ${formatPercent(sent_bytes / bytes)}`;
  }
  return h('span', { class: `chip chip-${state === 'ready' && !ready.is_whole ? 'amber' : state}` }, text);
}

/**
 * @param {Flight} flight
 * @returns {string}
 */
export function flightFacts(flight) {
  // What has arrived so far, the upload itself says.
  if (!flight.photos && uploadOf(flight.id)) return formatDate(flight.created_at);
  const photos = flight.photos ? strings.flights.photos(flight.photos.total) : strings.flights.files(flight.file_count);
  return [takenDay(flight), photos, flight.bytes > 0 ? formatBytes(flight.bytes) : '', flight.file_count > 0 ? strings.flights.uploaded(formatDate(flight.created_at)) : formatDate(flight.created_at)]
    .filter(Boolean)
    .join(' · ');
}

/** The same in a row of the list, where there is room for what tells flights apart. @param {Flight} flight @returns {string[]} lines */
export function shortFacts(flight) {
  const photos = flight.photos ? strings.flights.photos(flight.photos.total) : strings.flights.files(flight.file_count);
  const day = takenDay(flight) || (flight.file_count > 0 ? strings.flights.uploaded(formatDate(flight.created_at)) : formatDate(flight.created_at));
  return [day, [photos, flight.gsd_m ? formatGsd(flight.gsd_m) : flight.bytes > 0 ? formatBytes(flight.bytes) : ''].filter(Boolean).join(' · ')];
}

/** A map of others: without its photos it can be neither moved nor made again. @param {Flight} flight */
export const isImported = ({ photos }) => photos?.total === 0;

/** When its photos were taken. @param {Flight} flight @returns {string} empty where that is not known */
export const takenDay = (flight) => (flight.captured ? formatCaptureDay(flight.captured) : '');

/** May this client change it? @param {Flight} flight */
export const mayChange = (flight) => flight.may_change !== false;

