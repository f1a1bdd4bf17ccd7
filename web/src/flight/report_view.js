// What was made and how good it is, in plain words first, then in pictures.
/** @import { Flight, PhotoCollection, PhotoCounts, Report } from '../shared/types.js' */
import { photoPath, thumbnailPath } from '../shared/api.js';
import { h } from '../shared/dom.js';
import { formatBytes, formatCaptureTime, formatDate, formatGsd } from '../shared/format.js';
import { button, icon, iconButton } from '../shared/icons.js';
import { coveragePicture, errorPicture, timingPicture } from './report_pictures.js';
import { number } from '../shared/language.js';
import { saidOf, whyLeftOut } from '../shared/remarks.js';
import { strings } from '../shared/flight_strings.js';
import { areaIn, chosenUnits, inUnits } from '../shared/units.js';
import { absoluteWords, relativeWords } from './flight_words.js';
import { hasScale, resultView } from './result_verdict.js';
import { glanceAtPhoto } from '../upload/exif_reader.js';
import { madeWith } from './options_dialog.js';
import { reasonList } from '../upload/upload_view.js';

/**
 * @param {PhotoCounts} photos
 * @returns {HTMLElement} one bar of three parts with its legend
 */
function placementBar(photos) {
  const bar = h('div', { class: 'stack', 'aria-hidden': 'true' });
  const legend = h('ul', { class: 'legend' });
  for (const kind of /** @type {const} */ (['aligned', 'pose_only', 'left_out'])) {
    if (photos[kind] === 0) continue;
    const part = h('span', { class: `stack-${kind}` });
    part.style.flexGrow = String(photos[kind]);
    bar.append(part);
    legend.append(h('li', {}, h('span', { class: `dot dot-${kind}` }), `${strings.placement[kind]} `, h('strong', {}, number(photos[kind]))));
  }
  return h('div', {}, bar, legend);
}

/** @param {string} term @param {string} value */
const fact = (term, value) => h('div', {}, h('dt', {}, term), h('dd', {}, value));

// A photo's first bytes hold the name of its camera.
const kModelBytes = 8192;

/**
 * The camera's name, when the first photo has told it.
 * @param {Flight} flight
 * @param {PhotoCollection|null} photos
 */
function cameraFact(flight, photos) {
  const row = fact(strings.report.camera, '');
  row.hidden = true;
  const first = photos?.features.find(({ properties }) => /\.(jpe?g|tiff?|dng)$/i.test(properties.name));
  if (!first) return row;
  fetch(photoPath(flight.id, first.properties.name), { headers: { Range: `bytes=0-${kModelBytes - 1}` } })
    .then(async (response) => {
      const { camera } = glanceAtPhoto(response.ok ? await response.arrayBuffer() : new ArrayBuffer(0));
      if (!camera) return;
      /** @type {HTMLElement} */ (row.lastElementChild).textContent = camera;
      row.hidden = false;
    })
    .catch((error) => console.debug('no camera', error));  // the figures are of use without its name
  return row;
}

/** @param {ReturnType<typeof saidOf>} said */
const remarkList = (said) => h('ul', { class: 'warnings' }, ...said.map(({ text, language }) => h('li', { lang: language }, text)));

/**
 * The map itself for the printed report, since the live map is not printed.
 * @param {Flight} flight
 * @returns {HTMLElement}
 */
function mapPicture(flight) {
  return h('div', { class: 'picture print-only' }, h('img', { class: 'map-picture', src: thumbnailPath(flight, 'whole'), alt: '', decoding: 'async', fetchpriority: 'low' }));
}

/**
 * @param {Flight} flight
 * @param {Report} report
 * @param {PhotoCollection|null} photos
 * @param {{place: (opener: HTMLElement) => void, again: () => void}|null} change opens the tool that moves the map, asks how to make it anew; null for who may not
 * @returns {HTMLElement}
 */
export function reportView(flight, report, photos, change) {
  const place = change?.place;
  const words = strings.report;
  const { quality } = report;
  const left_out = report.left_out_photos ?? [];
  const said = saidOf(report);
  const of_photos = said.filter(({ photo }) => photo !== null).length;  // for who looks for it
  const remarksOn = (/** @type {boolean} */ is_photo) => inUnits(() => remarkList(saidOf(report).filter(({ photo }) => (photo !== null) === is_photo)));
  const is_scale_known = hasScale(report);
  const made_with = madeWith(flight);
  const placed = report.photos.aligned + report.photos.pose_only;
  return h(
    'section',
    { class: 'block report', 'aria-labelledby': 'report-heading', id: 'report' },
    h(
      'div',
      { class: 'row between' },
      h('h2', { id: 'report-heading' }, words.heading),
      h(
        'div',
        { class: 'head-actions no-print' },
        place && report.is_placed !== false && iconButton('move', strings.place.move, (event) => place(/** @type {HTMLElement} */ (event.currentTarget)), 'flight-move'),
        iconButton('print', words.print, () => print()),
      ),
    ),
    resultView(report),
    place && report.is_placed === false &&
      button(strings.place.place, (/** @type {Event} */ event) => place(/** @type {HTMLElement} */ (event.currentTarget)), { picture: 'move', class: 'button primary place-button no-print', id: 'flight-place' }),
    h(
      'dl',
      { class: 'facts' },
      flight.captured && fact(words.taken, formatCaptureTime(flight.captured)),
      is_scale_known ? inUnits(() => fact(words.area, areaIn(report.area_m2, chosenUnits()))) : fact(words.area, words.no_scale),
      fact(words.gsd, is_scale_known ? formatGsd(report.gsd_m) : words.no_scale),
      quality && inUnits(() => fact(words.absolute, absoluteWords(quality))),
      quality && inUnits(() => fact(words.relative, relativeWords(quality))),
      cameraFact(flight, photos),
      report.photos.total > 0 && fact(words.photos, `${number(placed)} / ${number(report.photos.total)}`),
    ),
    report.photos.total > 0 && placementBar(report.photos),
    said.length > of_photos &&
      h(
        'div',
        { class: 'callout callout-warning' },
        h('p', { class: 'callout-title' }, icon('warning'), words.warnings),
        remarksOn(false),
      ),
    of_photos > 0 &&
      h('details', { class: 'left-out', id: 'photo-notes' }, h('summary', {}, words.corrections(of_photos)), remarksOn(true)),
    left_out.length > 0 &&
      h('details', { class: 'left-out', id: 'left-out' }, h('summary', {}, words.left_out(left_out.length)), inUnits(() => reasonList(left_out.map((one) => ({ name: one.name, reason: whyLeftOut(one) }))))),
    h(
      'div',
      { class: 'pictures' },
      mapPicture(flight),
      photos && coveragePicture(photos),
      photos && inUnits(() => errorPicture(photos, chosenUnits())),
    ),
    h(
      'details',
      { class: 'processing', id: 'processing-details' },
      h('summary', {}, words.details),
      h(
        'dl',
        { class: 'facts' },
        fact(words.uploaded, formatDate(flight.created_at)),
        fact(words.zooms, words.zoom_range(report.min_zoom, report.max_zoom)),
        report.peak_memory_bytes > 0 && fact(words.memory, formatBytes(report.peak_memory_bytes)),
        made_with !== null && fact(strings.options.made_with, made_with),
      ),
      change && button(strings.options.again, change.again, { picture: 'retry', class: 'button small no-print', id: 'run-again' }),
      timingPicture(report),
    ),
  );
}
