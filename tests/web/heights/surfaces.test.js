// What the page reckons of a map's heights, without a browser.
import assert from 'node:assert/strict';
import { setTimeout as delay } from 'node:timers/promises';
import { test } from 'node:test';
import { made } from '../support/fake_page.js';
import { askAtRest } from '../../../web/src/heights/ask_at_rest.js';
import { contourStep, drawnContours } from '../../../web/src/heights/contour_lines.js';
import { readoutWords } from '../../../web/src/heights/height_readout.js';
import { drawnProfile, figuresOf } from '../../../web/src/heights/surface_profile.js';
import { volumeSection } from '../../../web/src/heights/volume_section.js';
import { loadFlightStrings } from '../../../web/src/shared/flight_strings.js';
import { formatVolume, parseNumber, typedNumber, typedText } from '../../../web/src/shared/format.js';
import { speak } from '../../../web/src/shared/language.js';
import { heightIn, volumeIn } from '../../../web/src/shared/units.js';

await loadFlightStrings();

/** Answers that come when a test says so. */
function heldAnswers() {
  /** @type {{signal: AbortSignal, give: (answer: string) => void, fail: (error: Error) => void}[]} */
  const asked = [];
  /** @type {[unknown, unknown][]} */
  const told = [];
  const asker = askAtRest(0, (/** @type {string|null} */ answer, /** @type {unknown} */ error) => told.push([answer, error]));
  const get = (/** @type {AbortSignal} */ signal) => new Promise((give, fail) => asked.push({ signal, give, fail }));
  return { asked, told, about: (/** @type {string} */ subject) => asker.about(subject, get), asker, rest: () => delay(10) };
}

test('only what rests is asked about, once, and the answer is told', async () => {
  const { asked, told, about, asker, rest } = heldAnswers();
  for (const subject of ['a', 'b', 'c']) assert.ok(about(subject));
  assert.equal(about('c'), false);
  await rest();
  assert.equal(asked.length, 1);
  assert.equal(asker.answer, null);
  asked[0].give('of c');
  await rest();
  assert.deepEqual(told, [['of c', null]]);
  assert.equal(asker.answer, 'of c');
  assert.equal(about('c'), false);
});

test('an earlier answer never comes after a later one, nor after all was dropped', async () => {
  const { asked, told, about, asker, rest } = heldAnswers();
  about('a');
  await rest();
  about('b');
  assert.ok(asked[0].signal.aborted);
  await rest();
  asked[1].give('of b');
  await rest();
  asked[0].give('of a');
  await rest();
  assert.deepEqual(told, [['of b', null]]);
  about('c');
  await rest();
  asker.drop();
  asked[2].give('of c');
  await rest();
  assert.equal(told.length, 1);
  assert.equal(asker.answer, null);
});

test('what failed is asked again', async () => {
  const { asked, told, about, rest } = heldAnswers();
  about('a');
  await rest();
  asked[0].fail(new Error('away'));
  await rest();
  assert.equal(told[0][0], null);
  assert.ok(about('a'));
});

/** @param {(number|null)[]} dsm @param {(number|null)[]} dtm */
const samplesOf = (dsm, dtm) => dsm.map((dsm_m, i) => ({ distance_m: i, lon: 7, lat: 46, height_m: 500, dsm_m, dtm_m: dtm[i] }));
const smooth = { ground: /** @type {const} */ ('plane'), length_m: 4, lowest_m: 500, highest_m: 500, climb_m: 0, descent_m: 0 };

test('a profile is that of the surface where the map has one, with the ground below it', () => {
  const samples = samplesOf([400, 407, null, 403, 402], [400, 400.5, 401, null, 401.5]);
  const drawn = drawnProfile({ ...smooth, samples, surfaces: ['dsm', 'dtm'] });
  assert.equal(drawn.is_level, false);
  assert.deepEqual(drawn.samples.map(({ height_m }) => height_m), [400, 407, null, 403, 402]);
  assert.deepEqual(drawn.below.map(({ height_m }) => height_m), [400, 400.5, 401, null, 401.5]);
  assert.deepEqual([drawn.lowest_m, drawn.highest_m, drawn.climb_m, drawn.descent_m], [400, 407, 7, 1], 'nothing climbs over a gap');
  assert.deepEqual(drawnProfile({ ...smooth, samples, surfaces: ['dsm'] }).below, []);
});

test('without surfaces the profile is that of the smooth ground', () => {
  const samples = samplesOf([null, null], [null, null]);
  const drawn = drawnProfile({ ...smooth, samples });
  assert.deepEqual([drawn.is_level, drawn.is_surface, drawn.lowest_m], [true, false, 500]);
  assert.deepEqual(drawn.samples, samples);
  assert.equal(drawnProfile({ ...smooth, ground: 'grid', samples }).is_level, false);
  assert.deepEqual(figuresOf(samplesOf([], [])), { lowest_m: null, highest_m: null, climb_m: 0, descent_m: 0 });
});

test('the height below the cursor has centimetres, and what stands on the ground its own', () => {
  assert.deepEqual(readoutWords({ dsm_m: 412.352, dtm_m: 405.15 }, 'metric'), { height: '412.35\u00a0m', over_ground: '+7.2\u00a0m' });
  assert.equal(readoutWords({ dsm_m: 412.352, dtm_m: 412.1 }, 'metric').over_ground, '', 'grass');
  assert.equal(readoutWords({ dsm_m: 412.352, dtm_m: 413 }, 'metric').over_ground, '');
  assert.equal(readoutWords({ dsm_m: 412.352 }, 'metric').over_ground, '');
  assert.deepEqual(readoutWords({ dsm_m: null, dtm_m: 400 }, 'metric'), { height: '', over_ground: '' });
  assert.deepEqual(readoutWords({}, 'metric'), { height: '', over_ground: '' });
  assert.deepEqual(readoutWords({ dsm_m: 30.48, dtm_m: 27.432 }, 'imperial'), { height: '100.0\u00a0ft', over_ground: '+10.0\u00a0ft' });
  assert.equal(heightIn(-0.004, 'metric', [], 2), '0.00\u00a0m');
});

test('volumes are cubic metres or cubic yards, and numbers are read with a comma too', () => {
  assert.equal(formatVolume(12_345.6), '12,346\u00a0m³');
  assert.equal(formatVolume(-3.456), '-3.46\u00a0m³');
  assert.equal(formatVolume(-0.001), '0\u00a0m³');
  assert.equal(volumeIn(7.64554857984, 'imperial'), '10\u00a0yd³');
  assert.equal(volumeIn(7.64554857984, 'metric'), '7.65\u00a0m³');
  assert.deepEqual(['412,5', ' 412.5 ', '', 'x', '0x10', 'Infinity', '1,234.5'].map(parseNumber), [412.5, 412.5, NaN, NaN, NaN, NaN, NaN]);
  // In English it may be a thousand and more that is typed.
  assert.deepEqual(['1,250', ' -12,500', '0,125', '1250,125', '1,25', '1.250'].map((text) => typedNumber(text)), [NaN, NaN, 0.125, 1250.125, 1.25, 1.25]);
  speak('de');
  assert.deepEqual(['1,250', '1.250', ' -12.500', '0.125', '1250.125', '1.25'].map((text) => typedNumber(text)), [1.25, NaN, NaN, 0.125, 1250.125, 1.25]);
  assert.deepEqual([412.345, -0.5, 20].map((value) => typedNumber(typedText(value))), [412.345, -0.5, 20], 'what a form is filled with it takes');
  speak('en');
});

test('every fifth contour is strong, whatever their distance, also below zero', () => {
  assert.equal(contourStep([]), 0);
  assert.equal(contourStep([10, 10]), 0);
  assert.ok(Math.abs(contourStep([10.2, 10, 10.4, 10.4, 11]) - 0.2) < 1e-9);
  const line = /** @type {GeoJSON.LineString} */ ({ type: 'LineString', coordinates: [[7, 46], [7.1, 46]] });
  const contours = (/** @type {number[]} */ ...heights) => /** @type {any} */ ({ type: 'FeatureCollection', features: heights.map((height_m) => ({ type: 'Feature', geometry: line, properties: { height_m } })) });
  const strong = (/** @type {number[]} */ ...heights) => drawnContours(contours(...heights), 'metric').features.filter(({ properties }) => properties.is_strong).map(({ properties }) => properties.label);
  assert.deepEqual(strong(9.8, 10, 10.2, 10.4, 10.6, 10.8, 11), ['10.0\u00a0m', '11.0\u00a0m']);
  assert.deepEqual(strong(-12, -11, -10, -9), ['-10\u00a0m']);
  assert.deepEqual(strong(412), ['412\u00a0m'], 'the only one');
  assert.equal(drawnContours(contours(30.48, 60.96), 'imperial').features[0].properties.label, '100\u00a0ft');
});

test('a volume above one base does not stand below another while that is asked for', async () => {
  const found = { area_m2: 100, covered_m2: 100, measured_share: 1, cut_m3: 5, fill_m3: 2, net_m3: 3, net_sigma_m3: 1, base: 'lowest', base_m: 400, shift: null };
  globalThis.fetch = async (address) => Response.json(String(address).includes('/volume?') ? found : { flights: [] });
  const view = { shown: new EventTarget(), heights: ['dsm'], flight_id: 'f', bounds: null };
  const section = volumeSection(/** @type {any} */ (view));
  const [base, result] = ['volume-base', 'volume-result'].map((id) => made.findLast(({ attributes }) => attributes.id === id));
  const shown = () => result?.firstChild?.attributes.id;
  Object.assign(base ?? {}, { value: 'lowest' });
  section.show([[7, 46], [7.001, 46], [7.001, 46.001]], 'metric');
  while (shown() !== 'volume-figures') await delay(10);
  Object.assign(base ?? {}, { value: 'plane' });
  base?.dispatchEvent(new Event('change'));
  assert.equal(shown(), 'volume-message');
  while (shown() !== 'volume-figures') await delay(10);
});
