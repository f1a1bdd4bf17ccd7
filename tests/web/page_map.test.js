// The tools of the map on the page, in Chromium against the mock server.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { addCentres, drag, holdAnswer, mapIdle, openMap, openPhotoCard, reloadMap, savedBy, screenshotPixels, twoFrames, until } from './support/browser.js';
import { allAsked, assertAccessible, options, usePages } from './support/pages.js';

const { setUp, setUpFlight, setUpReady } = usePages();

test('measuring by keyboard gives the true distance', options, async () => {
  const { page } = await setUpReady('Meadow', {}, { locale: 'en-GB' });
  const jump = (lon, lat) => page.evaluate((c) => /** @type {any} */ (window).skyquilt.map.jumpTo({ center: c }), [lon, lat]);
  await page.click('#tool-distance');
  await page.locator('#map canvas').focus();
  await jump(7.4391, 46.9512);
  await page.keyboard.press('Enter');
  await jump(7.4401, 46.9512);
  await page.keyboard.press('Enter');
  // GeographicLib says 76.125 m.
  assert.match(await page.textContent('#measure-result'), /^76\.13\s/);
  await page.click('#tool-area');
  assert.equal(await page.getAttribute('#tool-area', 'aria-pressed'), 'true');
});

test('an area after a distance starts anew, and an outline that crosses itself has none', options, async () => {
  const { page } = await setUpReady('Meadow', {}, { locale: 'en-GB' });
  const points = () => page.evaluate(async () => {
    const data = await /** @type {any} */ (window).skyquilt.map.getSource('measure').getData();
    return data.features.filter((/** @type {any} */ f) => f.geometry.type === 'Point').length;
  });
  const [a, b, c, d] = /** @type {[number, number][]} */ ([[7.4388, 46.951], [7.4396, 46.951], [7.4396, 46.9515], [7.4388, 46.9515]]);
  await page.click('#tool-distance');
  await addCentres(page, [a, c]);
  await page.click('#tool-area');
  assert.equal(await points(), 0);
  await addCentres(page, [a, b, c, d]);
  // GeographicLib: 3385 m2 of the quadrangle.
  assert.match((await page.textContent('#measure-result')) ?? '', /^3,38\d\sm²$/);
  await page.click('text=Clear');
  await addCentres(page, [a, c, b, d]);
  assert.equal(await page.textContent('#measure-result'), '');
  assert.match((await page.textContent('#measure-card')) ?? '', /crosses itself/);
  await assertAccessible(page, 'crossing outline');
  await page.click('#tool-distance');
  assert.equal(await points(), 0);
});

/** What a page was told last has been drawn. @param {any} page */
async function allDrawn(page) {
  await allAsked(page);
  await twoFrames(page);
}

/** A flight's map has these layers, each with its legend. @param {any} page @param {any} mock @param {any} flight @param {string[]} ids */
async function offerLayers(page, mock, flight, ids) {
  const layers = ids.map((id) => ({ id, tilejson: `/tiles/${flight.id}/layers/${id}.json`, legends: `/api/v1/flights/${flight.id}/layers.json?of=${id}` }));
  await page.route(`**/tiles/${flight.id}.json`, async (/** @type {any} */ route) => {
    const tilejson = await (await route.fetch()).json();
    await route.fulfill({ json: { ...tilejson, layers } });
  });
  await page.route(/\/layers\/\w+\.json/, (/** @type {any} */ route) => route.fulfill({ json: { tilejson: '3.0.0', tiles: [`${mock.url}basemap.png?{z}/{x}/{y}`], minzoom: 14, maxzoom: 21, bounds: [7, 46, 8, 47] } }));
}

test('the legends of heights and errors have the units that are chosen', options, async () => {
  const { page, mock, flight } = await setUpFlight('Meadow', {}, { locale: 'en-US' });
  await offerLayers(page, mock, flight, ['height', 'error']);
  await page.route(/layers\.json\?of=error/, (/** @type {any} */ route) => route.fulfill({ json: { error: { stops: [{ error_radius_m: 1, colour: '#2b83ba' }, { error_radius_m: 5, colour: '#d7301f' }] } } }));
  await page.route(/layers\.json\?of=height/, (/** @type {any} */ route) => route.fulfill({ json: { height: { range_m: [100, 304.8] } } }));
  await openMap(page, `${mock.url}#/flights/${flight.id}`);
  await page.click('#tool-layers');
  await page.selectOption('#overlay', 'height');
  await page.waitForSelector('.map-legend .layer-ramp');
  const legend = () => page.textContent('.overlay-choice .map-legend');
  assert.match((await legend()) ?? '', /328\.1\sft1,000\.0\sft/);
  await page.evaluate(async () => (await import(new URL('src/shared/units.js', location.href).href)).keepUnits('metric'));
  assert.match((await legend()) ?? '', /100\.0\sm304\.8\sm/);
  await page.selectOption('#overlay', 'error');
  await page.waitForFunction(() => /^1\.00\sm5\.00\sm$/.test(document.querySelector('.overlay-choice .map-legend')?.textContent ?? ''));
  await page.selectOption('#colour-by', 'error');
  assert.match((await page.textContent('#colour-by + .map-legend')) ?? '', /^0\sm[\d.]+\sc?m/);
  await page.evaluate(async () => (await import(new URL('src/shared/units.js', location.href).href)).keepUnits('imperial'));
  assert.match((await legend()) ?? '', /^3\.28\sft16\.40\sft$/);
  assert.match((await page.textContent('#colour-by + .map-legend')) ?? '', /^0\sft[\d.]+\sft/);
});

test('a layer that fails late changes nothing of the one that was chosen after it', options, async () => {
  const { page, mock, flight } = await setUpFlight('Meadow', {}, { locale: 'en-GB', errors: /status of 500/ });
  await offerLayers(page, mock, flight, ['photo', 'error']);
  const stops = [{ error_radius_m: 0, colour: '#2b83ba' }, { error_radius_m: 5, colour: '#d7301f' }];
  await page.route(/layers\.json\?of=error/, (route) => route.fulfill({ json: { error: { stops } } }));
  /** @type {() => void} */
  let fail = () => {};
  const gate = new Promise((resolve) => { fail = () => resolve(undefined); });
  await page.route(/layers\.json\?of=photo/, async (route) => {
    await gate;
    await route.fulfill({ status: 500, contentType: 'application/problem+json', json: { title: 'Broken', status: 500, detail: 'No legend.' } });
  });
  await openMap(page, `${mock.url}#/flights/${flight.id}`);
  await page.click('#tool-layers');
  const asked = page.waitForRequest(/layers\.json\?of=photo/);
  await page.selectOption('#overlay', 'photo');
  await asked;
  await page.selectOption('#overlay', 'error');
  await page.waitForSelector('.map-legend .layer-ramp');
  const refused = page.waitForResponse(/layers\.json\?of=photo/);
  fail();
  await (await refused).finished();
  await allDrawn(page);
  assert.equal(await page.inputValue('#overlay'), 'error');
  assert.equal(await page.locator('.note-error').count(), 0, 'nobody waits for it');
});

test('a comparison that is left before it is there does not begin', options, async () => {
  const { page, mock } = await setUp();
  const [left, right] = [mock.seedReady('Before'), mock.seedReady('After')];
  await openMap(page, `${mock.url}#/flights/${left.id}`);
  const { isHeld, release } = await holdAnswer(page, `**/tiles/${right.id}.json`);
  const go = (/** @type {string} */ hash) => page.evaluate((to) => { location.hash = to; }, hash);
  await go(`#/flights/${left.id}/compare/${right.id}`);
  await until(isHeld);
  await go(`#/flights/${left.id}`);
  release();
  await allDrawn(page);
  assert.equal(await page.locator('#map-above, #compare-bar').count(), 0);
});

test('photos that were asked for do not come over what was begun meanwhile, and are not called none', options, async () => {
  const { page, flight } = await setUpReady('Meadow');
  const first = await holdAnswer(page, `**/flights/${flight.id}/at?*`);
  await page.locator('#map canvas').focus();
  await page.keyboard.press('Enter');
  await until(first.isHeld);
  await page.keyboard.press('Enter');
  await page.waitForSelector('#photo-card:not([hidden])');
  first.release();
  await allDrawn(page);
  assert.equal(await page.locator('.note').count(), 0);
  await page.keyboard.press('Escape');
  const second = await holdAnswer(page, `**/flights/${flight.id}/at?*`);
  await page.locator('#map canvas').focus();
  await page.keyboard.press('Enter');
  await until(second.isHeld);
  await page.click('#tool-distance');
  second.release();
  await allDrawn(page);
  assert.ok(await page.locator('#photo-card').isHidden());
});

test('settings for other programs are saved and the download sizes are told', options, async () => {
  const { page, mock, flight } = await setUpFlight('Meadow & "brook"');
  await page.goto(`${mock.url}#/flights/${flight.id}`);
  await page.click('#flight-download');
  await page.waitForFunction(() => /4\s*B,/.test(document.querySelector('a.download small')?.textContent ?? ''));
  await page.keyboard.press('Escape');
  const { name, text } = await savedBy(page, 'text=Settings for QGIS');
  assert.equal(name, 'Meadow_brook_.qgis.xml');
  assert.match(text, new RegExp(`name="Meadow &amp; &quot;brook&quot;" url="${mock.url}tiles/${flight.id}/`));
});

test('two flights are compared by swipe and by fade', options, async () => {
  const { page, mock } = await setUp({}, { is_drawn: true });
  const left = mock.seedReady('Before');
  const right = mock.seedReady('After');
  right.place.season = 40;
  await openMap(page, `${mock.url}#/flights/${left.id}`);
  await page.click('#tool-compare');
  await page.click('.choice');
  await mapIdle(page, '#map-above');
  const box = await page.locator('#map').boundingBox();
  const clip = { x: Math.round(box.x + box.width * 0.3), y: Math.round(box.y + box.height * 0.3), width: 60, height: 60 };
  const picture = async () => (await screenshotPixels(page, clip)).at(30, 30).join();
  await page.focus('#compare-slider');
  await page.keyboard.press('End');
  const all_left = await picture();
  await page.keyboard.press('Home');
  const all_right = await picture();
  assert.notEqual(all_left, all_right);
  await page.check('#compare-fade');
  await page.focus('#compare-slider');
  await page.keyboard.press('End');
  assert.equal(await picture(), all_right);
  await assertAccessible(page, 'comparison');
  await page.click('#compare-bar .icon-button');
  await page.waitForSelector('#map-above', { state: 'detached' });
});

test('the flights to compare with go with the flight that they were offered for', options, async () => {
  const { page, mock } = await setUp();
  const [left] = [mock.seedReady('Before'), mock.seedReady('After')];
  await openMap(page, `${mock.url}#/flights/${left.id}`);
  await page.click('#tool-compare');
  await page.waitForSelector('#compare-chooser');
  await page.click('.back-link');
  await page.click('.flight-link:has-text("After")');
  await mapIdle(page);
  assert.equal(await page.locator('#compare-chooser').count(), 0);
});

test('outlines of the land lie below the map until nothing is chosen, and that is remembered', options, async () => {
  const { page, mock, flight } = await setUpFlight('Meadow');
  const layers = () => page.evaluate(() => /** @type {any} */ (window).skyquilt.map.getStyle().layers.map((/** @type {any} */ { id }) => id));
  await openMap(page, `${mock.url}#/flights/${flight.id}`);
  assert.deepEqual((await layers()).slice(0, 3), ['ground', 'basemap-land', 'basemap-coast'], 'below the mosaic');
  await page.click('#tool-layers');
  assert.deepEqual(await page.locator('#basemap option').allTextContents(), ['None', 'Coastlines']);
  await page.selectOption('#basemap', 'none');
  await page.waitForFunction(() => !(/** @type {any} */ (window).skyquilt.map.getLayer('basemap-land')));
  await reloadMap(page);
  assert.ok(!(await layers()).some((/** @type {string} */ id) => id.startsWith('basemap-')));
});

test('the basemap of the server names its makers, and what they wrote is text', options, async () => {
  const makers = 'Makers <b>& "Sons"</b><img src=x onerror=alert(1)>';
  const { page } = await setUpReady('Meadow', { basemap_makers: makers });
  await page.click('#tool-layers');
  await page.selectOption('#basemap', 'server');
  await page.waitForFunction((text) => document.querySelector('#map .maplibregl-ctrl-attrib-inner')?.textContent === text, makers);
  assert.equal(await page.locator('#map .maplibregl-ctrl-attrib-inner *').count(), 0);
  await assertAccessible(page, 'map with a basemap');
  await page.selectOption('#basemap', 'none');
  await page.waitForSelector('#map .maplibregl-ctrl-attrib.maplibregl-attrib-empty', { state: 'hidden' });
});

test('the view is in the address once it was moved, and a reload or a link shows it again', options, async () => {
  const { page, mock, flight } = await setUpReady('Meadow');
  assert.equal(page.url(), `${mock.url}#/flights/${flight.id}`);
  const view = () => page.evaluate(() => {
    const { map } = /** @type {any} */ (window).skyquilt;
    return [map.getZoom(), map.getCenter().lng, map.getCenter().lat];
  });
  const box = await page.locator('#map').boundingBox();
  await drag(page, [box.x + box.width / 2, box.y + box.height / 2], [box.x + box.width / 2 + 180, box.y + box.height / 2 + 60]);
  await page.waitForFunction(() => location.hash.includes('?at='));
  await mapIdle(page);
  const before = await view();
  await reloadMap(page);
  const after = await view();
  before.forEach((value, i) => assert.ok(Math.abs(value - after[i]) < (i === 0 ? 0.01 : 1e-6), `${before} ${after}`));
  await openMap(page, `${mock.url}?x=1#/flights/${flight.id}?token=sq_given&at=12/46.94/7.42`);
  assert.deepEqual((await view()).map((value) => Number(value.toFixed(4))), [12, 7.42, 46.94]);
  assert.ok(!page.url().includes('sq_given'));
});

test('from afar a mark shows where the map is, and a click on it goes there', options, async () => {
  const { page, flight } = await setUpReady('Meadow');
  const marks = () => page.evaluate(() => /** @type {any} */ (window).skyquilt.map.queryRenderedFeatures({ layers: ['place-mark'] }).length);
  assert.equal(await marks(), 0);
  await page.evaluate(() => /** @type {any} */ (window).skyquilt.map.jumpTo({ zoom: 7 }));
  await mapIdle(page);
  assert.equal(await marks(), 1);
  const box = await page.locator('#map').boundingBox();
  const spot = await page.evaluate((p) => /** @type {any} */ (window).skyquilt.map.project(p), [flight.place.lon, flight.place.lat]);
  await page.mouse.click(box.x + spot.x, box.y + spot.y);
  await page.waitForFunction(() => /** @type {any} */ (window).skyquilt.map.getZoom() > 16);
  assert.ok(await page.locator('#photo-card').isHidden());
});

test('a map that a job moves is seen where the page was loaded meanwhile, and where its old place is in the address', options, async () => {
  const { page, mock, flight } = await setUpFlight('Nowhere', { is_unplaced: true, job_ms: 60_000 });
  Object.assign(flight.place, { lon: 0.0004, lat: 0.0003 });
  const old_place = 'at=19.00/0.0003000/0.0004000';
  const is_seen = () => page.evaluate(([lon, lat]) => {
    const { map } = /** @type {any} */ (window).skyquilt;
    return map.getBounds().contains([lon, lat]);
  }, [7.44, 46.95]);
  // Begun in another window; this one is loaded while it runs, once by itself and once where it was moved.
  for (const place of ['', `?${old_place}`]) {
    Object.assign(flight.place, { lon: 0.0004, lat: 0.0003 });
    const body = JSON.stringify({ options: { place: [{ shown: [0.0003, 0.0004], is: [46.95, 7.44] }] } });
    await fetch(`${mock.url}api/v1/flights/${flight.id}/jobs`, { method: 'POST', headers: { 'Content-Type': 'application/json' }, body });
    await page.goto('about:blank');
    await openMap(page, `${mock.url}#/flights/${flight.id}${place}`);
    assert.equal(await page.locator('#job').count(), 1, 'it runs');
    assert.ok(!(await is_seen()), 'until it is there, the map that was is shown');
    flight.job.at -= 60_000;  // and now it ends
    await page.waitForSelector('#job', { state: 'detached' });
    await page.waitForFunction(() => Math.abs(/** @type {any} */ (window).skyquilt.map.getCenter().lng - 7.44) < 0.001);
    await mapIdle(page);
    assert.ok(await is_seen());
    assert.ok(!page.url().includes('at='), page.url());
  }
  await page.goto('about:blank');
  await openMap(page, `${mock.url}#/flights/${flight.id}?${old_place}`);
  assert.ok(await is_seen(), 'a view that has nothing of the map is none');
});

test('the keyboard goes on from a card that is closed: on the map, or where it was opened', options, async () => {
  const { page } = await setUpReady('Meadow');
  const isOnMap = () => page.evaluate(() => document.activeElement?.classList.contains('maplibregl-canvas'));
  await openPhotoCard(page);
  await page.press('#photo-open', 'Escape');
  assert.ok(await isOnMap(), 'after a photo');
  await page.click('#tool-distance');
  await page.press('#measure-card .icon-button', 'Enter');
  assert.ok(await page.locator('#measure-card').isHidden());
  assert.ok(await isOnMap(), 'after measuring');
  await page.click('#tool-compare');
  await page.press('#compare-chooser button', 'Escape');
  assert.equal(await page.locator('#compare-chooser').count(), 0);
  assert.equal(await page.evaluate(() => document.activeElement?.id), 'tool-compare');
});
