// Photos over the whole window, opened at a pixel that is marked: to see what the map was made of. All photos that see
// the place are in a strip below. Left and right step through them, Shift and the arrows pan, + and - zoom, 0 fits,
// N turns the photo to north, Escape closes.
/** @import { SeenPhoto } from './photo_card.js' */
import { announce } from '../shared/announce.js';
import { ask } from '../shared/dialogs.js';
import { h } from '../shared/dom.js';
import { dotted } from '../shared/format.js';
import { compassNeedle, icon, iconButton } from '../shared/icons.js';
import { keepChoice, keptChoice } from '../shared/language.js';
import { strings } from '../shared/flight_strings.js';
import { kArrows } from '../shared/follow_pointer.js';
import { filmstrip } from './filmstrip.js';
import { kZoomStep, photoPlane } from './photo_plane.js';

const kPanStep_px = 80;
const kMark_px = 36;
const kNorth = 'skyquilt.photo_north';

/**
 * @param {SeenPhoto[]} photos pixels: the centre of the first one is (0, 0), as stored, whatever the EXIF orientation says
 * @param {number} first
 * @param {(index: number) => void} on_step
 * @returns {Promise<void>} when they are closed
 */
export function openPhotos(photos, first, on_step) {
  const words = strings.photo;
  const mark = h('div', { class: 'viewer-mark', hidden: true, 'aria-hidden': 'true' });
  const view = h('div', { class: 'viewer-view', tabindex: 0, role: 'application', 'aria-label': words.viewer_hint, id: 'viewer-view' }, mark);
  const title = h('h2', { class: 'card-title' });
  const facts = h('p', { class: 'viewer-facts' });
  const save = h('a', { class: 'icon-button', 'aria-label': words.download, title: words.download }, icon('download'));
  const needle = compassNeedle();
  const north = iconButton(needle, words.to_north, () => setNorth(!is_north), 'viewer-north');
  const strip = filmstrip(photos, (index) => show(index));
  const dialog = h(
    'dialog',
    { class: 'dialog viewer', id: 'photo-viewer' },
    h(
      'div',
      { class: 'viewer-head' },
      h('div', { class: 'viewer-title' }, title, facts),
      h(
        'div',
        { class: 'viewer-tools' },
        north,
        iconButton('plus', strings.page.zoom_in, () => plane.zoom(kZoomStep)),
        iconButton('minus', strings.page.zoom_out, () => plane.zoom(1 / kZoomStep)),
        iconButton('fit', words.whole, () => plane.showWhole()),
        save,
        iconButton('close', strings.page.close, () => dialog.close()),
      ),
    ),
    view,
    photos.length > 1 && strip.element,
  );

  let shown = first;
  let is_north = keptChoice(kNorth) === 'yes';
  let is_first = true;

  const turn_rad = () => (is_north ? ((photos[shown].record.yaw_deg ?? 0) * Math.PI) / 180 : 0);
  const plane = photoPlane(view, {
    turn_rad,
    on_draw: () => {
      needle.style.transform = `rotate(${turn_rad() - ((photos[shown].record.yaw_deg ?? 0) * Math.PI) / 180}rad)`;
      const { pixel } = photos[shown];
      if (!pixel) return;
      const at = plane.onScreen(pixel);
      mark.style.transform = `translate(${at.x - kMark_px / 2}px, ${at.y - kMark_px / 2}px)`;
    },
    on_load: () => {
      const { pixel } = photos[shown];
      mark.hidden = !pixel;
      if (!pixel) plane.showWhole();
      // The next photo of the same place is shown as near, so that they can be told apart.
      else plane.show(pixel, is_first ? Math.max(plane.wholeScale(), 1 / window.devicePixelRatio) : plane.scale);
      is_first = false;
    },
    on_error: () => (is_first = false),
  });
  /** @param {boolean} on */
  const setNorth = (on) => {
    const was_whole = plane.isWhole();
    is_north = on;
    keepChoice(kNorth, on ? 'yes' : 'no');
    north.setAttribute('aria-pressed', String(on));
    if (was_whole) plane.showWhole();
    else plane.draw();
  };
  const show = (/** @type {number} */ index) => {
    shown = (index + photos.length) % photos.length;
    const { record, url, off_vertical_deg } = photos[shown];
    title.textContent = record.name;
    facts.textContent = dotted(photos.length > 1 && words.of(shown + 1, photos.length), off_vertical_deg !== null && words.off_vertical(off_vertical_deg));
    dialog.setAttribute('aria-label', record.name);
    north.hidden = typeof record.yaw_deg !== 'number';
    save.href = url;
    save.setAttribute('download', record.name);
    mark.hidden = true;
    plane.open(url, record.name);
    strip.show(shown);
    if (!is_first) {
      on_step(shown);
      announce(record.name);
    }
  };
  /** @type {Record<string, () => void>} */
  const keys = { ...plane.keys, n: () => setNorth(!is_north) };
  dialog.addEventListener('keydown', (event) => {
    const arrow = kArrows[event.key];
    const run = keys[event.key.toLowerCase()];
    if (event.ctrlKey || event.metaKey || event.altKey || (!arrow && !run)) return;
    event.preventDefault();
    if (run) run();
    else if (arrow[0] !== 0 && !event.shiftKey && photos.length > 1) show(shown + arrow[0]);
    else plane.pan(-arrow[0] * kPanStep_px, -arrow[1] * kPanStep_px);
  });
  const closed = ask(dialog).then(strip.close);
  north.setAttribute('aria-pressed', String(is_north));
  show(first);
  view.focus();
  return closed;
}
