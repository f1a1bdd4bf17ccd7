// Numbers as people read them. Pure functions; metric units; the browser's own number and date formats.

const number = (/** @type {number} */ digits) =>
  new Intl.NumberFormat(undefined, { maximumFractionDigits: digits, minimumFractionDigits: digits });

/**
 * A number with about three significant digits.
 * @param {number} value
 * @returns {string}
 */
export function threeDigits(value) {
  const size = Math.abs(value);
  return number(size >= 100 || Number.isInteger(value) ? 0 : size >= 10 ? 1 : 2).format(value);
}

/**
 * @param {number} bytes
 * @returns {string}
 */
export function formatBytes(bytes) {
  const units = ['B', 'kB', 'MB', 'GB', 'TB'];
  let value = Math.max(0, bytes);
  let unit = 0;
  while (value >= 999.5 && unit < units.length - 1) {
    value /= 1000;
    unit += 1;
  }
  return `${unit === 0 ? Math.round(value) : threeDigits(value)} ${units[unit]}`;
}

/**
 * A duration the way one says it: "40 s", "3 min", "1 h 20 min".
 * @param {number} seconds
 * @returns {string}
 */
export function formatDuration(seconds) {
  const s = Math.max(0, seconds);
  if (s < 1) return 'less than 1 s';
  if (s < 90) return `${Math.round(s)} s`;
  const minutes = Math.round(s / 60);
  if (minutes < 90) return `${minutes} min`;
  const rest = minutes % 60;
  return rest ? `${Math.floor(minutes / 60)} h ${rest} min` : `${minutes / 60} h`;
}

/**
 * @param {number} metres
 * @returns {string}
 */
export function formatLength(metres) {
  if (metres < 0.1) return `${threeDigits(metres * 1000)} mm`;
  if (metres < 1) return `${threeDigits(metres * 100)} cm`;
  if (metres < 1000) return `${number(metres < 100 ? 2 : 1).format(metres)} m`;
  return `${number(3).format(metres / 1000)} km`;
}

/**
 * Ground size of a pixel: always in centimetres below a metre, as pilots say it.
 * @param {number} metres
 * @returns {string}
 */
export function formatGsd(metres) {
  return metres < 1 ? `${threeDigits(metres * 100)} cm/px` : `${threeDigits(metres)} m/px`;
}

/**
 * @param {number} square_metres
 * @returns {string}
 */
export function formatArea(square_metres) {
  if (square_metres < 10_000) return `${threeDigits(square_metres)} m²`;
  if (square_metres < 1_000_000) return `${threeDigits(square_metres / 10_000)} ha`;
  return `${threeDigits(square_metres / 1_000_000)} km²`;
}

/**
 * @param {number} fraction 0..1
 * @returns {string}
 */
export function formatPercent(fraction) {
  return `${Math.floor(Math.min(1, Math.max(0, fraction)) * 100)} %`;
}

/**
 * @param {string} iso
 * @returns {string} empty when it is no date
 */
export function formatDate(iso) {
  const date = new Date(iso);
  if (Number.isNaN(date.getTime())) return '';
  return new Intl.DateTimeFormat(undefined, { dateStyle: 'medium', timeStyle: 'short' }).format(date);
}
