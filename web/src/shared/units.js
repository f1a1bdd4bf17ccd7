// Lengths, areas and volumes in the units of who reads: metres and hectares, or feet and acres.
import { chosenUnits, formatArea, formatLength, formatVolume, kFoot_m, kMile_ft, threeDigits, units_chosen } from './format.js';
import { fixed } from './language.js';
import { strings } from './strings.js';

export { chosenUnits, distanceTold, errorIn, errorTold, keepUnits, units_chosen, usualUnits } from './format.js';

/** @typedef {import('./format.js').Units} Units */

const kAcre_m2 = 4046.8564224;
const kYard_m = 3 * kFoot_m;

/** @param {number} metres @param {Units} units */
export function lengthIn(metres, units) {
  if (units === 'metric') return formatLength(metres);
  const feet = metres / kFoot_m;
  return feet < kMile_ft ? `${fixed(feet, feet < 100 ? 2 : 1)}\u00a0ft` : `${fixed(feet / kMile_ft, 3)}\u00a0mi`;
}

/** Metres in what heights are told in. @param {Units} units */
export const metresPer = (units) => (units === 'metric' ? 1 : kFoot_m);

/** The sign of that unit. @param {Units} units */
export const heightUnit = (units) => (units === 'metric' ? 'm' : 'ft');

/**
 * A height, or a difference of two: to a decimetre, more than which no ground is known.
 * @param {number} metres
 * @param {Units} units
 * @param {number[]} [among] whose values, in metres, it has to be told from
 * @param {number} [digits] of what is known better
 */
export function heightIn(metres, units, among = [], digits = 1) {
  const per_m = metresPer(units);
  const is_whole = among.length > 0 && among.every((value) => Math.abs(value / per_m - Math.round(value / per_m)) < 1e-6);
  const value = Number((metres / per_m).toFixed(digits)) + 0;  // no minus before a zero
  return `${fixed(value, is_whole ? 0 : digits)}\u00a0${heightUnit(units)}`;
}

/** @param {number} square_metres @param {Units} units */
export function areaIn(square_metres, units) {
  if (units === 'metric') return formatArea(square_metres);
  const acres = square_metres / kAcre_m2;
  return acres < 0.5 ? `${fixed(square_metres / kFoot_m ** 2, 0)}\u00a0ft²` : `${fixed(acres, acres < 10 ? 3 : 1)}\u00a0${strings.quantities.acres}`;
}

/** @param {number} cubic_metres @param {Units} units */
export function volumeIn(cubic_metres, units) {
  if (units === 'metric') return formatVolume(cubic_metres);
  return `${threeDigits(Number((cubic_metres / kYard_m ** 3).toFixed(2)) + 0)}\u00a0yd³`;
}

/** In the units that are chosen. @param {number} metres @param {number} digits */
export const metresTold = (metres, digits) => heightIn(metres, chosenUnits(), [], digits);

/** How what is shown in units is made: it goes with that. @type {WeakMap<Element, () => HTMLElement|null>} */
const makers = new WeakMap();
const kInUnits = 'data-in-units';

/** Made again when other units are chosen. @param {() => HTMLElement|null} make */
export function inUnits(make) {
  const shown = make();
  if (!shown) return null;
  shown.setAttribute(kInUnits, '');
  makers.set(shown, make);
  return shown;
}

units_chosen.addEventListener('change', () => {
  for (const shown of globalThis.document?.querySelectorAll(`[${kInUnits}]`) ?? []) {
    const make = makers.get(shown);
    const anew = make && shown.isConnected ? inUnits(make) : null;
    if (anew) shown.replaceWith(anew);
  }
});
