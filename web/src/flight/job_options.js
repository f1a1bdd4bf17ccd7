// How a map is made, as the form has it and as the server takes it (JobOptions of the contract); what was chosen for
// each flight, until its map is begun, and presets, both of which this browser keeps. Pure but for these.
import { kLayers } from '../shared/api.js';
import { typedNumber, typedText } from '../shared/format.js';
import { dropChoice, keepChoice, keptChoice } from '../shared/language.js';
import { parsePlace } from '../map/parse_place.js';
import { movesMap } from './job_watch.js';

/**
 * @typedef {object} OptionsForm empty texts and null are left to the server
 * @property {string} resolution_cm of a pixel
 * @property {boolean} not_finer than the photos' own pixels
 * @property {string} method
 * @property {string} surface
 * @property {string} heights
 * @property {string[]} layers
 * @property {string} max_look_deg
 * @property {string} readout_ms
 * @property {string} format
 * @property {string} quality
 * @property {string} origin where a flight without any position took off
 * @property {string} takeoff_height_m above sea level
 * @property {Area|null} boundary that the map is cut to; null: the whole of it
 */
/** @typedef {GeoJSON.Polygon|GeoJSON.MultiPolygon} Area */
/** @typedef {Record<string, any>} JobOptions */
/** @typedef {'method'|'surface'|'heights'|'format'} Choice */
/** @typedef {'resolution_cm'|'max_look_deg'|'readout_ms'|'quality'|'takeoff_height_m'} NumberField */
/** @typedef {NumberField|'origin'} TypedField */

/** What is chosen of each; the first where nothing is said. @type {Record<Choice, string[]>} */
export const kChoices = {
  method: ['auto', 'images', 'imu'],
  surface: ['smooth', 'dense', 'auto'],
  heights: ['none', 'dsm', 'dtm'],
  format: ['auto', 'jpeg-png', 'webp'],
};
export const kChoiceNames = /** @type {Choice[]} */ (Object.keys(kChoices));
/** What the contract allows; usual: where nothing is typed. @type {Record<NumberField, {least: number, most: number, usual?: number, is_whole?: boolean}>} */
export const kLimits = {
  resolution_cm: { least: 0.1, most: 10_000 },
  max_look_deg: { least: 10, most: 75, usual: 65 },
  readout_ms: { least: 0, most: 500 },
  quality: { least: 1, most: 100, usual: 85, is_whole: true },
  takeoff_height_m: { least: -500, most: 9000 },
};
const kNumbers = /** @type {NumberField[]} */ (Object.keys(kLimits));

/** @type {Readonly<OptionsForm>} */
export const kStandard = formOf({ layers: kLayers });

/** Those that come with the page, by their names in strings.options.presets. @type {Record<'standard'|'quick'|'detailed', OptionsForm>} */
export const kPresets = {
  standard: kStandard,
  quick: { ...kStandard, resolution_cm: '20', layers: [] },
  detailed: { ...kStandard, quality: '95' },
};

/** @param {string} text as people of many countries write numbers, without a power @returns {number} NaN where it is none */
const numberOf = (text) => (/e/i.test(text) ? NaN : typedNumber(text));

/** What is not as where nothing is said. @param {OptionsForm} form @returns {[Choice, string][]} */
export const chosenIn = (form) => kChoiceNames.flatMap((field) => (form[field] === kChoices[field][0] ? [] : [[field, form[field]]]));

/**
 * @param {OptionsForm} form
 * @returns {{options: JobOptions, faults: TypedField[]}} faults: fields that the server would refuse
 */
export function optionsOf(form) {
  /** @type {TypedField[]} */
  const faults = [];
  /** @type {JobOptions} */
  const options = { layers: kLayers.filter((layer) => form.layers.includes(layer)) };
  for (const field of kNumbers) {
    if (form[field].trim() === '') continue;
    const value = numberOf(form[field]);
    const { least, most, is_whole } = kLimits[field];
    if (!(value >= least && value <= most) || (is_whole && !Number.isInteger(value))) faults.push(field);
    if (field === 'resolution_cm') Object.assign(options, { gsd_m: value / 100, not_finer_than_photos: form.not_finer });
    else options[field] = value;
  }
  for (const [field, value] of chosenIn(form)) options[field] = value;
  const origin = form.origin.trim() === '' ? null : parsePlace(form.origin);
  if (origin && 'fault' in origin) faults.push('origin');
  else if (origin) options.origin = [origin.place[1], origin.place[0]];
  if (form.boundary) options.boundary = form.boundary;
  return { options, faults };
}

/** As MosaicOptions::CheckGsd has it. */
const kMaxTimesCoarser = 20;

/** @param {JobOptions} options @param {number} photos_gsd_m 0 where it is not known @returns {number|null} null: not beyond reason */
export const timesCoarser = ({ gsd_m }, photos_gsd_m) => (photos_gsd_m > 0 && gsd_m > kMaxTimesCoarser * photos_gsd_m ? gsd_m / photos_gsd_m : null);

/** Of a job's options, which together may have 64 KiB. */
const kMaxAreaBytes = 60_000;
const kPlaces = 1e8;  // of a degree: a millimetre

/**
 * An area as a job takes it: without more digits than mean anything.
 * @param {Area} area
 * @returns {Area|null} null: it has too many corners
 */
export function jobArea(area) {
  /** @type {(inner: any) => any} */
  const rounded = (inner) => (Array.isArray(inner) ? inner.map(rounded) : Math.round(inner * kPlaces) / kPlaces);
  const made = /** @type {Area} */ ({ type: area.type, coordinates: rounded(area.coordinates) });
  return JSON.stringify(made).length > kMaxAreaBytes ? null : made;
}

/** What a program asked for may be a collection: the page keeps what it can show as one. @param {any} boundary @returns {Area|null} */
function areaOf(boundary) {
  const polygons = (/** @type {any} */ object) => {
    if (object?.type === 'Polygon' && Array.isArray(object.coordinates)) return [object.coordinates];
    if (object?.type === 'MultiPolygon' && Array.isArray(object.coordinates)) return object.coordinates;
    if (object?.type === 'Feature') return polygons(object.geometry);
    if (object?.type === 'FeatureCollection' && Array.isArray(object.features)) return object.features.flatMap(polygons);
    return [];
  };
  const found = polygons(boundary);
  if (found.length === 0) return null;
  return found.length === 1 ? { type: 'Polygon', coordinates: found[0] } : { type: 'MultiPolygon', coordinates: found };
}

/** @param {JobOptions} options of a job @returns {OptionsForm} */
export function formOf(options) {
  return {
    .../** @type {Record<Choice, string>} */ (Object.fromEntries(kChoiceNames.map((field) => [field, kChoices[field].includes(options[field]) ? options[field] : kChoices[field][0]]))),
    .../** @type {Record<NumberField, string>} */ (Object.fromEntries(kNumbers.map((field) => [field, typeof options[field] === 'number' ? typedText(options[field]) : '']))),
    resolution_cm: typeof options.gsd_m === 'number' ? typedText(Number((options.gsd_m * 100).toPrecision(6))) : '',
    not_finer: typeof options.gsd_m !== 'number' || options.not_finer_than_photos === true,
    layers: Array.isArray(options.layers) ? kLayers.filter((layer) => options.layers.includes(layer)) : [],
    origin: Array.isArray(options.origin) ? options.origin.join(', ') : '',
    boundary: areaOf(options.boundary),
  };
}

/** @type {Map<string, JobOptions>} by flight */
const chosen = new Map();
const chosenKey = (/** @type {string} */ flight_id) => `skyquilt.options.${flight_id}`;

/** What was chosen before the page was loaded anew. @param {string} flight_id @returns {JobOptions|null} */
function keptOptions(flight_id) {
  try {
    const kept = JSON.parse(keptChoice(chosenKey(flight_id)) ?? 'null');
    return kept ? optionsOf(formOf(kept)).options : null;
  } catch (error) {
    console.debug('options cannot be read', error);
    return null;
  }
}

/** What each flight's last job was asked for that made a map, or was to, as far as this page has seen it. @type {Map<string, JobOptions>} */
const last = new Map();

/** @param {import('../shared/types.js').Flight} flight */
export function seeLastOptions({ id, job }) {
  const options = job?.options ?? {};
  if (Object.keys(options).length > 0 && !movesMap(job) && !options.import_file) last.set(id, options);
}

/** What this page's next job for a flight is asked for: without a choice here the same as the last one. @param {string} flight_id @returns {JobOptions} */
export const chosenOptions = (flight_id) => chosen.get(flight_id) ?? keptOptions(flight_id) ?? last.get(flight_id) ?? optionsOf(kStandard).options;

/** @param {string} flight_id @param {JobOptions} options */
export function chooseOptions(flight_id, options) {
  chosen.set(flight_id, options);
  keepChoice(chosenKey(flight_id), JSON.stringify(options));
}

/** A choice is for one map. @param {string} flight_id @param {JobOptions} [begun] the options of its job; without them there will be none */
export function forgetChosen(flight_id, begun) {
  chosen.delete(flight_id);
  dropChoice(chosenKey(flight_id));
  if (begun) last.set(flight_id, begun);
}

/** What no other flight shares. @type {Pick<OptionsForm, 'origin'|'takeoff_height_m'|'boundary'>} */
const kOfOneFlight = { origin: '', takeoff_height_m: '', boundary: null };

const kKey = 'skyquilt.presets';
const kMaxPresets = 50;

/** The user's own; whatever else lies there is passed over. @returns {Record<string, OptionsForm>} */
export function keptPresets() {
  /** @type {Record<string, OptionsForm>} */
  const presets = {};
  try {
    const kept = JSON.parse(keptChoice(kKey) ?? '{}');
    for (const [name, options] of Object.entries(kept)) if (options && typeof options === 'object') presets[name] = { ...formOf(options), ...kOfOneFlight };
  } catch (error) {
    console.debug('presets cannot be read', error);
  }
  return presets;
}

/** @param {string} name @param {OptionsForm|null} form null: it goes @returns {boolean} whether this browser keeps it */
export function keepPreset(name, form) {
  const { [name]: _, ...others } = keptPresets();
  const presets = form ? { ...others, [name]: { ...form, ...kOfOneFlight } } : others;
  if (Object.keys(presets).length > kMaxPresets) return false;
  try {
    localStorage.setItem(kKey, JSON.stringify(Object.fromEntries(Object.entries(presets).map(([key, value]) => [key, optionsOf(value).options]))));
    return true;
  } catch {
    return false;  // private windows keep nothing
  }
}
