// The card of a photo: its record, stepping through all photos that see the clicked place, and opening them there.
/** @import { PhotoRecord } from '../shared/types.js' */
import { announce } from '../shared/announce.js';
import { formatCoordinates } from '../map/coordinates.js';
import { h, onEscape, put } from '../shared/dom.js';
import { formatCaptureTime } from '../shared/format.js';
import { button, iconButton } from '../shared/icons.js';
import { openPhotos } from './photo_viewer.js';
import { fixed } from '../shared/language.js';
import { inOneLine } from '../shared/remarks.js';
import { strings } from '../shared/flight_strings.js';
import { chosenUnits, errorIn, lengthIn } from '../shared/units.js';

/**
 * @param {PhotoRecord} record
 * @param {number|null} off_vertical_deg
 * @param {import('../shared/units.js').Units} units
 * @returns {[string, string][]}
 */
export function recordFacts(record, off_vertical_deg, units) {
  const words = strings.photo;
  const known = (/** @type {unknown} */ value) => typeof value === 'number' && Number.isFinite(value);
  const angle = (/** @type {number|null|undefined} */ value) => (known(value) ? `${fixed(Number(value), 1)}°` : '–');
  /** @type {[string, string][]} */
  const rows = [[words.placement, strings.placement[record.placement] ?? record.placement]];
  const reason = inOneLine(record.remarks, record.reason);
  if (reason) rows.push([words.reason, reason]);
  rows.push([words.error, known(record.error_radius_m) ? `± ${errorIn(Number(record.error_radius_m), units)}` : words.unknown]);
  if (off_vertical_deg !== null) rows.push([words.view, words.off_vertical(off_vertical_deg)]);
  const { captured_at } = record;
  if (captured_at) rows.push([words.captured, formatCaptureTime({ first: captured_at, last: captured_at }) || captured_at]);
  rows.push([words.position, formatCoordinates(record.camera_lon, record.camera_lat, 'decimal')]);
  rows.push([words.height, known(record.camera_height_above_ground_m) ? lengthIn(Number(record.camera_height_above_ground_m), units) : words.unknown]);
  if (known(record.yaw_deg)) rows.push([words.angles, [record.yaw_deg, record.pitch_deg, record.roll_deg].map(angle).join(words.between_angles)]);
  return rows;
}

/**
 * A photo of the card: its record, where its bytes are, and, where they are known, the pixel that shows the place and how
 * far from straight down it looks there.
 * @typedef {{record: PhotoRecord, url: string, pixel: {x: number, y: number}|null, off_vertical_deg: number|null}} SeenPhoto
 */

/**
 * @param {{on_show: (record: PhotoRecord|null) => void, hide: (element: HTMLElement) => void}} listener
 * @returns {{element: HTMLElement, show: (photos: SeenPhoto[]) => void, close: () => void}}
 */
export function photoCard(listener) {
  const words = strings.photo;
  const element = h('section', { class: 'photo-card floating', 'aria-label': words.placement, id: 'photo-card', hidden: true });
  /** @type {SeenPhoto[]} */
  let photos = [];
  let shown = 0;

  const close = () => {
    if (element.hidden) return;
    listener.hide(element);
    photos = [];
    listener.on_show(null);
  };
  const step = (/** @type {number} */ by) => {
    shown = (shown + by + photos.length) % photos.length;
    draw();
    /** @type {HTMLElement|null} */ (element.querySelector(by > 0 ? '.step-next' : '.step-back'))?.focus();
  };
  const draw = () => {
    const { record, pixel, off_vertical_deg } = photos[shown];
    const back = iconButton('back', words.previous, () => step(-1));
    const next = iconButton('next', words.next, () => step(1));
    back.classList.add('step-back');
    next.classList.add('step-next');
    put(
      element,
      h(
        'div',
        { class: 'row between card-head' },
        h('h2', { class: 'card-title' }, h('span', { class: `dot dot-${record.placement}` }), record.name),
        iconButton('close', strings.page.close, close),
      ),
      h('dl', { class: 'record' }, ...recordFacts(record, off_vertical_deg, chosenUnits()).map(([term, value]) => h('div', {}, h('dt', {}, term), h('dd', {}, value)))),
      button(pixel ? words.open_here : words.open, () => void open(), { picture: 'photo', id: 'photo-open' }),
      photos.length > 1 && h('div', { class: 'row between pager' }, back, h('span', { class: 'muted' }, words.of(shown + 1, photos.length)), next),
    );
    element.hidden = false;
    element.setAttribute('aria-label', record.name);
    listener.on_show(record);
    announce(record.name);
  };
  const open = async () => {
    await openPhotos(photos, shown, (index) => { shown = index; draw(); });
    document.getElementById('photo-open')?.focus();  // which was drawn anew with each step
  };
  onEscape(element, close);
  return {
    element,
    show(next_photos) {
      photos = next_photos;
      shown = 0;
      if (photos.length > 0) draw();
      else close();
    },
    close,
  };
}
