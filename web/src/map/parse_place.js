// A place that was typed or pasted: latitude and longitude in degrees, decimal or with minutes and seconds, signed or
// with N, S, E, W before or after; WGS84. What could be read in two ways is not read. Pure.
/** @import { LonLat } from './geodesy.js' */

/** @typedef {'empty'|'unreadable'|'swapped'|'range'|'minutes'} PlaceFault */

const kMaxLatitude_deg = 85;  // what the server takes, and Mercator shows

const kShapes = {
  degrees: String.raw`(\d+(?:\.\d+)?)\s*(?:°|d(?:eg)?)?`,
  minutes: String.raw`(\d+)(?:\s*[°:d]\s*|\s+)(\d+(?:\.\d+)?)\s*(?:['m])?`,
  seconds: String.raw`(\d+)(?:\s*[°:d]\s*|\s+)(\d+)(?:\s*[':m]\s*|\s+)(\d+(?:\.\d+)?)\s*(?:["s])?`,
};
const kSign = String.raw`([+-]?)\s*`;
const kLetter = '([NSEW])';
const kBetween = String.raw`(?:\s*[,;/]\s*|\s+|(?<=[NSEW°'"])\s*)`;

// Both halves alike: one of degrees, the other with minutes, is as likely a slip.
const kForms = Object.values(kShapes).flatMap((shape) => {
  const parts = shape.match(/\((?!\?)/g)?.length ?? 0;
  const form = (/** @type {string} */ half, /** @type {'sign'|'before'|'after'} */ kind) => ({ pattern: new RegExp(`^${half}${kBetween}${half}$`, 'i'), kind, parts });
  return [form(`${kSign}${shape}`, 'sign'), form(`${kLetter}\\s*${shape}`, 'before'), form(`${shape}\\s*${kLetter}`, 'after')];
});

/**
 * The many ways in which signs, primes and decimal commas are written, as one.
 * @param {string} text
 */
function plain(text) {
  let plainer = text
    .trim()
    .replace(/^geo:([^;?]*).*$/i, '$1')
    .replace(/[\u2212\u2010-\u2013\ufe63\uff0d]/g, '-')
    .replace(/[\u00ba\u02da]/g, '°')
    .replace(/[\u2018\u2019\u2032\u00b4\u0060\u02b9]/g, "'")
    .replace(/[\u201c\u201d\u2033\u02ba]|''/g, '"')
    .replace(/^[([{]\s*(.*?)\s*[)\]}]$/, '$1')
    .replace(/\b(?:lat(?:itude)?|lon(?:g(?:itude)?)?|lng)\b\s*[:=]?/gi, ' ')
    .trim();
  // "46,9512 7,4391", "46,9512, 7,4391": two decimal commas, and at most one comma between them.
  const decimals = plainer.match(/\d,\d/g)?.length ?? 0;
  const commas = plainer.match(/,/g)?.length ?? 0;
  if (!plainer.includes('.') && decimals === 2 && commas - decimals <= 1) plainer = plainer.replace(/(\d),(?=\d)/g, '$1.');
  return plainer.replace(/\s+/g, ' ');
}

/**
 * @param {string[]} found degrees and, where written, minutes and seconds
 * @returns {number} NaN where minutes or seconds are 60 or more
 */
function angle(found) {
  const [degrees, minutes = 0, seconds = 0] = found.map(Number);
  return minutes < 60 && seconds < 60 ? degrees + minutes / 60 + seconds / 3600 : NaN;
}

/**
 * @param {string} text latitude first, unless letters say otherwise
 * @returns {{place: LonLat}|{fault: PlaceFault}}
 */
export function parsePlace(text) {
  const plainer = plain(text);
  if (plainer === '') return { fault: 'empty' };
  if (/^[+-]?\d+,\d+$/.test(plainer)) return { fault: 'unreadable' };  // whole degrees, or one number with a decimal comma
  for (const { pattern, kind, parts } of kForms) {
    const found = plainer.match(pattern)?.slice(1);
    if (!found) continue;
    const halves = [found.slice(0, parts + 1), found.slice(parts + 1)];
    const marks = halves.map((half) => (kind === 'after' ? half[parts] : half[0]).toUpperCase());
    const angles = halves.map((half) => angle(kind === 'after' ? half.slice(0, parts) : half.slice(1)));
    if (angles.some(Number.isNaN)) return { fault: 'minutes' };
    const values = angles.map((value, i) => ('SW-'.includes(marks[i]) && marks[i] !== '' ? -value : value));
    const axes = marks.map((mark) => (mark === '' || mark === '+' || mark === '-' ? '' : 'NS'.includes(mark) ? 'lat' : 'lon'));
    if (axes[0] !== '' && axes[0] === axes[1]) return { fault: 'unreadable' };
    return checked(axes[0] === 'lon' ? [values[0], values[1]] : [values[1], values[0]], axes[0] !== '');
  }
  return { fault: 'unreadable' };
}

/**
 * @param {LonLat} place
 * @param {boolean} is_named letters say which is which
 * @returns {{place: LonLat}|{fault: PlaceFault}}
 */
function checked([lon, lat], is_named) {
  if (Math.abs(lat) <= kMaxLatitude_deg && Math.abs(lon) <= 180) return { place: [lon, lat] };
  return { fault: !is_named && Math.abs(lon) <= kMaxLatitude_deg && Math.abs(lat) <= 180 ? 'swapped' : 'range' };
}
