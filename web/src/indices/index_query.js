// How an index is asked for: the parameters of its addresses, and the addresses of its tiles. Pure.
/** @import { MapIndex, ReportedBand } from '../shared/types.js' */
import { typedNumber } from '../shared/format.js';

/**
 * @typedef {object} IndexLook
 * @property {MapIndex} index a named one, or an expression of the user's own, which has no id
 * @property {string} colormap
 * @property {[number, number]} rescale
 */

/** Which index, without its colours. @param {MapIndex} index */
export const indexQuery = (index) => (index.id ? `index=${encodeURIComponent(index.id)}` : `expression=${encodeURIComponent(index.expression)}`);

/** @param {IndexLook} look */
const lookQuery = ({ index, colormap, rescale }) => `${indexQuery(index)}&rescale=${rescale.join(',')}&colormap=${encodeURIComponent(colormap)}`;

/**
 * The addresses of an index' tiles from those of its map.
 * @param {string} template of the map: ".../{z}/{x}/{y}?rev=3"
 * @param {IndexLook} look
 */
export const indexTiles = (template, look) => `${template.replace('{y}?', '{y}.png?')}&${lookQuery(look)}`;

/**
 * Two numbers of a range, wherever they can be one.
 * @param {string} least
 * @param {string} most
 * @returns {[number, number]|null}
 */
export function parseRange(least, most) {
  const [from, to] = [least, most].map(typedNumber);
  return Number.isFinite(from) && Number.isFinite(to) && from < to ? [from, to] : null;
}

/**
 * Rounded to what a person would write for a range of this width.
 * @param {number} value
 * @param {number} width
 */
export function roundTo(value, width) {
  const step = 10 ** Math.floor(Math.log10(Math.max(width, 1e-9)) - 1);
  return Number((Math.round(value / step) * step).toPrecision(6));
}

// The least that may be said of a value comes first.
const kCalibrations = /** @type {const} */ (['levels', 'radiance', 'relative reflectance', 'reflectance', 'sensor', 'targets', 'panel', 'kelvin']);

/** An older report does not say whether a panel was there. @param {ReportedBand} band */
const worthOf = ({ calibration, held_against }) => held_against ?? (calibration === 'reflectance' && held_against === null ? 'sensor' : calibration);

/**
 * What an index' values are worth: the least of what its bands' are.
 * @param {string} expression
 * @param {ReportedBand[]|null} bands null: it is made of the map's colours
 * @returns {string} a key of the words for it
 */
export function calibrationOf(expression, bands) {
  if (!bands) return 'colours';
  const named = new Set(expression.toLowerCase().match(/[a-z_][a-z0-9_]*/g));
  const worth = bands.filter(({ name }) => named.has(name)).map(worthOf);
  return kCalibrations.find((one) => worth.includes(one)) ?? 'unknown';
}
