// Photos over the whole window, opened at a pixel that is marked: to see what the map was made of. All photos that see
// the place are in a strip below. Left and right step through them, Shift and the arrows pan, + and - zoom, 0 fits,
// N turns the photo to north, Escape closes.
/** @import { SeenPhoto } from './photo_card.js' */
import { announce } from '../shared/announce.js';
import { h } from '../shared/dom.js';
import { compassNeedle, icon } from '../shared/icons.js';
import { followPointer } from '../shared/follow_pointer.js';
import { strings } from '../shared/flight_strings.js';
import { filmstrip } from './filmstrip.js';

const kZoomStep = 1.5;
const kPanStep_px = 80;
const kMark_px = 36;
const kNorth = 'skyquilt.photo_north';

/**
 * @param {SeenPhoto[]} photos pixels: the centre of the first one is (0, 0), as stored, whatever the EXIF orientation says
 * @param {number} first
 * @param {(index: number) => void} on_step
 */
export function openPhotos(photos, first, on_step) {
  const words = strings.photo;
  const image = h('img', { class: 'viewer-image', draggable: 'false' });
  const mark = h('div', { class: 'viewer-mark', hidden: true, 'aria-hidden': 'true' });
  const note = h('p', { class: 'viewer-note', role: 'status' });
  const view = h('div', { class: 'viewer-view', tabindex: 0, role: 'application', 'aria-label': words.viewer_hint, id: 'viewer-view' }, image, mark, note);
  const button = (/** @type {Node} */ picture, /** @type {string} */ label, /** @type {() => void} */ run, id = '') =>
    h('button', { type: 'button', class: 'icon-button', id: id || null, 'aria-label': label, title: label, on: { click: run } }, picture);
  const title = h('h2', { class: 'card-title' });
  const facts = h('p', { class: 'viewer-facts' });
  const save = h('a', { class: 'icon-button', 'aria-label': words.download, title: words.download }, icon('download'));
  const needle = compassNeedle();
  const north = button(needle, words.to_north, () => setNorth(!is_north), 'viewer-north');
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
        button(icon('plus'), words.zoom_in, () => zoom(kZoomStep)),
        button(icon('minus'), words.zoom_out, () => zoom(1 / kZoomStep)),
        button(icon('fit'), words.whole, () => showWhole()),
        save,
        button(icon('close'), words.close, () => dialog.close()),
      ),
    ),
    view,
    photos.length > 1 && strip.element,
  );

  let shown = first;
  let is_north = localStorage.getItem(kNorth) === 'yes';
  // What is in the middle of the view, in pixels of the image, and how it is drawn there.
  let middle = { x: 0, y: 0 };
  let scale = 1;
  let is_first = true;

  const turn_rad = () => (is_north ? ((photos[shown].record.yaw_deg ?? 0) * Math.PI) / 180 : 0);
  /** @param {number} x @param {number} y @param {number} angle clockwise on the screen */
  const turned = (x, y, angle) => ({ x: x * Math.cos(angle) - y * Math.sin(angle), y: x * Math.sin(angle) + y * Math.cos(angle) });
  const draw = () => {
    const angle = turn_rad();
    const [width, height] = [view.clientWidth, view.clientHeight];
    image.style.transform = `translate(${width / 2}px, ${height / 2}px) rotate(${angle}rad) scale(${scale}) translate(${-(middle.x + 0.5)}px, ${-(middle.y + 0.5)}px)`;
    image.style.imageRendering = scale >= 3 ? 'pixelated' : 'auto';
    needle.style.transform = `rotate(${angle - ((photos[shown].record.yaw_deg ?? 0) * Math.PI) / 180}rad)`;
    const { pixel } = photos[shown];
    if (!pixel) return;
    const at = turned((pixel.x - middle.x) * scale, (pixel.y - middle.y) * scale, angle);
    mark.style.transform = `translate(${width / 2 + at.x - kMark_px / 2}px, ${height / 2 + at.y - kMark_px / 2}px)`;
  };
  const wholeScale = () => {
    const [sin, cos] = [Math.abs(Math.sin(turn_rad())), Math.abs(Math.cos(turn_rad()))];
    const { naturalWidth: width, naturalHeight: height } = image;
    return Math.min(view.clientWidth / (width * cos + height * sin), view.clientHeight / (width * sin + height * cos));
  };
  const showWhole = () => {
    scale = wholeScale();
    middle = { x: (image.naturalWidth - 1) / 2, y: (image.naturalHeight - 1) / 2 };
    draw();
  };
  /** @param {number} x_px on the screen @param {number} y_px */
  const pan = (x_px, y_px) => {
    const by = turned(x_px / scale, y_px / scale, -turn_rad());
    middle = { x: middle.x - by.x, y: middle.y - by.y };
    draw();
  };
  /** @param {number} by @param {number} [x_px] from the middle of the view, stays where it is @param {number} [y_px] */
  const zoom = (by, x_px = 0, y_px = 0) => {
    const next = Math.min(16, Math.max(wholeScale() / 2, scale * by));
    const from = turned(x_px, y_px, -turn_rad());
    const kept = 1 / scale - 1 / next;
    middle = { x: middle.x + from.x * kept, y: middle.y + from.y * kept };
    scale = next;
    draw();
  };
  /** @param {boolean} on */
  const setNorth = (on) => {
    const was_whole = Math.abs(scale - wholeScale()) < 1e-6 && Math.abs(middle.x - (image.naturalWidth - 1) / 2) < 1;
    is_north = on;
    localStorage.setItem(kNorth, on ? 'yes' : 'no');
    north.setAttribute('aria-pressed', String(on));
    if (was_whole) showWhole();
    else draw();
  };
  const show = (/** @type {number} */ index) => {
    shown = (index + photos.length) % photos.length;
    const { record, url, off_vertical_deg } = photos[shown];
    title.textContent = record.name;
    facts.textContent = [photos.length > 1 ? words.of(shown + 1, photos.length) : '', off_vertical_deg === null ? '' : words.off_vertical(off_vertical_deg)].filter(Boolean).join(' · ');
    dialog.setAttribute('aria-label', record.name);
    north.hidden = typeof record.yaw_deg !== 'number';
    save.href = url;
    save.setAttribute('download', record.name);
    note.textContent = words.loading;
    note.hidden = false;
    mark.hidden = true;
    image.alt = record.name;
    image.hidden = true;
    image.src = url;
    strip.show(shown);
    if (!is_first) {
      on_step(shown);
      announce(record.name);
    }
  };
  image.addEventListener('load', () => {
    const { pixel } = photos[shown];
    note.hidden = true;
    image.hidden = false;
    mark.hidden = !pixel;
    if (!pixel) showWhole();
    else {
      // The next photo of the same place is shown as near, so that they can be told apart.
      if (is_first) scale = Math.max(wholeScale(), 1 / window.devicePixelRatio);
      middle = { ...pixel };
      draw();
    }
    is_first = false;
  });
  image.addEventListener('error', () => {
    note.textContent = words.cannot_show;
    is_first = false;
  });
  new ResizeObserver(() => draw()).observe(view);
  followPointer(view, { pan, zoom });
  /** @type {Record<string, () => void>} */
  const keys = { '+': () => zoom(kZoomStep), '=': () => zoom(kZoomStep), '-': () => zoom(1 / kZoomStep), 0: showWhole, n: () => setNorth(!is_north) };
  /** @type {Record<string, [number, number]>} */
  const arrows = { ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
  dialog.addEventListener('keydown', (event) => {
    const arrow = arrows[event.key];
    const run = keys[event.key.toLowerCase()];
    if (event.ctrlKey || event.metaKey || event.altKey || (!arrow && !run)) return;
    event.preventDefault();
    if (run) run();
    else if (arrow[0] !== 0 && !event.shiftKey && photos.length > 1) show(shown - arrow[0]);
    else pan(arrow[0] * kPanStep_px, arrow[1] * kPanStep_px);
  });
  dialog.addEventListener('close', () => {
    strip.close();
    dialog.remove();
  });
  document.body.append(dialog);
  dialog.showModal();
  north.setAttribute('aria-pressed', String(is_north));
  show(first);
  view.focus();
}
