// How a map is made, chosen on the page, in Chromium against the mock server; and the form against the contract.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';
import { chooseOptions, chosenOptions, forgetChosen, formOf, jobArea, kChoices, kLimits, kPresets, kStandard, optionsOf, seeLastOptions, timesCoarser } from '../../web/src/flight/job_options.js';
import { madeWith, optionWords } from '../../web/src/flight/options_dialog.js';
import { kLayers } from '../../web/src/shared/api.js';
import { loadFlightStrings } from '../../web/src/shared/flight_strings.js';
import { speak } from '../../web/src/shared/language.js';
import { kPhone, mapIdle, reloadMap } from './support/browser.js';
import { photoFiles } from './support/photo_files.js';
import { assertAccessible, options, usePages } from './support/pages.js';

await loadFlightStrings();
const { setUp, setUpReady } = usePages();
const contract = JSON.parse(readFileSync(new URL('../../api/openapi.json', import.meta.url), 'utf8')).components.schemas.JobOptions.properties;

const kArea = /** @type {GeoJSON.Polygon} */ ({ type: 'Polygon', coordinates: [[[7.1, 46.8], [7.2, 46.8], [7.2, 46.9], [7.1, 46.8]]] });

test('the form offers what the contract allows', () => {
  for (const [name, values] of Object.entries(kChoices)) {
    assert.deepEqual(values, contract[name].enum);
    assert.equal(values[0], contract[name].default);
  }
  assert.deepEqual(kLayers, contract.layers.items.enum);
  for (const [field, limits] of Object.entries(kLimits)) {
    const [name, scale] = field === 'resolution_cm' ? ['gsd_m', 100] : [field, 1];
    const { minimum, maximum, default: usual, type } = contract[name];
    assert.deepEqual(limits, { least: minimum * scale, most: maximum * scale, ...(usual === undefined ? {} : { usual }), ...(type === 'integer' ? { is_whole: true } : {}) });
  }
  for (const name of Object.keys(optionsOf({ ...kStandard, resolution_cm: '5', method: 'imu', surface: 'dense', heights: 'dtm', max_look_deg: '50', readout_ms: '30', format: 'webp', quality: '90', origin: '46.95 7.44', takeoff_height_m: '512', boundary: kArea }).options)) assert.ok(name in contract, name);
});

test('what a map was made with is said with the comma of German', () => {
  speak('de');
  assert.equal(optionWords({ gsd_m: 0.025 }), '2,5 cm');
  speak('en');
  assert.equal(optionWords({ gsd_m: 0.025 }), '2.5 cm');
});

test('of what a map was made with nothing is said that belongs to another job', () => {
  const made = (/** @type {object|null} */ job) => madeWith(/** @type {any} */ ({ id: 'f', job }));
  assert.equal(made({ state: 'successful', options: { gsd_m: 0.025, layers: kLayers } }), '2.5 cm');
  assert.equal(made({ state: 'successful', options: { layers: kLayers } }), 'standard');
  // The map that is there was made before these.
  for (const state of ['accepted', 'running', 'failed', 'dismissed']) assert.equal(made({ state, options: { gsd_m: 0.05 } }), null, state);
  assert.equal(made({ state: 'successful', options: { place: 'control', layers: kLayers } }), null, 'it was moved since');
  assert.equal(made({ state: 'successful', options: { import_file: 'a.tif' } }), null, 'others made it');
  assert.equal(made(null), null);
});

test('where nothing is chosen here, the next map is asked for as the last one was', () => {
  const see = (/** @type {object|null} */ options) => seeLastOptions(/** @type {any} */ ({ id: 'seen', job: options && { options } }));
  see(null);
  assert.deepEqual(chosenOptions('seen'), { layers: kLayers });
  const asked = { gsd_m: 0.05, origin: [46.95, 7.44], layers: ['height'] };
  see(asked);
  for (const other of [null, {}, { place: 'control', layers: kLayers }, { import_file: 'a.tif' }]) {
    see(other);
    assert.deepEqual(chosenOptions('seen'), asked);
  }
  assert.deepEqual(chosenOptions('another'), { layers: kLayers });
  chooseOptions('seen', { layers: [] });
  see(asked);
  assert.deepEqual(chosenOptions('seen'), { layers: [] });
});

test('what is chosen for a map is kept in the browser until that is begun', async () => {
  /** @type {Map<string, string>} */
  const kept = new Map();
  const storage = { getItem: (/** @type {string} */ key) => kept.get(key) ?? null, setItem: (/** @type {string} */ key, /** @type {string} */ text) => void kept.set(key, text), removeItem: (/** @type {string} */ key) => void kept.delete(key) };
  Object.defineProperty(globalThis, 'localStorage', { value: storage, configurable: true });
  const asked = { layers: kLayers, gsd_m: 0.05, not_finer_than_photos: true, origin: [46.95, 7.44], boundary: kArea };
  chooseOptions('kept', asked);
  // The page is loaded anew.
  const { chosenOptions: after } = await import(`../../web/src/flight/job_options.js?${Math.random()}`);
  assert.deepEqual(after('kept'), asked);
  assert.deepEqual(after('another'), { layers: kLayers });
  forgetChosen('kept', asked);
  assert.equal(kept.size, 0);
  assert.deepEqual(chosenOptions('kept'), asked, 'as the last one was made');
  chooseOptions('kept', { layers: [] });
  forgetChosen('kept');
  assert.deepEqual(chosenOptions('kept'), asked);
  for (const text of ['', '0', '7', '{"layers":3}', '[']) {
    kept.set('skyquilt.options.odd', text);
    assert.deepEqual(Object.keys(chosenOptions('odd')), ['layers'], text);
  }
  Reflect.deleteProperty(globalThis, 'localStorage');
});

test('what was typed is what is asked for, and comes back into the form', () => {
  const form = { ...kStandard, resolution_cm: '2,5', not_finer: false, method: 'images', surface: 'dense', heights: 'dtm', layers: ['height'], max_look_deg: '55', readout_ms: '0', format: 'webp', quality: '90', origin: '46.95, 7.44', takeoff_height_m: '-3.5', boundary: kArea };
  const { options: asked, faults } = optionsOf(form);
  assert.deepEqual(faults, []);
  assert.deepEqual(asked, { gsd_m: 0.025, not_finer_than_photos: false, method: 'images', surface: 'dense', heights: 'dtm', layers: ['height'], max_look_deg: 55, readout_ms: 0, format: 'webp', quality: 90, origin: [46.95, 7.44], takeoff_height_m: -3.5, boundary: kArea });
  assert.deepEqual(formOf(asked), { ...form, resolution_cm: '2.5' });
  assert.deepEqual(optionsOf(kStandard).options, { layers: kLayers }, 'nothing chosen is nothing asked for');
  for (const preset of Object.values(kPresets)) assert.deepEqual(formOf(optionsOf(preset).options), preset);
  assert.deepEqual(formOf(/** @type {any} */ ({ gsd_m: 'x', method: 7, layers: 'all', origin: {} })), { ...kStandard, layers: [] }, 'what another page kept is not trusted');
});

test('what the server would refuse is said of each field', () => {
  const faults = (/** @type {any} */ change) => optionsOf({ ...kStandard, ...change }).faults;
  for (const [field, values] of Object.entries({ resolution_cm: ['0', 'x', '1e3', '10001', '-2'], max_look_deg: ['9', '76'], readout_ms: ['-1', '501'], quality: ['0', '101', '85.5'], origin: ['46', 'north', '91, 7'], takeoff_height_m: ['-501', '9001', 'high'] })) {
    for (const value of values) assert.deepEqual(faults({ [field]: value }), [field], `${field} ${value}`);
  }
});

test('a resolution beyond reason is told from one that is meant', () => {
  assert.equal(timesCoarser({ gsd_m: 5 }, 0.02), 250);
  for (const [gsd_m, photos_gsd_m] of [[0.4, 0.02], [0.001, 0.02], [5, 0], [undefined, 0.02]]) assert.equal(timesCoarser({ gsd_m }, photos_gsd_m), null);
});

test('so coarse a map is asked about, with both numbers', options, async () => {
  const { page, flight } = await setUpReady('Meadow', { job_ms: 300 });
  await page.click('#processing-details summary');
  await page.click('#run-again');
  assert.deepEqual(await Promise.all(['resolution_cm', 'takeoff_height_m'].map((name) => page.getAttribute(`#option-${name}`, 'inputmode'))), ['decimal', 'text'], 'the keys for numbers have no minus on iPhones');
  await page.fill('#option-resolution_cm', '500');
  await page.click('#options-submit');
  await page.waitForSelector('#coarse-dialog[open]');
  assert.match((await page.textContent('#coarse-dialog')) ?? '', /“Meadow”.*5\sm\/px.*1\.73\scm\/px.*289 times/);
  await assertAccessible(page, 'a question about a coarse map');
  await page.click('#coarse-no');
  assert.equal(flight.job ?? null, null, 'nothing is sent that is not meant');
  assert.ok(await page.isVisible('#options-dialog[open]'), 'the options are still there to be changed');
  await page.click('#options-submit');
  await page.click('#coarse-yes');
  await page.waitForSelector('#options-dialog', { state: 'detached' });
  assert.equal(flight.job.options.gsd_m, 5);
  assert.equal(flight.job.options.any_gsd, true);
});

test('where nothing foretells how fine the photos are, only what no slip of a unit leads to goes unasked', options, async () => {
  const { page, flight } = await setUpReady('Meadow', { job_ms: 300 }, { errors: /503/ });
  await page.route('**/verdict', (route) => route.fulfill({ status: 503, contentType: 'application/problem+json', body: '{"status":503,"code":"unavailable","detail":"busy"}' }));
  for (const [centimetres, is_asked] of /** @type {const} */ ([['50', false], ['500', true]])) {
    await page.locator('#processing-details:not([open]) summary').click({ timeout: 2000 }).catch(() => {});  // open already
    await page.click('#run-again');
    await page.fill('#option-resolution_cm', centimetres);
    await page.click('#options-submit');
    if (is_asked) {
      await page.waitForSelector('#coarse-dialog[open]');
      assert.match((await page.textContent('#coarse-dialog')) ?? '', /5\sm\/px, and nothing tells yet/);
      await page.click('#coarse-yes');
    }
    await page.waitForSelector('#options-dialog', { state: 'detached' });
    assert.equal(flight.job.options.gsd_m, Number(centimetres) / 100);
    assert.equal(flight.job.options.any_gsd, true);
    await page.waitForSelector('#report');
  }
});

test('an area is sent with as many digits as mean anything, or refused', () => {
  const long = { ...kArea, coordinates: [kArea.coordinates[0].map(([lon, lat]) => [lon + 1.23e-12, lat])] };
  assert.deepEqual(jobArea(long), kArea);
  assert.equal(jobArea({ type: 'Polygon', coordinates: [Array.from({ length: 4000 }, (_, i) => [7 + i / 12345.678, 46.8])] }), null);
  const feature = { type: 'Feature', properties: {}, geometry: kArea };
  assert.deepEqual(formOf({ boundary: { type: 'FeatureCollection', features: [feature, feature] } }).boundary, { type: 'MultiPolygon', coordinates: [kArea.coordinates, kArea.coordinates] });
  assert.equal(formOf({ boundary: { type: 'Point', coordinates: [7, 46] } }).boundary, null);
});

test('a map is made again within an area from a file', options, async () => {
  const { page, flight } = await setUpReady('Meadow', { job_ms: 300 });
  await page.click('#processing-details summary');
  await page.click('#run-again');
  await page.waitForSelector('#options-dialog[open]');
  await page.setInputFiles('#option-boundary-file', { name: 'places.geojson', mimeType: 'application/json', buffer: Buffer.from(JSON.stringify({ type: 'Point', coordinates: [7, 46] })) });
  assert.match((await page.textContent('#options-refusal')) ?? '', /places\.geojson: The file has no areas/);
  await page.setInputFiles('#option-boundary-file', { name: 'field.geojson', mimeType: 'application/json', buffer: Buffer.from(JSON.stringify(kArea)) });
  await page.waitForFunction(() => /** @type {HTMLSelectElement} */ (document.querySelector('#option-boundary')).value === '0');
  await page.selectOption('#option-preset', 'quick');
  assert.equal(await page.inputValue('#option-boundary'), '0', 'a preset is not of one place');
  await assertAccessible(page, 'options with an area');
  await page.click('#options-submit');
  await page.waitForSelector('#options-dialog', { state: 'detached' });
  assert.deepEqual(flight.job?.options?.boundary, kArea);
});

for (const [screen, context] of /** @type {const} */ ([['laptop', {}], ['phone', kPhone]])) {
  test(`a map is made again with other options on a ${screen}, and a preset is kept`, options, async () => {
    const { page, flight } = await setUpReady('Meadow', { job_ms: 300 }, { ...context, errors: /422/ });
    await page.click('#processing-details summary');
    assert.doesNotMatch((await page.textContent('#processing-details')) ?? '', /Options/, 'without its job it is not known');
    await page.click('#run-again');
    await page.waitForSelector('#options-dialog[open]');
    assert.ok(await page.locator('label:has(#option-not_finer)').isHidden());
    await page.fill('#option-resolution_cm', '0');
    assert.match((await page.textContent('#option-resolution_cm-fault')) ?? '', /from 0\.1 to 10000/);
    await assertAccessible(page, 'options with a fault');
    await page.click('#options-submit');
    assert.equal(flight.job ?? null, null, 'nothing is sent that would be refused');
    await page.selectOption('#option-preset', 'quick');
    assert.equal(await page.inputValue('#option-resolution_cm'), '20');
    assert.ok(await page.isChecked('#option-not_finer'));
    await page.fill('#option-resolution_cm', '15');
    assert.equal(await page.inputValue('#option-preset'), '');
    await page.fill('#preset-name', 'Orchard');
    await page.click('#preset-keep');
    assert.equal(await page.inputValue('#option-preset'), 'own:Orchard');
    flight.refuses_jobs = { status: 422, detail: 'The option "gsd_m" is not for this flight.' };
    await page.click('#options-submit');
    await page.waitForSelector('#options-refusal');
    assert.match((await page.textContent('#options-refusal')) ?? '', /not for this flight/);
    flight.refuses_jobs = null;
    await page.click('#options-submit');
    await page.waitForSelector('#options-dialog', { state: 'detached' });
    assert.deepEqual(flight.job.options, { layers: [], gsd_m: 0.15, not_finer_than_photos: true });
    await page.waitForFunction(() => document.querySelector('#processing-details')?.textContent?.includes('15 cm'));

    // A reload later the preset is there, until it is deleted.
    await reloadMap(page);
    await page.click('#processing-details summary');
    await page.click('#run-again');
    assert.equal(await page.inputValue('#option-resolution_cm'), '15', 'it begins with what the map was made with');
    await page.selectOption('#option-preset', 'standard');
    assert.equal(await page.inputValue('#option-resolution_cm'), '');
    await page.selectOption('#option-preset', 'own:Orchard');
    assert.equal(await page.inputValue('#option-resolution_cm'), '15');
    await page.click('#preset-forget');
    assert.equal(await page.locator('#option-preset option', { hasText: 'Orchard' }).count(), 0);
    await page.keyboard.press('Escape');
    await page.waitForSelector('#options-dialog', { state: 'detached' });
  });
}

test('options chosen during an upload count for its map', options, async () => {
  const { page, mock } = await setUp({ job_ms: 300 });
  const release = mock.holdUploads();
  await page.setInputFiles('#files-input', photoFiles(4));
  await page.waitForSelector('#upload #options-open');
  await page.click('#options-open');
  await page.click('#options-dialog .option-more summary');
  await page.fill('#option-quality', '95');
  await page.click('#options-submit');
  await page.waitForSelector('#options-dialog', { state: 'detached' });
  assert.match((await page.textContent('#options-chosen')) ?? '', /Image quality 95/);
  release();
  await mapIdle(page);
  assert.equal([...mock.flights.values()][0].job.options.quality, 95);
});
