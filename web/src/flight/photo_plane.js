// A photo that is panned, zoomed and turned within a view: what is in the middle, how large, and which pixel is where.
// Pixels: the centre of the first one is (0, 0), as stored, whatever the EXIF orientation says.
import { h } from '../shared/dom.js';
import { strings } from '../shared/flight_strings.js';
import { followPointer } from '../shared/follow_pointer.js';

export const kZoomStep = 1.5;
const kMaxScale = 16;
const kPixelated = 3;

/** @typedef {{x: number, y: number}} Spot */

/** @param {Spot} by @param {number} angle clockwise on the screen @returns {Spot} */
const turned = ({ x, y }, angle) => ({ x: x * Math.cos(angle) - y * Math.sin(angle), y: x * Math.sin(angle) + y * Math.cos(angle) });

/**
 * @param {HTMLElement} view gets the photo, below what is in it, and a note while there is none
 * @param {{turn_rad?: () => number, on_draw: () => void, on_load: () => void, on_error?: () => void}} listener
 */
export function photoPlane(view, { turn_rad = () => 0, on_draw, on_load, on_error = () => {} }) {
  const image = h('img', { class: 'viewer-image', draggable: 'false' });
  const note = h('p', { class: 'viewer-note', role: 'status' });
  view.prepend(image);
  view.append(note);
  image.addEventListener('load', () => {
    note.hidden = true;
    image.hidden = false;
    on_load();
  });
  image.addEventListener('error', () => {
    note.textContent = strings.photo.cannot_show;
    on_error();
  });
  // What is in the middle of the view, in pixels of the image, and how it is drawn there.
  let middle = { x: 0, y: 0 };
  let scale = 1;

  const draw = () => {
    const [width, height] = [view.clientWidth, view.clientHeight];
    image.style.transform = `translate(${width / 2}px, ${height / 2}px) rotate(${turn_rad()}rad) scale(${scale}) translate(${-(middle.x + 0.5)}px, ${-(middle.y + 0.5)}px)`;
    image.style.imageRendering = scale >= kPixelated ? 'pixelated' : 'auto';
    on_draw();
  };
  /** Not while it is on its way, nor where it cannot be shown. */
  const hasSize = () => image.naturalWidth > 0;
  const wholeScale = () => {
    const [sin, cos] = [Math.abs(Math.sin(turn_rad())), Math.abs(Math.cos(turn_rad()))];
    const { naturalWidth: width, naturalHeight: height } = image;
    return Math.min(view.clientWidth / (width * cos + height * sin), view.clientHeight / (width * sin + height * cos));
  };
  const showWhole = () => {
    if (!hasSize()) return;
    scale = wholeScale();
    middle = { x: (image.naturalWidth - 1) / 2, y: (image.naturalHeight - 1) / 2 };
    draw();
  };
  /** @param {number} x_px on the screen @param {number} y_px */
  const pan = (x_px, y_px) => {
    const by = turned({ x: x_px / scale, y: y_px / scale }, -turn_rad());
    middle = { x: middle.x - by.x, y: middle.y - by.y };
    draw();
  };
  /** @param {number} by @param {number} [x_px] from the middle of the view, stays where it is @param {number} [y_px] */
  const zoom = (by, x_px = 0, y_px = 0) => {
    if (!hasSize()) return;
    const next = Math.min(kMaxScale, Math.max(wholeScale() / 2, scale * by));
    const from = turned({ x: x_px, y: y_px }, -turn_rad());
    const kept = 1 / scale - 1 / next;
    middle = { x: middle.x + from.x * kept, y: middle.y + from.y * kept };
    scale = next;
    draw();
  };
  new ResizeObserver(draw).observe(view);
  followPointer(view, { pan, zoom });
  return {
    image,
    /** @param {string} url @param {string} name */
    open(url, name) {
      note.textContent = strings.photo.loading;
      note.hidden = false;
      image.hidden = true;
      image.alt = name;
      image.src = url;
    },
    draw,
    /** What keys do. */
    keys: { '+': () => zoom(kZoomStep), '=': () => zoom(kZoomStep), '-': () => zoom(1 / kZoomStep), 0: showWhole },
    pan,
    zoom,
    showWhole,
    wholeScale,
    get scale() {
      return scale;
    },
    isWhole: () => Math.abs(scale - wholeScale()) < 1e-6 && Math.abs(middle.x - (image.naturalWidth - 1) / 2) < 1,
    /** @param {Spot} pixel into the middle @param {number} [next_scale] */
    show(pixel, next_scale = scale) {
      scale = next_scale;
      middle = { ...pixel };
      draw();
    },
    /** @param {Spot} pixel @returns {Spot} on the screen, from the view's upper left corner */
    onScreen(pixel) {
      const at = turned({ x: (pixel.x - middle.x) * scale, y: (pixel.y - middle.y) * scale }, turn_rad());
      return { x: view.clientWidth / 2 + at.x, y: view.clientHeight / 2 + at.y };
    },
    /** @param {{clientX: number, clientY: number}} event of a pointer @returns {Spot} the pixel there */
    pixelAt({ clientX, clientY }) {
      const box = view.getBoundingClientRect();
      const by = turned({ x: (clientX - box.left - box.width / 2) / scale, y: (clientY - box.top - box.height / 2) / scale }, -turn_rad());
      return { x: middle.x + by.x, y: middle.y + by.y };
    },
  };
}
