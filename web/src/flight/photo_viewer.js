// One photo at full size in a dialog, opened at a pixel that is marked: to see what the map was made of. Drag, wheel
// and pinch-free buttons; arrow keys move it, + and - zoom, Escape closes.
import { h } from '../shared/dom.js';
import { icon } from '../shared/icons.js';
import { strings } from '../shared/strings.js';

const kZoomStep = 1.5;
const kPanStep_px = 80;
const kMark_px = 36;

/**
 * @param {{name: string, url: string, pixel: {x: number, y: number}|null}} photo pixel: the centre of the first one is
 *   (0, 0), as stored, whatever the EXIF orientation says
 */
export function openPhoto(photo) {
  const words = strings.photo;
  const image = h('img', { class: 'viewer-image', src: photo.url, alt: photo.name, draggable: 'false' });
  const mark = h('div', { class: 'viewer-mark', hidden: true, 'aria-hidden': 'true' });
  const note = h('p', { class: 'viewer-note', role: 'status' }, words.loading);
  const view = h('div', { class: 'viewer-view', tabindex: 0, role: 'application', 'aria-label': words.viewer_hint, id: 'viewer-view' }, image, mark, note);
  const button = (/** @type {string} */ name, /** @type {string} */ label, /** @type {() => void} */ run) =>
    h('button', { type: 'button', class: 'icon-button', 'aria-label': label, title: label, on: { click: run } }, icon(name));
  const dialog = h(
    'dialog',
    { class: 'dialog viewer', 'aria-label': photo.name, id: 'photo-viewer' },
    h(
      'div',
      { class: 'row between' },
      h('h2', { class: 'card-title' }, photo.name),
      h(
        'div',
        { class: 'row' },
        button('plus', words.zoom_in, () => zoom(kZoomStep)),
        button('minus', words.zoom_out, () => zoom(1 / kZoomStep)),
        button('fit', words.whole, () => showWhole()),
        h('a', { class: 'icon-button', href: photo.url, download: photo.name, 'aria-label': words.download, title: words.download }, icon('download')),
        button('close', words.close, () => dialog.close()),
      ),
    ),
    view,
  );

  let scale = 1;
  // Where the image's corner lies in the view.
  let left = 0;
  let top = 0;
  const draw = () => {
    image.style.transform = `translate(${left}px, ${top}px) scale(${scale})`;
    image.style.imageRendering = scale >= 3 ? 'pixelated' : 'auto';
    if (!photo.pixel) return;
    mark.style.transform = `translate(${left + (photo.pixel.x + 0.5) * scale - kMark_px / 2}px, ${top + (photo.pixel.y + 0.5) * scale - kMark_px / 2}px)`;
  };
  const wholeScale = () => Math.min(view.clientWidth / image.naturalWidth, view.clientHeight / image.naturalHeight);
  /** @param {number} x @param {number} y of the image, to the middle of the view */
  const centre = (x, y) => {
    left = view.clientWidth / 2 - (x + 0.5) * scale;
    top = view.clientHeight / 2 - (y + 0.5) * scale;
    draw();
  };
  const showWhole = () => {
    scale = wholeScale();
    centre(image.naturalWidth / 2, image.naturalHeight / 2);
  };
  const zoom = (/** @type {number} */ by, x = view.clientWidth / 2, y = view.clientHeight / 2) => {
    const next = Math.min(16, Math.max(wholeScale() / 2, scale * by));
    left = x - ((x - left) * next) / scale;
    top = y - ((y - top) * next) / scale;
    scale = next;
    draw();
  };
  image.addEventListener('load', () => {
    note.hidden = true;
    mark.hidden = !photo.pixel;
    if (!photo.pixel) {
      showWhole();
      return;
    }
    scale = Math.max(wholeScale(), 1 / window.devicePixelRatio);
    centre(photo.pixel.x, photo.pixel.y);
  });
  image.addEventListener('error', () => {
    note.textContent = words.cannot_show;
  });
  view.addEventListener('wheel', (event) => {
    event.preventDefault();
    const box = view.getBoundingClientRect();
    zoom(event.deltaY < 0 ? 1.2 : 1 / 1.2, event.clientX - box.left, event.clientY - box.top);
  }, { passive: false });
  view.addEventListener('pointerdown', (event) => view.setPointerCapture(event.pointerId));
  view.addEventListener('pointermove', (event) => {
    if (!view.hasPointerCapture(event.pointerId)) return;
    left += event.movementX;
    top += event.movementY;
    draw();
  });
  /** @type {Record<string, () => void>} */
  const keys = {
    ArrowLeft: () => { left += kPanStep_px; },
    ArrowRight: () => { left -= kPanStep_px; },
    ArrowUp: () => { top += kPanStep_px; },
    ArrowDown: () => { top -= kPanStep_px; },
    '+': () => zoom(kZoomStep),
    '=': () => zoom(kZoomStep),
    '-': () => zoom(1 / kZoomStep),
  };
  view.addEventListener('keydown', (event) => {
    const run = keys[event.key];
    if (!run) return;
    event.preventDefault();
    run();
    draw();
  });
  dialog.addEventListener('close', () => dialog.remove());
  document.body.append(dialog);
  dialog.showModal();
  view.focus();
}
