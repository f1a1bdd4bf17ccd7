// A link as a picture that a phone's camera reads. The library comes when the first one is shown.
import { svg } from '../shared/dom.js';

const kQuiet = 4;  // modules of white around it, as readers want

/** @param {string} text @param {string} label @returns {Promise<SVGElement>} */
export async function qrCode(text, label) {
  const { generate } = await import('../../vendor/lean-qr.mjs');
  const code = generate(text);
  let dark = '';
  for (let y = 0; y < code.size; ++y) {
    for (let x = 0; x < code.size; ++x) if (code.get(x, y)) dark += `M${x} ${y}h1v1h-1z`;
  }
  const side = code.size + 2 * kQuiet;
  return svg('svg', { class: 'qr-code', viewBox: `${-kQuiet} ${-kQuiet} ${side} ${side}`, role: 'img', 'aria-label': label, 'shape-rendering': 'crispEdges' },
    svg('rect', { x: -kQuiet, y: -kQuiet, width: side, height: side, fill: '#fff' }), svg('path', { d: dark, fill: '#000' }));
}
