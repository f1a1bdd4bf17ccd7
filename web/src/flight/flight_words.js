// What the list, the head of an open flight, its report and the comparison say of a flight in a few words, and of its map how
// true it is. What holds, the server says (core/pipeline/report/judge_map.h); nothing is judged here.
/** @import { Flight, MapLimit, MapQuality } from '../shared/types.js' */
import { h } from '../shared/dom.js';
import { dotted, errorTold, formatBytes, formatCaptureDay, formatDate, formatGsd, formatPercent } from '../shared/format.js';
import { number } from '../shared/language.js';
import { strings } from '../shared/strings.js';
import { uploadOf } from '../upload/drop_zone.js';

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

/** @param {Flight} flight @returns {string} how many photos, or files while they are not known apart */
function photosOf(flight) {
  if (isImported(flight)) return strings.flights.imported;
  return flight.photos ? strings.flights.photos(flight.photos.total) : strings.flights.files(flight.file_count);
}

/** @param {Flight} flight */
const uploadedWords = ({ file_count, created_at }) => (file_count > 0 ? strings.flights.uploaded(formatDate(created_at)) : formatDate(created_at));

/** @param {Flight} flight @returns {string} */
export function flightFacts(flight) {
  // What has arrived so far, the upload itself says.
  if (!flight.photos && uploadOf(flight.id)) return formatDate(flight.created_at);
  return dotted(takenDay(flight), photosOf(flight), accuracyMark(flight.quality), flight.bytes > 0 ? formatBytes(flight.bytes) : '', uploadedWords(flight));
}

/** The same in a row of the list, where there is room for what tells flights apart. @param {Flight} flight @returns {string[]} lines */
export function shortFacts(flight) {
  const day = takenDay(flight) || uploadedWords(flight);
  // Of a map that lies nowhere and that nothing judged its scale may be a guess.
  const is_scale_known = flight.quality ? isScaleKnown(flight.quality) : flight.georeferenced !== false;
  const gsd = flight.gsd_m && is_scale_known ? formatGsd(flight.gsd_m) : '';
  return [day, dotted(photosOf(flight), gsd || (flight.bytes > 0 && formatBytes(flight.bytes)), accuracyMark(flight.quality))];
}

/** A map of others: without its photos it can be neither moved nor made again. @param {Flight} flight */
export const isImported = ({ photos }) => photos?.total === 0;

/** When its photos were taken. @param {Flight} flight @returns {string} empty where that is not known */
export const takenDay = (flight) => (flight.captured ? formatCaptureDay(flight.captured) : '');

/** May this client change it? @param {Flight} flight */
export const mayChange = (flight) => flight.may_change !== false;

/** @typedef {'good'|'amber'|'bad'} Grade */

/** @type {Record<MapQuality['status'], Grade>} */
const kGrades = { ready: 'good', limited: 'amber', doubtful: 'bad', unplaced: 'bad', unknown: 'amber' };

/** Of maps of before there was a word on it, as of imported ones, it is not known. @param {MapQuality|null|undefined} quality @returns {Grade} */
export const gradeOf = (quality) => kGrades[quality?.status ?? 'unknown'];

/** @param {MapQuality|null|undefined} quality */
export const statusWords = (quality) => strings.quality.statuses[quality?.status ?? 'unknown'];

/** @param {MapQuality|null|undefined} quality @returns {string} "±2.3 m"; empty where nothing supports a number */
export const accuracyMark = (quality) => (quality?.absolute.sigma_m ? `\u00b1${errorTold(quality.absolute.sigma_m)}` : '');

/** @param {MapQuality} quality */
export function absoluteWords({ status, absolute, limits }) {
  const words = strings.quality;
  if (status === 'unknown') return words.unknown(words.imported);
  const few = limits.find(({ kind }) => kind === 'few_positions');
  if (absolute.by === 'none') return words.unknown(words.no_positions);
  if (absolute.by === 'hand' && absolute.sigma_m === null) return words.unknown(words.by_hand);
  const guess = limits.some(({ kind }) => kind === 'scale_guessed') ? words.scale_guess : words.north_guess;
  if (absolute.sigma_m === null) return words.unknown(few ? words.few(absolute.count, few.of) : guess);
  return words.absolute(`\u00b1${errorTold(absolute.sigma_m)}`, words.by[absolute.by](absolute.count));
}

/** @param {MapQuality} quality */
export function relativeWords({ status, relative }) {
  const words = strings.quality;
  if (status === 'unknown') return words.unknown(words.imported);
  if (relative.by === 'none' || relative.error_px === null) return words.unknown(words.no_ties);
  const pixels = words.pixels(number(relative.error_px, { maximumSignificantDigits: 2 }));
  return words.relative(relative.error_m === null ? pixels : `${errorTold(relative.error_m)} (${pixels})`, words.seen[relative.by](relative.count));
}

/** @param {MapLimit} limit */
export const limitWords = ({ kind, count, of }) => strings.quality.limits[kind](count, of);

/** Do lengths, areas and the resolution mean something? @param {MapQuality|null|undefined} quality */
export const isScaleKnown = (quality) => !quality?.limits.some(({ kind }) => kind === 'scale_guessed');
