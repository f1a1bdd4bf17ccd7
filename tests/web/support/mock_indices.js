// Indices of the stand-in server: of colours, their values made up; what was asked for is kept for tests to read.
import { encodePng } from './tile_picture.js';

const kIndices = [
  { id: 'vari', title: 'VARI', expression: '(green-red)/(green+red-blue)', rescale: [-0.4, 0.4], colormap: 'rdylgn' },
  { id: 'gli', title: 'GLI', expression: '(2*green-red-blue)/(2*green+red+blue)', rescale: [-0.2, 0.3], colormap: 'rdylgn' },
];
const kColormaps = [
  { id: 'rdylgn', colours: ['#a50026', '#ffffbf', '#006837'] },
  { id: 'viridis', colours: ['#440154', '#1f9e89', '#fde725'] },
];
export const reported_bands = { bands: ['red', 'green', 'blue'].map((name) => ({ name, calibration: name === 'blue' ? 'levels' : 'reflectance', held_against: name === 'blue' ? null : 'panel' })) };
export const index_facts = { bands: ['red', 'green', 'blue'], indices: kIndices };

/** One colour for one request, so that a picture of the page tells which tiles it shows. @param {URLSearchParams} query */
export const indexTile = (query) => {
  const of_green = query.get('colormap') === 'rdylgn' ? [0, 160, 60, 255] : [200, 40, 200, 255];
  return encodePng(8, 8, new Uint8Array(8 * 8 * 4).map((_, i) => of_green[i % 4]));
};

/**
 * @param {string} rest of the address, below the flight
 * @param {URLSearchParams} query
 * @returns {{status: number, body?: object, detail?: string}|null} null: no matter of indices
 */
export function answerIndices(rest, query) {
  if (rest === '/bands') return { status: 200, body: { revision: 1, ...index_facts, colormaps: kColormaps } };
  const expression = query.get('expression');
  if (rest !== '/point' && rest !== '/statistics') return null;
  if (expression?.endsWith('+')) return { status: 400, detail: `The expression cannot be read at character ${expression.length + 1}: it ends where a band or a number is expected.` };
  const named = kIndices.find(({ id }) => id === query.get('index'));
  const about = { title: named?.title ?? expression, expression: named?.expression ?? expression };
  if (rest === '/point') return { status: 200, body: { lon: Number(query.get('lon')), lat: Number(query.get('lat')), revision: 1, colour: null, height_m: null, photo: null, index: { ...about, value: 0.25 } } };
  const histogram = Array.from({ length: 64 }, (_, i) => Math.round(1000 * Math.exp(-(((i - 32) / 12) ** 2))));
  const percentiles = Object.fromEntries([2, 5, 10, 25, 50, 75, 90, 95, 98].map((p) => [`p${p}`, -0.3 + (0.6 * p) / 100]));
  return { status: 200, body: { index: { ...about, pixels: 20_000, min: -0.5, max: 0.5, mean: 0.01, std: 0.1, percentiles, histogram } } };
}
