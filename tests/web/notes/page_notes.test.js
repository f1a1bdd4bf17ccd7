// Notes and measurements that are kept with a flight, in Chromium against the mock server: written, seen by others, deleted
// and brought back, saved as files, and never lost, whoever else writes and however often the server is away.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { measurementsGeoJson, measurementsGpx, measurementsKml } from '../../../web/src/map/measurement_files.js';
import { rebased, withChanges } from '../../../web/src/notes/note_merge.js';
import { withRoom } from '../../../web/src/notes/note_labels.js';
import { boundsOfNote, labelPlace, measurementOfNote, noteOf } from '../../../web/src/notes/note_shape.js';
import { addCentres, mapIdle, openMap, savedBy, twoFrames } from '../support/browser.js';
import { allAsked, assertAccessible, options, usePages } from '../support/pages.js';

const { setUpFlight } = usePages();

const pointAt = (/** @type {string} */ id, /** @type {string} */ name, text = '') => noteOf(name, text, { type: 'Point', coordinates: [7.4391, 46.9512] }, id);
const copy = (/** @type {string} */ name) => `${name} (mine)`;
const change = (next, base) => ({ next, base: base ? JSON.stringify(base) : '' });

test('changes go on top of what the server has, and where two changed one note there are two', () => {
  const [a, b, c] = [pointAt('a', 'A'), pointAt('b', 'B'), pointAt('c', 'C')];
  const renamed = pointAt('a', 'A2');
  assert.deepEqual(withChanges([a, b], new Map([['a', change(renamed, a)], ['b', change(null, b)], ['c', change(c, null)]])), [renamed, c]);
  // Nobody else touched it: it goes on.
  assert.deepEqual(rebased([a, c], new Map([['a', change(renamed, a)]]), copy), { changes: new Map([['a', change(renamed, a)]]), conflicts: 0 });
  // The server has it already, an answer was lost.
  assert.equal(rebased([renamed], new Map([['a', change(renamed, a)]]), copy).changes.size, 0);
  // Both changed it.
  const both = rebased([pointAt('a', 'Theirs')], new Map([['a', change(renamed, a)]]), copy);
  assert.equal(both.conflicts, 1);
  assert.deepEqual(withChanges([pointAt('a', 'Theirs')], both.changes).map(({ properties }) => properties.name), ['Theirs', 'A2 (mine)']);
  // Deleted here, changed by another: it stays. Changed here, deleted by another: it comes back.
  assert.deepEqual(withChanges([renamed], rebased([renamed], new Map([['a', change(null, a)]]), copy).changes), [renamed]);
  assert.deepEqual(withChanges([], rebased([], new Map([['a', change(renamed, a)]]), copy).changes), [renamed]);
  // Both deleted it.
  assert.deepEqual(rebased([], new Map([['a', change(null, a)]]), copy), { changes: new Map(), conflicts: 0 });
});

test('notes are files that other programs open, with their words', () => {
  const line = noteOf('Fence <1>', '', { type: 'LineString', coordinates: [[7.4391, 46.9512], [7.4401, 46.9512]] });
  const ring = [[7.4, 46.9], [7.41, 46.9], [7.41, 46.91], [7.4, 46.9]];
  const area = noteOf('Pond', '', { type: 'Polygon', coordinates: [ring] });
  const all = [line, area, pointAt('w', 'Well', 'Cover & lid\nloose')].map(measurementOfNote);
  assert.ok(Math.abs(all[0].length_m - 76.125) < 0.01, 'GeographicLib says 76.125 m');
  assert.equal(all[1].places.length, 3);
  const { features } = JSON.parse(measurementsGeoJson(all));
  assert.deepEqual(features.map(({ geometry }) => geometry.type), ['LineString', 'Polygon', 'Point']);
  assert.deepEqual(features[2].properties, { name: 'Well', text: 'Cover & lid\nloose' });
  const kml = measurementsKml(all);
  assert.equal(kml.match(/<Placemark>/g)?.length, 3);
  assert.match(kml, /<name>Well<\/name>\s*<description>Cover &amp; lid\nloose<\/description>\s*<Point><coordinates>7\.4391,46\.9512<\/coordinates><\/Point>/);
  const gpx = measurementsGpx(all);
  assert.match(gpx, /<wpt lat="46\.9512" lon="7\.4391">[^]*<desc>Cover &amp; lid[^]*<\/wpt>\s*<trk>[^]*Fence &lt;1&gt;/, 'waypoints before tracks');
  assert.deepEqual(boundsOfNote(area), [7.4, 46.9, 7.41, 46.91]);
  assert.deepEqual(labelPlace(line), [7.4391, 46.9512]);
});

test('of names that would overlap the first is shown', () => {
  const box = (/** @type {number} */ x, /** @type {number} */ y) => ({ x, y, width: 50, height: 20 });
  assert.deepEqual(withRoom([box(0, 0), box(40, 10), box(80, 20), box(50, 0), box(0, 20)]), [true, false, true, true, true]);
  assert.deepEqual(withRoom([]), []);
});

/** A flight with these notes, opened; open() opens it once more. @param {object} [context] @param {object[]} [features] */
async function openNotes(context = { locale: 'en-GB' }, features = []) {
  const { page, mock, flight } = await setUpFlight('Meadow', {}, context);
  if (features.length > 0) flight.notes = { features, number: 1 };
  const open = async () => {
    await page.goto('about:blank');
    await openMap(page, `${mock.url}#/flights/${flight.id}`);
    await page.waitForSelector('#notes', { state: 'attached' });
  };
  await open();
  return { page, flight, open };
}
const isSaved = (page) => page.waitForSelector('#notes-state[data-state="saved"]');
const names = (page) => page.locator('#note-list .note-show').allTextContents();
const kept = (flight) => flight.notes.features.map(({ properties }) => properties.name);

async function write(page, name, text = '') {
  await page.click('#note-add');
  await page.fill('#note-name', name);
  await page.fill('#note-text', text);
  await page.click('#note-save');
}

test('a note is written where one clicks, changed, deleted, brought back, and others see it', options, async () => {
  const { page, flight, open } = await openNotes();
  await page.click('#note-add');
  await page.fill('#note-name', '  Well ');
  await page.fill('#note-text', 'Cover is loose.\nTold to the farmer.');
  const box = await page.locator('#map').boundingBox();
  await page.mouse.click(box.x + box.width / 2 + 60, box.y + box.height / 2 - 40);
  const clicked = await page.evaluate(([x, y]) => /** @type {any} */ (window).skyquilt.map.unproject([x, y]).toArray(), [box.width / 2 + 60, box.height / 2 - 40]);
  assert.equal(await page.locator('.photo-card:visible').count(), 0, 'the click is for the note');
  await assertAccessible(page, 'form of a note');
  await page.click('#note-save');
  await isSaved(page);
  const [note] = flight.notes.features;
  assert.deepEqual(note.properties, { name: 'Well', text: 'Cover is loose.\nTold to the farmer.' });
  note.geometry.coordinates.forEach((degrees, i) => assert.ok(Math.abs(degrees - clicked[i]) < 1e-6, `${note.geometry.coordinates} ${clicked}`));
  assert.equal(await page.locator('.note-mark').textContent(), 'Well');
  await assertAccessible(page, 'list of notes');

  await page.click('.note-edit');
  await page.fill('#note-name', 'Old well');
  await page.click('#note-save');
  await page.waitForFunction(() => document.querySelector('.note-mark')?.textContent === 'Old well');
  await isSaved(page);
  assert.deepEqual(kept(flight), ['Old well']);
  await page.click('.note-remove');
  await page.waitForFunction(() => !document.querySelector('.note-mark'));
  await isSaved(page);
  assert.deepEqual(kept(flight), []);
  await page.click('.note-action');
  await isSaved(page);
  await page.waitForSelector('.note-mark');
  assert.deepEqual(flight.notes.features[0].properties.text, note.properties.text);

  // Who opens it anew sees it; who may not write is offered nothing that writes.
  flight.may_change = false;
  await open();
  await page.waitForSelector('.note-mark');
  assert.deepEqual(await names(page), ['Old well']);
  assert.equal(await page.locator('#note-add, .note-edit, .note-remove').count(), 0);
  await page.click('.note-mark');
  assert.equal(await page.evaluate(() => document.activeElement?.className.includes('note-show')), true);
  flight.notes = { features: [], number: 0 };
  const answered = page.waitForResponse('**/notes').then((response) => response.finished());
  await open();
  await answered;
  assert.equal(await page.locator('#notes').isVisible(), false, 'nothing to see, nothing to do');
});

test('a measurement is kept with the flight, with its figure in the list, and saved with the others', options, async () => {
  const { page, flight } = await openNotes({ locale: 'en-GB', acceptDownloads: true });
  await page.click('#tool-distance');
  assert.equal(await page.locator('#measure-keep').isVisible(), false);
  await addCentres(page, [[7.4391, 46.9512], [7.4401, 46.9512]]);
  await page.click('#measure-keep');
  await isSaved(page);
  assert.equal(await page.locator('#measure-card').isVisible(), false);
  assert.match((await page.textContent('.note-figure')) ?? '', /^76\.1\d?\s*m/);
  await page.click('#tool-area');
  await addCentres(page, [[7.4388, 46.951], [7.4396, 46.951], [7.4396, 46.9515], [7.4388, 46.9515]]);
  await page.click('#measure-keep');
  await page.waitForFunction(() => document.querySelectorAll('#note-list li').length === 2);
  await isSaved(page);
  assert.deepEqual(flight.notes.features.map(({ geometry }) => geometry.type), ['LineString', 'Polygon']);
  const ring = flight.notes.features[1].geometry.coordinates[0];
  assert.deepEqual(ring[0], ring.at(-1));
  const file = await savedBy(page, '#notes-kml');
  assert.equal(file.name, 'notes.kml');
  assert.equal(file.text.match(/<Placemark>/g)?.length, 2);
  // Editing a line leaves it where it is.
  await page.click('.note-edit >> nth=0');
  await page.fill('#note-name', 'Fence');
  await page.click('#note-save');
  await page.waitForFunction(() => document.querySelector('.note-show')?.textContent === 'Fence');
  await isSaved(page);
  assert.equal(flight.notes.features[0].geometry.coordinates.length, 2);
});

test('of two who write at the same time nobody loses anything, and is told', options, async () => {
  const { page, flight } = await openNotes({ locale: 'en-GB', errors: /status of 412/ }, [pointAt('a', 'Well'), pointAt('b', 'Gate')]);
  await page.waitForSelector('#note-list li');
  // Another adds one and renames one.
  flight.notes = { features: [pointAt('a', 'Dry well'), pointAt('b', 'Gate'), pointAt('c', 'Tree')], number: 2 };
  await write(page, 'Stone');
  await page.waitForFunction(() => document.querySelectorAll('#note-list li').length === 4);
  await isSaved(page);
  assert.deepEqual(kept(flight).sort(), ['Dry well', 'Gate', 'Stone', 'Tree']);
  // And both rename the same.
  flight.notes = { features: flight.notes.features.map((note) => (note.id === 'b' ? pointAt('b', 'North gate') : note)), number: 4 };
  await page.click('[data-note="b"] .note-edit');
  await page.fill('#note-name', 'Iron gate');
  await page.click('#note-save');
  await page.waitForSelector('.note-text:has-text("Both versions")');
  await isSaved(page);
  assert.deepEqual(kept(flight).sort(), ['Dry well', 'Iron gate (my version)', 'North gate', 'Stone', 'Tree']);
  assert.deepEqual((await names(page)).sort(), kept(flight).sort());
});

test('a note is deleted by a click that begins before others are saved and ends after that', options, async () => {
  const { page } = await openNotes(undefined, [pointAt('a', 'Well')]);
  await page.waitForSelector('#note-list li');
  /** @type {() => void} */
  let release = () => {};
  const gate = new Promise((resolve) => { release = () => resolve(undefined); });
  await page.route('**/notes', async (route) => {
    if (route.request().method() === 'PUT') await gate;
    await route.continue().catch(() => {});
  });
  await write(page, 'Gate');
  await page.waitForSelector('#notes-state[data-state="saving"]');
  await page.hover('[data-note="a"] .note-remove');
  await page.mouse.down();
  release();
  await isSaved(page);
  await page.mouse.up();
  await page.waitForSelector('[data-note="a"]', { state: 'detached' });
  assert.deepEqual(await names(page), ['Gate']);
});

test('without the server notes wait in this browser, through a reload, and are said to', options, async () => {
  const { page, flight, open } = await openNotes({ locale: 'en-GB', errors: /ERR_FAILED|status of 422/ });
  await page.route('**/notes', (route) => (route.request().method() === 'PUT' ? route.abort() : route.continue()));
  await write(page, 'Well', 'Deep.');
  await page.waitForSelector('#notes-state[data-state="waiting"]');
  assert.match((await page.textContent('#notes-state')) ?? '', /Kept in this browser/);
  assert.equal(flight.notes.features.length, 0);
  await open();
  await page.waitForSelector('#note-list li');
  assert.deepEqual(await names(page), ['Well']);
  await page.unroute('**/notes');
  await page.evaluate(() => dispatchEvent(new Event('online')));
  await isSaved(page);
  assert.deepEqual(kept(flight), ['Well']);
  assert.equal(await page.evaluate(() => Object.keys(localStorage).filter((key) => key.startsWith('skyquilt.notes')).length), 0);
  // What the server will not take stays too, and can be sent again.
  flight.refuses_notes = { status: 422, detail: 'There are more than 2000 notes.' };
  await write(page, 'Gate');
  await page.waitForSelector('#notes-retry');
  assert.match((await page.textContent('#notes-state')) ?? '', /more than 2000 notes/);
  await assertAccessible(page, 'notes that were refused');
  flight.refuses_notes = null;
  await page.click('#notes-retry');
  await isSaved(page);
  assert.deepEqual(kept(flight), ['Well', 'Gate']);
});

test('who measures while a note is being written has the clicks for that', options, async () => {
  const { page } = await openNotes();
  await page.click('#note-add');
  const pin = () => page.locator('.note-pin').boundingBox();
  const [before, box] = [await pin(), await page.locator('#map').boundingBox()];
  const click = (/** @type {number} */ x) => page.mouse.click(box.x + box.width / 2 + x, box.y + box.height / 2 - 60);
  await page.click('#tool-distance');
  await click(-80);
  await click(80);
  await page.waitForFunction(() => document.querySelectorAll('.measure-point').length === 2);
  assert.deepEqual(await pin(), before);
  await page.click('#tool-distance');
  await click(20);
  assert.notDeepEqual(await pin(), before, 'and for the note after it');
});

test('a token that ended while a note is saved is asked for, and the note goes with the next one', options, async () => {
  const { page, flight } = await openNotes({ locale: 'en-GB', errors: /status of 401/ });
  await page.route('**/notes', (route) => {
    const is_refused = route.request().method() === 'PUT' && route.request().headers().authorization !== 'Bearer sq_next';
    return is_refused ? route.fulfill({ status: 401, contentType: 'application/problem+json', json: { title: 'Unauthorized', status: 401, code: 'unauthorized' } }) : route.continue();
  });
  await page.evaluate(() => document.body.setAttribute('data-stays', ''));
  await write(page, 'Well');
  await page.fill('#token-input', 'sq_next');
  await page.press('#token-input', 'Enter');
  await isSaved(page);
  assert.deepEqual(kept(flight), ['Well']);
  assert.equal(await page.locator('body[data-stays]').count(), 1, 'the page is not loaded anew, which would lose what cannot be kept');
});

test('a name that is no markup stays text, one that is too long is refused, and German has its words', options, async () => {
  const { page, flight } = await openNotes({ locale: 'de-DE', viewport: { width: 390, height: 844 } });
  assert.match((await page.textContent('#notes summary')) ?? '', /Notizen und Messungen/);
  await page.locator('#sheet-handle').click();
  await page.locator('#sheet-handle').click();
  await write(page, '<img src=x onerror=alert(1)>', '<b>fett</b>');
  await isSaved(page);
  assert.equal(await page.locator('#notes img, #map img, #notes b').count(), 0);
  assert.equal(await page.locator('.note-mark').textContent(), '<img src=x onerror=alert(1)>');
  await page.locator('#note-add').click();
  await page.fill('#note-name', 'ü'.repeat(150));
  await page.click('#note-save');
  assert.equal(await page.$eval('#note-name', (input) => /** @type {HTMLInputElement} */ (input).validationMessage), 'Das ist zu lang.');
  await page.fill('#note-name', '   ');
  await page.click('#note-save');
  assert.equal(flight.notes.features.length, 1);
  await page.keyboard.press('Escape');
  assert.equal(await page.locator('#note-form').count(), 0);
  await page.$eval('#notes', (notes) => notes.scrollIntoView({ block: 'start' }));
  await assertAccessible(page, 'German notes on a phone');
});

test('names on the map do not overlap: the later one comes when one zooms in, and is in the list all along', options, async () => {
  const near = noteOf('Gate that is always open', '', { type: 'Point', coordinates: [7.43915, 46.95122] }, 'b');
  const { page } = await openNotes(undefined, [pointAt('a', 'Well at the old mill'), near]);
  await page.waitForSelector('.note-mark');
  const shown = () => page.locator('.note-mark:visible').allTextContents();
  assert.deepEqual(await shown(), ['Well at the old mill']);
  assert.equal(await page.locator('#note-list li').count(), 2);
  await page.evaluate(() => /** @type {any} */ (window).skyquilt.map.jumpTo({ center: [7.43912, 46.95121], zoom: 23 }));
  await page.waitForFunction(() => document.querySelectorAll('.note-mark:not([hidden])').length === 2);
});

test('a note that is being written stays where another is deleted, and where a new map comes', options, async () => {
  const { page, flight } = await openNotes({ locale: 'en-GB' }, [pointAt('a', 'Well'), pointAt('b', 'Gate')]);
  await page.waitForSelector('#note-list li');
  await page.click('#note-add');
  await page.fill('#note-name', 'Half a thought');
  await page.click('[data-note="a"] .note-remove');
  await page.waitForFunction(() => document.querySelectorAll('#note-list li').length === 1);
  assert.equal(await page.inputValue('#note-name'), 'Half a thought');
  await page.click('#processing-details summary');
  await page.click('#run-again');
  await page.click('#options-submit');
  await page.waitForSelector('#options-dialog', { state: 'detached' });
  await page.focus('#note-name');
  await page.waitForFunction(() => JSON.stringify(/** @type {any} */ (window).skyquilt.map.getStyle().sources).includes('rev=2'));
  await mapIdle(page);
  await allAsked(page);
  await twoFrames(page);
  assert.equal(await page.inputValue('#note-name'), 'Half a thought');
  assert.equal(await page.evaluate(() => document.activeElement?.id), 'note-name');
  await page.click('#note-save');
  await isSaved(page);
  assert.deepEqual(kept(flight), ['Gate', 'Half a thought']);
});

test('a note that is half written when its flight is left is there again, and the page is not closed without a question', options, async () => {
  const { page, flight } = await openNotes({ locale: 'en-GB' }, [pointAt('a', 'Well')]);
  const asks = () => page.evaluate(() => {
    const event = new Event('beforeunload', { cancelable: true });
    dispatchEvent(event);
    return event.defaultPrevented;
  });
  const leaveAndReturn = async () => {
    await page.click('.back-link');
    await page.click('.flight-link');
    await mapIdle(page);
    await page.waitForSelector('#note-list li');
  };
  await page.click('#note-add');
  assert.equal(await asks(), false, 'nothing is written yet');
  await page.fill('#note-name', 'Gate');
  await page.fill('#note-text', 'Half a thought');
  const box = await page.locator('#map').boundingBox();
  await page.mouse.click(box.x + box.width / 2 + 60, box.y + box.height / 2 - 40);
  const place = await page.evaluate(([x, y]) => /** @type {any} */ (window).skyquilt.map.unproject([x, y]).toArray(), [box.width / 2 + 60, box.height / 2 - 40]);
  assert.equal(await asks(), true);
  await leaveAndReturn();
  await page.waitForSelector('#note-form');
  assert.deepEqual([await page.inputValue('#note-name'), await page.inputValue('#note-text'), await asks()], ['Gate', 'Half a thought', true]);
  await page.click('#note-save');
  await isSaved(page);
  assert.deepEqual(kept(flight), ['Well', 'Gate']);
  flight.notes.features[1].geometry.coordinates.forEach((degrees, i) => assert.ok(Math.abs(degrees - place[i]) < 1e-6));
  assert.equal(await asks(), false);

  // One that is there already stays the same note; what was cancelled does not come back.
  await page.click('[data-note="a"] .note-edit');
  await page.fill('#note-name', 'Old well');
  await leaveAndReturn();
  await page.waitForSelector('#note-form');
  await page.click('#note-save');
  await isSaved(page);
  assert.deepEqual(kept(flight), ['Old well', 'Gate']);
  await page.click('[data-note="a"] .note-edit');
  await page.fill('#note-name', 'Never');
  await page.press('#note-name', 'Escape');
  await leaveAndReturn();
  await twoFrames(page);
  assert.deepEqual([await page.locator('#note-form').count(), await asks()], [0, false]);
});
