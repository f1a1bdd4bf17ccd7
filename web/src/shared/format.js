// Numbers as people read them, in the language of the page; a number is kept on one line with its unit. Metric, but for what
// ends in In or Told; in which units somebody reads. What the first view does without is in units.js.
import { dateFormat, fixed, keepChoice, keptChoice, language, number } from './language.js';
import { strings } from './strings.js';

/** What there is of several words, one after the other. @param {...(string|false|null|undefined)} words */
export const dotted = (...words) => words.filter(Boolean).join(' · ');

/**
 * A number with about three significant digits.
 * @param {number} value
 * @returns {string}
 */
export function threeDigits(value) {
  const size = Math.abs(value);
  return fixed(value, size >= 100 || Number.isInteger(value) ? 0 : size >= 10 ? 1 : 2);
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
  return `${unit === 0 ? number(Math.round(value)) : threeDigits(value)}\u00a0${units[unit]}`;
}

/**
 * A duration the way one says it: "40 s", "3 min", "1 h 20 min".
 * @param {number} seconds
 * @returns {string}
 */
export function formatDuration(seconds) {
  const s = Math.max(0, seconds);
  if (s < 1) return strings.quantities.below_second;
  if (s < 90) return `${number(Math.round(s))}\u00a0s`;
  const minutes = Math.round(s / 60);
  if (minutes < 90) return `${number(minutes)}\u00a0min`;
  const rest = minutes % 60;
  return `${number(Math.floor(minutes / 60))}\u00a0h${rest ? ` ${number(rest)}\u00a0min` : ''}`;
}

/**
 * @param {number} metres
 * @returns {string}
 */
export function formatLength(metres) {
  const size = Math.abs(metres);  // heights lie below zero, too
  if (size < 0.01) return `${threeDigits(metres * 1000)}\u00a0mm`;
  if (size < 1) return `${threeDigits(metres * 100)}\u00a0cm`;
  if (size < 1000) return `${fixed(metres, size < 100 ? 2 : 1)}\u00a0m`;
  return `${fixed(metres / 1000, 3)}\u00a0km`;
}

/**
 * A round length: "20 cm", "200 m", "1.5 km", "1000 km".
 * @param {number} metres
 */
export const formatDistance = (metres) => (metres < 1 ? formatError(metres) : metres < 1000 ? `${fixed(metres, 0)}\u00a0m` : `${number(metres / 1000, { maximumFractionDigits: metres < 10_000 ? 1 : 0 })}\u00a0km`);

/**
 * An estimate of an error: two digits are all that it is worth.
 * @param {number} metres
 * @returns {string}
 */
export function formatError(metres) {
  const [value, unit] = metres < 1 ? [metres * 100, 'cm'] : [metres, 'm'];
  return `${number(value, { maximumSignificantDigits: 2, useGrouping: false })}\u00a0${unit}`;
}

/** @typedef {'metric'|'imperial'} Units by the browser's country until one chooses; the choice stays in this browser */

const kUnits = 'skyquilt.units';
export const kFoot_m = 0.3048;
export const kMile_ft = 5280;
const kFoot_in = 12;
// Whose land is measured in feet and acres.
const kImperial = new Set(['US', 'LR', 'MM']);

/** @param {string} language a tag like "en-US" @returns {Units} */
export function usualUnits(language) {
  try {
    return kImperial.has(new Intl.Locale(language).maximize().region ?? '') ? 'imperial' : 'metric';
  } catch {
    return 'metric';  // no language that anybody knows
  }
}

/** @returns {Units} */
export function chosenUnits() {
  const kept = keptChoice(kUnits);
  return kept === 'metric' || kept === 'imperial' ? kept : usualUnits(globalThis.navigator?.language ?? '');
}

/** Emits 'change' when others were chosen. */
export const units_chosen = new EventTarget();

/** @param {Units} units */
export function keepUnits(units) {
  keepChoice(kUnits, units);
  units_chosen.dispatchEvent(new Event('change'));
}

/** The same, below a foot in inches. @param {number} metres @param {Units} units */
export function errorIn(metres, units) {
  if (units === 'metric') return formatError(metres);
  const feet = metres / kFoot_m;
  const [value, unit] = feet < 1 ? [feet * kFoot_in, 'in'] : [feet, 'ft'];
  return `${number(value, { maximumSignificantDigits: 2, useGrouping: false })}\u00a0${unit}`;
}

/** In the units that are chosen. @param {number} metres */
export const errorTold = (metres) => errorIn(metres, chosenUnits());

/** A round length, in the units that are chosen. @param {number} metres */
export function distanceTold(metres) {
  if (chosenUnits() === 'metric') return formatDistance(metres);
  const feet = metres / kFoot_m;
  if (feet < 1) return errorIn(metres, 'imperial');
  return feet < kMile_ft ? `${fixed(feet, feet < 10 ? 1 : 0)}\u00a0ft` : `${number(feet / kMile_ft, { maximumFractionDigits: feet < 10 * kMile_ft ? 1 : 0 })}\u00a0mi`;
}

/** The longest round length that is no longer, in metres: round in the units that are chosen. @param {number} most_m */
export function roundLength(most_m) {
  const mile_m = kMile_ft * kFoot_m;
  const unit_m = chosenUnits() === 'metric' ? 1 : most_m < mile_m ? kFoot_m : mile_m;
  const power_m = unit_m * 10 ** Math.floor(Math.log10(most_m / unit_m));
  // Steps so close that a scale's bar is never shorter than its own words.
  return power_m * ([7, 5, 3, 2, 1.5].find((step) => most_m >= step * power_m) ?? 1);
}

/**
 * Ground size of a pixel: always in centimetres below a metre, as pilots say it.
 * @param {number} metres
 * @returns {string}
 */
export function formatGsd(metres) {
  return metres < 1 ? `${threeDigits(metres * 100)}\u00a0cm/px` : `${threeDigits(metres)}\u00a0m/px`;
}

/**
 * @param {number} square_metres
 * @returns {string}
 */
export function formatArea(square_metres) {
  if (square_metres < 10_000) return `${threeDigits(square_metres)}\u00a0m²`;
  if (square_metres < 1_000_000) return `${threeDigits(square_metres / 10_000)}\u00a0ha`;
  return `${threeDigits(square_metres / 1_000_000)}\u00a0km²`;
}

/**
 * @param {number} cubic_metres
 * @returns {string}
 */
export const formatVolume = (cubic_metres) => `${threeDigits(Number(cubic_metres.toFixed(2)) + 0)}\u00a0m³`;  // no minus before a zero

/**
 * A number as people write it, with a point or a comma.
 * @param {string} text
 * @returns {number} NaN where it is none
 */
export function parseNumber(text) {
  const plain = text.trim().replace(',', '.');
  const value = /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(plain) ? Number(plain) : NaN;
  return Number.isFinite(value) ? value : NaN;
}

/** What is typed in the middle of a number that is not whole; English has readers (South Africa) whose browsers write a comma there. */
const decimalSign = () => (language === 'en' ? '.' : number(1.5).charAt(1));

/**
 * The same of what somebody types: "1,250", in German "1.250", may be a thousand and more, and counts as none.
 * @param {string} text
 */
export function typedNumber(text) {
  const other = decimalSign() === ',' ? '.' : ',';
  const [whole, rest = ''] = text.trim().split(other);
  return /^[+-]?[1-9]\d{0,2}$/.test(whole) && /^\d{3}$/.test(rest) ? NaN : parseNumber(text);
}

/** As it would be typed, with all its digits. @param {number} value */
export const typedText = (value) => String(value).replace('.', decimalSign());

/**
 * @param {number} fraction 0..1
 * @returns {string}
 */
export function formatPercent(fraction) {
  return number(Math.floor(Math.min(1, Math.max(0, fraction)) * 100) / 100, { style: 'percent', maximumFractionDigits: 0 });
}

/**
 * @param {string} iso
 * @param {{with_time?: boolean, time_zone?: string}} [options] time_zone: the reader's own where none is given
 * @returns {string} empty when it is no date
 */
export function formatDate(iso, options = {}) {
  const date = new Date(iso);
  if (Number.isNaN(date.getTime())) return '';
  return dateFormat({ dateStyle: 'medium', timeStyle: options.with_time ? 'short' : undefined, timeZone: options.time_zone }).format(date);
}

// A time as it is written, zone left aside: the clock on the wall of the place, not of the reader.
const kWritten = /^(\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d)(?:\.\d+)?(Z|[+-]\d\d:\d\d)?$/;

/** @param {string} iso @returns {{wall: Date, zone: string}|null} the wall's time as if it were UTC */
function wallTime(iso) {
  const match = iso.match(kWritten);
  const wall = new Date(`${match?.[1]}Z`);
  if (!match || Number.isNaN(wall.getTime())) return null;
  const [, hours, minutes] = match[2]?.match(/^([+-]\d\d):(\d\d)$/) ?? [];
  const offset = hours === undefined ? '' : `${Number(hours) < 0 || hours[0] === '-' ? '\u2212' : '+'}${Math.abs(Number(hours))}${minutes === '00' ? '' : `:${minutes}`}`;
  return { wall, zone: match[2] ? `UTC${offset === '+0' ? '' : offset}` : '' };
}

/**
 * The day that photos were taken, where they were taken.
 * @param {{first: string, last: string}} captured
 * @param {'short'} [time_style] the hours too
 * @returns {string} empty when it is no time
 */
export function formatCaptureDay({ first, last }, time_style) {
  const [from, to] = [wallTime(first), wallTime(last)];
  return from && to ? dateFormat({ dateStyle: 'medium', timeStyle: time_style, timeZone: 'UTC' }).formatRange(from.wall, to.wall) : '';
}

/** The same with the hours and their zone. @param {{first: string, last: string}} captured */
export function formatCaptureTime(captured) {
  const [words, zone] = [formatCaptureDay(captured, 'short'), wallTime(captured.first)?.zone];
  return words && zone ? `${words} (${zone})` : words;
}

/**
 * A moment that is written in UTC, as the clock of the place had it: one rule for a photo and its flight.
 * @param {string} iso
 * @param {string|undefined} first of the flight's times of capture, which know the zone of that clock
 * @returns {string} the same where either knows no zone
 */
export function byClockOf(iso, first) {
  const [zone, sign, hours, minutes] = first?.match(/([+-])(\d\d):(\d\d)$/) ?? [];
  const utc_ms = Date.parse(iso);
  if (!zone || !iso.endsWith('Z') || Number.isNaN(utc_ms)) return iso;
  const ahead_ms = Number(`${sign}1`) * (60 * Number(hours) + Number(minutes)) * 60_000;
  return new Date(utc_ms + ahead_ms).toISOString().replace('Z', zone);
}

/**
 * A name no longer than the server takes.
 * @param {string} name
 * @returns {string} at most 200 bytes of UTF-8, never cut inside a character
 */
export function clipName(name) {
  const letters = [...name];
  while (new TextEncoder().encode(letters.join('')).length > 200) letters.pop();
  return letters.join('');
}
