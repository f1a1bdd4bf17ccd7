// A loupe in the corner of a photo: some dozen pixels round a place, large, with a cross over it.
import { h } from '../shared/dom.js';

const kSide_px = 168;
const kPixels = 28;  // of the photo, across

/**
 * @param {HTMLImageElement} image
 * @returns {{element: HTMLCanvasElement, show: (pixel: {x: number, y: number}|null) => void}}
 */
export function loupe(image) {
  const density = Math.min(2, window.devicePixelRatio || 1);
  const side = kSide_px * density;
  const element = h('canvas', { class: 'loupe', width: side, height: side, 'aria-hidden': 'true' });
  const context = element.getContext('2d');
  return {
    element,
    show(pixel) {
      element.hidden = !pixel || image.hidden || !image.naturalWidth;
      if (!pixel || element.hidden || !context) return;
      context.fillStyle = '#000';
      context.fillRect(0, 0, side, side);
      context.imageSmoothingEnabled = false;
      const scale = side / kPixels;
      // The centre of a pixel lies half a pixel into it.
      context.drawImage(image, side / 2 - (pixel.x + 0.5) * scale, side / 2 - (pixel.y + 0.5) * scale, image.naturalWidth * scale, image.naturalHeight * scale);
      for (const [colour, width] of /** @type {[string, number][]} */ ([['#10201c', 3], ['#fff', 1]])) {
        context.strokeStyle = colour;
        context.lineWidth = width * density;
        context.beginPath();
        for (const [x, y] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
          context.moveTo(side / 2 + x * side * 0.06, side / 2 + y * side * 0.06);
          context.lineTo(side / 2 + (x * side) / 2, side / 2 + (y * side) / 2);
        }
        context.stroke();
      }
    },
  };
}
