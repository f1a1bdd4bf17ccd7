// Placing a map on the page, in Chromium against the mock server: by clicks and typed places, by keyboard, by basemap,
// refused, failed, left, and by who may not.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { drag, kPhone, mapIdle } from '../support/browser.js';
import { assertAccessible, options, usePages } from '../support/pages.js';

const { setUpFlight } = usePages();

/** Opens the map of a flight, and the tool. */
async function openTool({ page, mock }, flight) {
  await page.goto(`${mock.url}#/flights/${flight.id}`);
  await page.waitForSelector('#report');
  await mapIdle(page);
  await page.click('#flight-place, #flight-move');
  await page.waitForSelector('#place-card:not([hidden])');
  await mapIdle(page);
}

/** Clicks the map where it shows a place of the flight. */
async function clickMap(page, flight, east, north) {
  const box = await page.locator('#map').boundingBox();
  const [lon, lat] = [flight.place.lon + east, flight.place.lat + north];
  const spot = await page.evaluate((p) => /** @type {any} */ (window).skyquilt.map.project(p), [lon, lat]);
  await page.mouse.click(box.x + spot.x, box.y + spot.y);
  return [lat, lon];
}

/** What the page asks of the server next. */
const jobAsked = (page) => page.waitForRequest((request) => request.url().endsWith('/jobs') && request.method() === 'POST').then((request) => request.postDataJSON().options.place);

const assertNear = (got, wanted, tolerance) => got.forEach((value, i) => assert.ok(Math.abs(value - wanted[i]) < tolerance, `${got} is not ${wanted}`));

for (const [screen, context] of Object.entries({ laptop: {}, phone: kPhone })) {
  test(`a map that lies nowhere is placed by two points on a ${screen}`, options, async () => {
    const { page, mock, flight } = await setUpFlight('Meadow', { is_whole: true, is_unplaced: true }, context);
    await page.goto(`${mock.url}#/flights/${flight.id}`);
    await page.waitForSelector('#report');
    const verdict = await page.innerText('#result-verdict');
    assert.match(verdict, /^Not georeferenced\./);
    assert.match(verdict, /The scale is a guess.*Which way is north is a guess/s);
    assert.equal(await page.locator('#flight-move').count(), 0);
    await openTool({ page, mock }, flight);
    assert.match(await page.innerText('#place-step'), /Click a feature on the map/);
    await assertAccessible(page, 'beginning of placing');

    const first = await clickMap(page, flight, -0.0006, -0.0004);
    assert.equal(await page.evaluate(() => document.activeElement?.id), 'place-is-1');
    assert.ok(await page.isDisabled('#place-go'));
    await page.keyboard.type('46.8, seven');
    await page.waitForSelector('.place-fault:has-text("not coordinates")');
    assert.equal(await page.getAttribute('#place-is-1', 'aria-invalid'), 'true');
    await assertAccessible(page, 'place that cannot be read');
    await page.fill('#place-is-1', '46°48′00″N 7°06′00″E');
    await page.keyboard.press('Enter');
    assert.equal(await page.locator('.place-said.place-fault').count(), 0);
    assert.match(await page.innerText('#place-card'), /= 46\.8000000, 7\.1000000/);
    assert.match(await page.innerText('#place-step'), /add a second point/);
    assert.ok(await page.isDisabled('#place-go'), 'one point says nothing of size and north');

    // Too near, then far.
    await page.locator('.point-mark-shown').click();
    assert.equal(await page.locator('.place-row').count(), 1, 'a click on a mark is none on the map');
    await clickMap(page, flight, -0.0005, -0.0004);
    assert.match(await page.innerText('#place-hint'), /close together/);
    const second = await clickMap(page, flight, 0.0007, 0.0003);
    assert.equal(await page.locator('.place-row').count(), 2, 'a click before its place is known corrects the point');
    assert.ok(await page.locator('#place-hint').isHidden());
    await page.fill('#place-is-2', '46,8008 7,1016');
    await page.keyboard.press('Enter');
    assert.equal(await page.evaluate(() => document.activeElement?.id), 'place-go');
    assert.match(await page.innerText('#place-effect'), /moves by .* rotates .* is scaled by/);
    await assertAccessible(page, 'two points');

    // Nothing lies over anything else, nor outside of the window.
    const boxes = await Promise.all(['.place-card', '#map-area .tools', '.coordinates', '.panel'].map((name) => page.locator(name).boundingBox()));
    const { width, height } = page.viewportSize();
    boxes.forEach((a, i) => {
      assert.ok(a.x >= 0 && a.y >= 0 && a.x + a.width <= width && a.y + a.height <= height + 1, JSON.stringify(a));
      for (const b of boxes.slice(i + 1)) {
        assert.ok(a.x + a.width <= b.x || b.x + b.width <= a.x || a.y + a.height <= b.y || b.y + b.height <= a.y, JSON.stringify([a, b]));
      }
    });

    const asked = jobAsked(page);
    await page.keyboard.press('Enter');
    const pairs = await asked;
    assert.equal(pairs.length, 2);
    assertNear(pairs[0].shown, first, 2e-5);
    assertNear(pairs[1].shown, second, 2e-5);
    assertNear(pairs[0].is, [46.8, 7.1], 1e-9);
    assertNear(pairs[1].is, [46.8008, 7.1016], 1e-9);
    await page.waitForSelector('#job-heading:has-text("Moving the map")');
    assert.ok(await page.locator('#place-card').isHidden());
    await page.waitForSelector('#flight-move', { state: 'attached' });
    await page.waitForFunction(([lat, lon]) => {
      const { lat: at_lat, lng } = /** @type {any} */ (window).skyquilt.map.getCenter();
      return Math.abs(at_lat - lat) < 0.002 && Math.abs(lng - lon) < 0.002;
    }, [flight.place.lat, flight.place.lon]);
    assert.ok(Math.abs(flight.place.lat - 46.8) < 0.01, 'the mock has moved it');
    assert.equal(await page.locator('.point-mark').count(), 0);
    assert.doesNotMatch(await page.innerText('#result-verdict'), /Not georeferenced/);
  });
}

test('points are dragged, moved by arrow keys and removed, and are there again after Escape', options, async () => {
  const { page, mock, flight } = await setUpFlight('Meadow', { is_whole: true }, { locale: 'en-US' });
  await openTool({ page, mock }, flight);
  await page.keyboard.press('Enter');  // the map has the focus: its centre
  await page.keyboard.type('46.8, 7.1');
  await page.keyboard.press('Enter');
  assert.match(await page.innerText('#place-step'), /One point shifts the map/);
  assert.match(await page.innerText('#place-effect'), /^The map moves by 19\.\d+\smi\.$/);
  const mark = page.locator('.point-mark-shown');
  const at = async () => (await mark.boundingBox());
  const before = await at();
  await mark.focus();
  await page.keyboard.press('Shift+ArrowRight');
  await page.keyboard.press('ArrowDown');
  const keyed = await at();
  assertNear([keyed.x - before.x, keyed.y - before.y], [10, 1], 0.6);
  await drag(page, [keyed.x + 14, keyed.y + 14], [keyed.x + 74, keyed.y - 26]);
  const dragged = await at();
  assertNear([dragged.x - keyed.x, dragged.y - keyed.y], [60, -40], 1.5);
  assert.equal(await page.locator('.place-row').count(), 1, 'the end of dragging is no click');
  await page.locator('#map canvas').focus();
  await page.keyboard.press('Escape');
  assert.ok(await page.locator('#place-card').isHidden());
  assert.equal(await page.locator('.point-mark').count(), 0);
  assert.equal(await page.evaluate(() => document.activeElement?.id), 'flight-move', 'the focus goes back');
  await page.keyboard.press('Enter');
  await page.waitForSelector('#place-card:not([hidden])');
  assert.equal(await page.inputValue('#place-is-1'), '46.8, 7.1');
  assertNear([(await at()).x], [dragged.x], 1.5);
  await page.evaluate(() => document.getElementById('flight-move')?.setAttribute('data-before', ''));  // the map goes with its button
  const box = await page.locator('#map').boundingBox();
  const tip = await page.evaluate((p) => /** @type {any} */ (window).skyquilt.map.unproject(p), [dragged.x + 14 - box.x, dragged.y + 42 - box.y]);
  const asked = jobAsked(page);
  await page.click('#place-go');
  assertNear((await asked)[0].shown, [tip.lat, tip.lng], 1e-5);
  await page.click('#flight-move:not([data-before])');
  assert.equal(await page.locator('.place-row').count(), 0, 'points on the map before are gone');
  await page.click('#place-centre');
  await page.click('[aria-label="Remove point 1"]');
  assert.equal(await page.locator('.place-row, .point-mark').count(), 0);
  await page.click('#tool-distance');
  assert.ok(await page.locator('#place-card').isHidden(), 'one tool at a time');
});

test('what the server refuses is told in its words, and the points can be changed after a failure', options, async () => {
  const { page, mock, flight } = await setUpFlight('Meadow', { is_whole: true }, { errors: /409/ });
  flight.refuses_jobs = { status: 409, detail: 'A job of this flight is under way. Wait for it.' };
  await openTool({ page, mock }, flight);
  await page.click('#place-centre');
  await page.fill('#place-is-1', '46.8, 7.1');
  await page.click('#place-go');
  await page.waitForSelector('#place-failure:has-text("under way. Wait for it.")');
  await assertAccessible(page, 'refused placing');
  flight.refuses_jobs = null;
  flight.contradicts_pairs = true;
  await page.click('#place-go');
  await page.waitForSelector('#failure');
  assert.match(await page.innerText('#failure'), /The map could not be moved/);
  assert.equal(await page.locator('#start-job').count(), 0, 'nothing offers to make the map anew');
  // Also for who has looked at something else meanwhile.
  await page.click('.back-link');
  await page.click('.flights a:has-text("Meadow")');
  await page.waitForSelector('#report');
  await page.click('#place-again');
  assert.equal(await page.inputValue('#place-is-1'), '46.8, 7.1');
  await page.reload();
  await page.waitForSelector('#place-again');
  assert.match(await page.innerText('#failure'), /The map could not be moved/);
});

test('a true place is clicked on the basemap, through the map or near the points before', options, async () => {
  for (const is_unplaced of [false, true]) {
    const { page, mock, flight } = await setUpFlight('Meadow', { is_whole: true, is_unplaced, basemap_makers: 'Makers' });
    await openTool({ page, mock }, flight);
    await clickMap(page, flight, -0.0005, -0.0003);
    if (is_unplaced) {
      assert.ok(await page.locator('#place-basemap').isHidden(), 'nobody knows where to look');
      await page.fill('#place-is-1', '46.8, 7.1');
      await page.keyboard.press('Enter');
      await clickMap(page, flight, 0.0005, 0.0003);
    }
    const camera = () => page.evaluate(() => /** @type {any} */ (window).skyquilt.map.getCenter().toArray());
    const before = await camera();
    await page.click('#place-basemap');
    await page.waitForFunction(() => Boolean(/** @type {any} */ (window).skyquilt.map.getLayer('basemap-tiles')));
    const paint = () => page.evaluate(() => {
      const { map } = /** @type {any} */ (window).skyquilt;
      return map.getPaintProperty(map.getStyle().layers.find((/** @type {any} */ { id }) => id.startsWith('mosaic')).id, 'raster-opacity');
    });
    assert.ok((await paint()) < 0.5);
    assertNear(await camera(), is_unplaced ? [7.1, 46.8] : before, 1e-5);
    const box = await page.locator('#map').boundingBox();
    const spot = [box.width * 0.7, box.height * 0.7];
    const wanted = await page.evaluate((p) => /** @type {any} */ (window).skyquilt.map.unproject(p), spot);
    await page.mouse.click(box.x + spot[0], box.y + spot[1]);
    const [lat, lon] = (await page.inputValue(`#place-is-${is_unplaced ? 2 : 1}`)).split(', ').map(Number);
    assertNear([lat, lon], [wanted.lat, wanted.lng], 2e-5);
    assert.equal(await paint(), 1);
    assertNear(await camera(), before, 1e-5);
    assert.ok(await page.isEnabled('#place-go'));
    await assertAccessible(page, 'place from the basemap');
  }
});

test('who may not change a flight is not offered to move it', options, async () => {
  for (const is_unplaced of [false, true]) {
    const { page, mock, flight } = await setUpFlight('Meadow', { is_whole: true, is_unplaced });
    flight.may_change = false;
    await page.goto(`${mock.url}#/flights/${flight.id}`);
    await page.waitForSelector('#report');
    assert.equal(await page.locator('#flight-place, #flight-move').count(), 0);
    assert.equal(/Not georeferenced/.test(await page.innerText('#result-verdict')), is_unplaced);
    await mapIdle(page);
  }
});
