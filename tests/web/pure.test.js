// The page's arithmetic against independent truth: geodesy against GeographicLib, UTM against published values, the
// upload queue against a sender that fails.
import assert from 'node:assert/strict';
import { File } from 'node:buffer';
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { test } from 'node:test';
import { formatCoordinates, utm, utmZone, wrapLongitude } from '../../web/src/map/coordinates.js';
import { tilesIn, zoomOfFew } from '../../web/src/map/tile_addresses.js';
import { geodesicLength, isInside, pathLength, polygonArea } from '../../web/src/map/geodesy.js';
import { answerOf, ApiError } from '../../web/src/shared/api.js';
import { byClockOf, clipName, formatArea, formatBytes, formatCaptureDay, formatCaptureTime, formatDistance, formatDuration, formatError, formatGsd, formatLength, keepUnits } from '../../web/src/shared/format.js';
import { at, baseOf, parseRoute, routeHash } from '../../web/src/shared/router.js';
import { looksLikePhoto, namesApart, selectFiles } from '../../web/src/upload/drop_files.js';
import { coverageGrid, errorWords, histogram } from '../../web/src/flight/report_pictures.js';
import { absoluteWords, accuracyMark, flightFacts, isScaleKnown, relativeWords, shortFacts, statusWords } from '../../web/src/flight/flight_words.js';
import { keptElements } from '../../web/src/shared/dom.js';
import { recordFacts } from '../../web/src/flight/photo_card.js';
import { hasScale, isGuessed, resultWords } from '../../web/src/flight/result_verdict.js';
import { errorsOf, kUnknownErrorColour, photoColour } from '../../web/src/map/map_style.js';
import { crossesItself } from '../../web/src/map/ring_crossing.js';
import { hashWithPlace, placeOfHash } from '../../web/src/map/view_address.js';
import { nearestIn, squareOf } from '../../web/src/upload/nearest_place.js';
import { UploadQueue } from '../../web/src/upload/upload_queue.js';
import { loadFlightStrings } from '../../web/src/shared/flight_strings.js';
import { web_root } from './support/mock_server.js';

await loadFlightStrings();
keepUnits('metric');  // newer versions of Node speak American English

/** Repeatable numbers in 0..1. */
function random(seed) {
  let state = seed >>> 0;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 4294967296;
  };
}

let geodesic = null;
try {
  geodesic = createRequire(`${web_root}/package.json`)('geographiclib-geodesic').Geodesic.WGS84;
} catch {
  geodesic = null;
}
const needs_geographiclib = { skip: geodesic ? false : 'web/node_modules is missing (npm ci in web/)' };

test('lengths agree with GeographicLib to a millimetre from centimetres to 50 km', needs_geographiclib, () => {
  const next = random(1);
  for (let i = 0; i < 500; i += 1) {
    const lat = next() * 160 - 80;
    const lon = next() * 360 - 180;
    const span = 10 ** (next() * 6.5 - 7);
    const to = [lon + (next() - 0.5) * span, Math.max(-89, Math.min(89, lat + (next() - 0.5) * span))];
    const truth = geodesic.Inverse(lat, lon, to[1], to[0]).s12;
    assert.ok(Math.abs(geodesicLength([lon, lat], to) - truth) < 1e-3, `${lat} ${lon} ${to}: ${truth}`);
  }
});

test('areas agree with GeographicLib to 0.001 % up to 50 km', needs_geographiclib, () => {
  const next = random(2);
  for (let i = 0; i < 300; i += 1) {
    const lat = next() * 140 - 70;
    const lon = next() * 360 - 180;
    const radius_deg = 10 ** (next() * 3.3 - 4) * 0.2;
    const corners = 3 + Math.floor(next() * 8);
    const ring = Array.from({ length: corners }, (_, k) => {
      const angle = (2 * Math.PI * (k + next() * 0.7)) / corners;
      return [wrapLongitude(lon + (radius_deg * Math.cos(angle)) / Math.cos((lat * Math.PI) / 180)), lat + radius_deg * Math.sin(angle)];
    });
    const polygon = geodesic.Polygon(false);
    for (const [x, y] of ring) polygon.AddPoint(y, x);
    const truth = Math.abs(polygon.Compute(false, true).area);
    assert.ok(Math.abs(polygonArea(ring) / truth - 1) < 1e-5, `at ${lat}, ${radius_deg} deg: ${polygonArea(ring)} against ${truth}`);
  }
});

test('a path across the date line is short', () => {
  assert.ok(Math.abs(pathLength([[179.9999, 0], [-179.9999, 0]]) - 22.264) < 0.01);
});

test('UTM follows the ellipsoid and the zone exceptions', () => {
  // Equator, 3 degrees east of the central meridian: k0 * a * (projected longitude), the well-known zone edge.
  const edge = utm(0, 0);
  assert.equal(edge.zone, 31);
  assert.ok(Math.abs(edge.easting_m - 166021.443) < 0.001);
  assert.ok(Math.abs(edge.northing_m) < 1e-6);
  const south = utm(-70.6693, -33.4489);
  assert.equal(south.zone, 19);
  assert.equal(south.north, false);
  assert.ok(south.northing_m > 6_290_000 && south.northing_m < 6_300_000);
  assert.equal(utmZone(5, 60), 32);
  assert.equal(utmZone(10, 78), 33);
  assert.equal(utm(0, 85), null);
});

test('UTM distances are the geodesic ones times the scale near the central meridian', () => {
  const a = utm(9.0001, 46.5);
  const b = utm(9.0014, 46.5007);
  const grid_m = Math.hypot(b.easting_m - a.easting_m, b.northing_m - a.northing_m);
  assert.ok(Math.abs(grid_m / geodesicLength([9.0001, 46.5], [9.0014, 46.5007]) - 0.9996) < 2e-7);
});

test('coordinates never show sixty seconds and carry their hemisphere', () => {
  assert.equal(formatCoordinates(-0.9999999999, 45.9999999999, 'dms'), '46° 00′ 00.00″ N  1° 00′ 00.00″ W');
  assert.equal(formatCoordinates(7.5, -46.25, 'decimal'), '-46.2500000, 7.5000000');
  assert.match(formatCoordinates(7.5, 46.25, 'utm'), /^32N {2}384\d{3}\.\d\d E {2}51\d{5}\.\d\d N$/);
});

test('numbers are said as people say them', () => {
  assert.equal(formatBytes(999), '999\u00a0B');
  assert.equal(formatBytes(1_234_567), '1.23\u00a0MB');
  assert.equal(formatDuration(75), '75\u00a0s');
  assert.equal(formatDuration(4800), '80\u00a0min');
  assert.equal(formatDuration(5400), '1\u00a0h 30\u00a0min');
  assert.equal(formatGsd(0.0173), '1.73\u00a0cm/px');
  assert.equal(formatLength(0.052), '5.20\u00a0cm');
  assert.equal(formatLength(-3.2), '-3.20\u00a0m');
  assert.deepEqual([46.4, 1500, 15_400, 1_000_000].map(formatDistance), ['46\u00a0m', '1.5\u00a0km', '15\u00a0km', '1,000\u00a0km']);
  assert.equal(formatArea(24_310), '2.43\u00a0ha');
});

test('of a list that is drawn anew each element stays that shows the same', () => {
  let made = 0;
  const rowsOf = keptElements((/** @type {{id: string, name: string}} */ { id }) => id, ({ name }) => name, () => /** @type {any} */ ((made += 1)));
  const of = (/** @type {Record<string, string>} */ names) => rowsOf(Object.entries(names).map(([id, name]) => ({ id, name })));
  assert.deepEqual(of({ a: 'A', b: 'B' }), [1, 2]);
  assert.deepEqual(of({ b: 'B', c: 'C', a: 'A' }), [2, 3, 1]);
  assert.deepEqual(of({ a: 'A2', b: 'B' }), [4, 2], 'one that shows something else is another');
  assert.deepEqual(of({ c: 'C' }), [5], 'one that was gone is made anew');
});

/** @param {object} [more] @returns {any} */
const qualityWith = (more = {}) => ({ status: 'ready', absolute: { sigma_m: 2.3, by: 'gnss', count: 9 }, relative: { error_m: 0.012, error_px: 0.7, by: 'seams', count: 31 }, limits: [], ...more });

test('the page says of a map what the server judged, in the list and in the report alike', () => {
  const report = (/** @type {object} */ quality, more = {}) => /** @type {any} */ ({ photos: { total: 9, aligned: 9, pose_only: 0, left_out: 0 }, quality: qualityWith(quality), ...more });
  assert.deepEqual(resultWords(report({})), { grade: 'good', title: 'Ready to use', sentences: ['All 9 photos are aligned.'] });
  const few = { status: 'doubtful', absolute: { sigma_m: null, by: 'gnss', count: 1 }, limits: [{ kind: 'few_positions', count: 1, of: 42 }] };
  assert.equal(resultWords(report(few)).grade, 'bad');
  assert.match(resultWords(report(few)).sentences[0], /Only 1 of 42 photos has a position/);
  assert.equal(statusWords(qualityWith(few)), resultWords(report(few)).title);
  assert.equal(absoluteWords(qualityWith(few)), 'unknown: only 1 of 42 photos with a position');
  const no_scale = { status: 'doubtful', absolute: { sigma_m: null, by: 'gnss', count: 12 }, limits: [{ kind: 'scale_guessed', count: 0, of: 0 }] };
  assert.equal(absoluteWords(qualityWith(no_scale)), 'unknown: the scale is a guess', 'of twelve photos all have a position');
  assert.equal(absoluteWords(qualityWith({ ...no_scale, limits: [{ kind: 'north_guessed', count: 0, of: 0 }] })), 'unknown: north is a guess');
  assert.equal(accuracyMark(qualityWith(few)), '');
  assert.equal(accuracyMark(null), '');
  assert.equal(absoluteWords(qualityWith()), '\u00b12.3\u00a0m (1\u03c3), by 9 GNSS positions');
  assert.equal(absoluteWords(qualityWith({ absolute: { sigma_m: null, by: 'none', count: 0 } })), 'unknown: no positions');
  const far = { status: 'limited', absolute: { sigma_m: 12, by: 'check_points', count: 3 }, limits: [{ kind: 'far_off', count: 0, of: 0 }] };
  assert.doesNotMatch(resultWords(report(far)).sentences[0], /position/, 'check points gave the number');
  const missed = { status: 'limited', limits: [{ kind: 'checks_missed', count: 1, of: 3 }] };
  assert.match(resultWords(report(missed)).sentences[0], /misses 1 of 3 check points/);
  const imported = { status: 'unknown', absolute: { sigma_m: null, by: 'none', count: 0 } };
  assert.deepEqual([absoluteWords(qualityWith(imported)), relativeWords(qualityWith(imported))], Array(2).fill('unknown: an imported map'));
  assert.deepEqual(resultWords(report(imported, { photos: { total: 0 } })), { grade: 'amber', title: 'Accuracy not known', sentences: ['Imported map: its photos are not on this server.'] });
  const listed = { id: 'f', photos: { total: 0 }, file_count: 0, bytes: 2e6, created_at: '2026-01-02T03:04:05Z', quality: qualityWith(imported) };
  for (const facts of [flightFacts(listed), shortFacts(listed).join(' ')]) assert.match(facts, /imported map/);
  assert.match(shortFacts({ ...listed, photos: { total: 1 } }).join(' '), /1 photo\b/);
  const old = resultWords({ ...report({}), quality: undefined });
  assert.deepEqual([old.grade, old.title], ['amber', 'Accuracy not known'], 'a map of before there was a word on it is not called ready');
  assert.match(old.sentences[0], /before accuracy was judged/);
  assert.equal(relativeWords(qualityWith()), '1.2\u00a0cm (0.7\u00a0px), at 31 places along seams');
  const guessed = { status: 'unplaced', limits: [{ kind: 'not_georeferenced', count: 0, of: 0 }, { kind: 'scale_guessed', count: 0, of: 0 }] };
  assert.equal(isScaleKnown(qualityWith(guessed)), false);
  assert.equal(resultWords(report(guessed, { is_placed: false })).sentences.length, 2);
  const turned = { status: 'unplaced', limits: [{ kind: 'not_georeferenced', count: 0, of: 0 }, { kind: 'north_guessed', count: 0, of: 0 }] };
  assert.equal(isGuessed(report(turned, { is_placed: false })), true, 'one place tells no north');
  assert.match(resultWords(report(turned, { is_placed: false })).sentences.join(' '), /north is a guess.*The scale is known/);
  assert.match(resultWords(report({ status: 'unplaced', limits: [{ kind: 'not_georeferenced', count: 0, of: 0 }] }, { is_placed: false })).sentences.join(' '), /The scale is known/);
});

test('what the server does not know is said to be unknown, and is neither nothing nor the worst', () => {
  const record = /** @type {any} */ ({ name: 'A.JPG', placement: 'aligned', camera_lon: 7, camera_lat: 46, error_radius_m: null, camera_height_above_ground_m: null, yaw_deg: null });
  const said = Object.fromEntries(recordFacts(record, null, 'metric'));
  assert.deepEqual([said['Position error'], said['Height above ground']], ['unknown', 'unknown']);
  assert.ok(!Object.values(said).some((text) => /NaN|null|undefined/.test(text)), JSON.stringify(said));
  assert.equal(Object.fromEntries(recordFacts({ ...record, error_radius_m: 2.3 }, null, 'metric'))['Position error'], '± 2.3\u00a0m');
  assert.match(JSON.stringify(recordFacts({ ...record, error_radius_m: 0.3048, camera_height_above_ground_m: 30.48 }, null, 'imperial')), /"± 1\u00a0ft".*"100\.0\u00a0ft"/);
  assert.deepEqual([errorWords([1, 2, 4], 3, 'metric'), errorWords([0.3048, 0.6096, 1.2192], 5, 'imperial')], ['Median 2\u00a0m, maximum 4\u00a0m.', 'Median 2\u00a0ft, maximum 4\u00a0ft. Unknown for 2 photos.']);
  const photos = (/** @type {(number|null|undefined)[]} */ ...radii) => /** @type {any} */ ({ features: radii.map((error_radius_m) => ({ properties: { error_radius_m } })) });
  assert.deepEqual(errorsOf(null), { worst_m: null, lacks_some: false });
  assert.deepEqual(errorsOf(photos(null, undefined)), { worst_m: null, lacks_some: true });
  assert.deepEqual(errorsOf(photos(2, null, 3)), { worst_m: 3, lacks_some: true });
  assert.deepEqual(errorsOf(photos(2, 3)), { worst_m: 3, lacks_some: false });
  assert.equal(/** @type {any[]} */ (photoColour('error', 3)).at(-1), kUnknownErrorColour);
  const unjudged = (/** @type {object} */ more) => hasScale(/** @type {any} */ ({ photos: { total: 9 }, ...more }));
  assert.deepEqual([unjudged({}), unjudged({ is_placed: false, alignment: { placed_by: 'records' } }), unjudged({ is_placed: false, alignment: { placed_by: 'images' } })], [true, true, false]);
  const listed = (/** @type {boolean} */ georeferenced) => shortFacts(/** @type {any} */ ({ id: 'f', photos: { total: 9 }, created_at: '2026-01-02T03:04:05Z', bytes: 2e6, gsd_m: 0.0173, georeferenced, quality: null })).join(' ');
  assert.match(listed(true), /1\.73\scm\/px/);
  assert.doesNotMatch(listed(false), /px/);
});

// tests/core/pipeline/map_quality_test.cc holds the other programs' words to the same file.
test('an accuracy has the digits that every surface gives it', () => {
  for (const [metres, text] of JSON.parse(readFileSync(new URL('support/accuracy_texts.json', import.meta.url), 'utf8'))) assert.equal(formatError(metres), text.replace(' ', '\u00a0'), String(metres));
});

test('times of capture are those of the place, with their zone where it is known', () => {
  const at = (/** @type {string} */ first, last = first) => ({ first, last });
  const zone = (/** @type {string} */ iso) => formatCaptureTime(at(iso)).match(/\(.*\)/)?.[0] ?? '';
  assert.deepEqual(['2015-10-27T19:50:02-04:00', '2015-10-27T19:50:02+05:30', '2015-10-27T19:50:02-00:30', '2015-10-27T19:50:02+00:00', '2015-10-27T19:50:02Z', '2015-10-27T19:50:02'].map(zone),
    ['(UTC\u22124)', '(UTC+5:30)', '(UTC\u22120:30)', '(UTC)', '(UTC)', '']);
  assert.match(formatCaptureDay(at('2015-10-31T23:50:02-04:00', '2015-11-01T00:10:02-04:00')), /31.*1/);
  assert.equal(formatCaptureDay(at('yesterday')), '');
  assert.equal(formatCaptureTime(at('2015-13-45T00:00:00Z')), '');
  // A photo's time is in UTC; its flight knows the zone of the place's clock.
  const first = '2015-10-27T19:50:02-04:00';
  assert.equal(byClockOf('2015-10-28T00:10:02.5Z', first), '2015-10-27T20:10:02.500-04:00');
  assert.equal(byClockOf('2015-10-27T19:50:02Z', '2015-10-28T01:20:02+05:30'), '2015-10-28T01:20:02.000+05:30');
  for (const iso of ['2015-10-27T20:10:02', 'yesterdayZ']) assert.equal(byClockOf(iso, first), iso);
  for (const unzoned of [undefined, '2015-10-27T23:50:02Z', '2015-10-27T19:50:02']) assert.equal(byClockOf('2015-10-28T00:10:02Z', unzoned), '2015-10-28T00:10:02Z');
  const said = (/** @type {string} */ captured_at) => Object.fromEntries(recordFacts(/** @type {any} */ ({ placement: 'aligned', camera_lon: 7, camera_lat: 46, captured_at }), null, 'metric')).Captured;
  assert.match(said('2015-10-27T20:10:02.500-04:00'), /8:10.*\(UTC\u22124\)/);
  assert.match(said('2015-10-28T00:10:02Z'), /12:10.*\(UTC\)/);
  assert.doesNotMatch(said('2015-10-27T20:10:02'), /UTC/);
});

test('a view survives the way through the address, and what is no view is none', () => {
  const place = { zoom: 18.25, lat: 46.8426216, lon: -91.9939053, bearing: -30 };
  assert.deepEqual(placeOfHash(hashWithPlace('#/flights/a?at=1/2/3', place)), place);
  assert.deepEqual(parseRoute(hashWithPlace('#/flights/a', place)), { view: 'flight', id: 'a' });
  for (const hash of ['#/flights/a', '#/flights/a?at=', '#/flights/a?at=18/x/7', '#/flights/a?at=99/0/0', '#/flights/a?at=9/95/0', '#/flights/a?at=9']) assert.equal(placeOfHash(hash), null, hash);
});

test('a long name is cut between letters, not inside one', () => {
  assert.equal(clipName('short'), 'short');
  const cut = clipName('ä😀'.repeat(60));
  assert.equal(new TextEncoder().encode(cut).length, 200);
  assert.ok('ä😀'.repeat(60).startsWith(cut) && cut.isWellFormed?.() !== false);
});

test('addresses survive a round trip, broken ones lead home', () => {
  for (const route of [{ view: 'home', tags: [] }, { view: 'home', tags: ['maize', 'farm 3&?'] }, { view: 'flight', id: 'a/b c' }, { view: 'compare', id: 'x', other: 'y%' }]) {
    assert.deepEqual(parseRoute(routeHash(route)), route);
  }
  assert.deepEqual(parseRoute('#/flights/%E0%A4%A'), { view: 'home', tags: [] });
  assert.deepEqual(parseRoute('#/flights/abc?token=sq_x'), { view: 'flight', id: 'abc' });
});

test('an outline that crosses or touches itself is known, also across the date line', () => {
  assert.ok(!crossesItself([[0, 0], [2, 0], [2, 2], [0, 2]]));
  assert.ok(crossesItself([[0, 0], [2, 2], [2, 0], [0, 2]]));
  assert.ok(!crossesItself([[0, 0], [4, 0], [2, 1], [4, 2], [0, 2]]), 'a dent is no crossing');
  assert.ok(crossesItself([[0, 0], [4, 0], [0, 0.5], [4, 2], [0, 2], [-1, 0.5], [3, 0.2]]));
  assert.ok(!crossesItself([[0, 0], [2, 0], [2, 0], [2, 2], [0, 2]]), 'a corner set twice');
  assert.ok(!crossesItself([[179.9, 0], [-179.9, 0], [-179.9, 1], [179.9, 1]]));
  assert.ok(crossesItself([[179.9, 0], [-179.9, 1], [-179.9, 0], [179.9, 1]]));
  assert.ok(!crossesItself([[0, 0], [1, 0]]));
});

test('a place is inside its ring, with holes of the even-odd rule', () => {
  const square = [[0, 0], [2, 0], [2, 2], [0, 2], [0, 0]];
  assert.ok(isInside([1, 1], square));
  assert.ok(!isInside([3, 1], square));
});

test('the tiles of an area are those that touch it', () => {
  assert.deepEqual(tilesIn([-10, -10, 10, 10], 1, 1), [{ z: 1, x: 0, y: 0 }, { z: 1, x: 0, y: 1 }, { z: 1, x: 1, y: 0 }, { z: 1, x: 1, y: 1 }]);
  assert.equal(tilesIn([8.5, 47.3, 8.5001, 47.3001], 12, 15).length, 4);
  for (const bounds of [[8.5, 47.3, 8.501, 47.3002], [-179, -80, 179, 80], [7.999, 47, 8.001, 47.03]]) {
    const zoom = zoomOfFew(/** @type {any} */ (bounds));
    assert.ok(tilesIn(/** @type {any} */ (bounds), zoom, zoom).length <= 4, String(bounds));
    assert.ok(tilesIn(/** @type {any} */ (bounds), zoom + 2, zoom + 2).length > 2, String(bounds));
  }
});

test('coverage counts overlapping footprints', () => {
  const ring = (w, e) => [[w, 0], [e, 0], [e, 1], [w, 1], [w, 0]];
  const photo = (w, e) => ({ type: 'Feature', properties: {}, geometry: { type: 'Polygon', coordinates: [ring(w, e)] } });
  const grid = coverageGrid({ type: 'FeatureCollection', features: [photo(0, 2), photo(1, 3)] }, 30);
  assert.equal(grid.width, 30);
  assert.deepEqual([grid.counts[5], grid.counts[15], grid.counts[25]], [1, 2, 1]);
  assert.equal(grid.most, 2);
  assert.deepEqual(histogram([0, 1, 2, 10], 2).map(({ count }) => count), [3, 1]);
});

const file = (name, bytes, path = name) => ({ path, file: new File([Uint8Array.from(bytes)], name) });
const jpeg = [0xff, 0xd8, 0xff, 0xe0, 1];

test('photos and logs are chosen, the rest is named with its reason', async () => {
  const { chosen, ignored, folder } = await selectFiles([
    file('b.JPG', jpeg, 'card/b.JPG'),
    file('log.csv', [1], 'card/log.csv'),
    file('positions.TSV', [1], 'card/positions.TSV'),
    file('positions.xlsx', [1], 'card/positions.xlsx'),
    file('broken.jpg', [1, 2, 3], 'card/broken.jpg'),
    file('empty.jpg', [], 'card/empty.jpg'),
    file('film.AVI', [1], 'card/film.AVI'),
    file('flight.MP4', [1], 'card/flight.MP4'),
    file('letter.docx', [1], 'card/letter.docx'),
    file('old.rar', [1], 'card/old.rar'),
    file('rest.tar.gz', [1], 'card/rest.tar.gz'),
    file('one.gz', [1], 'card/one.gz'),
    file('two.tar.zst', [1], 'card/two.tar.zst'),
    file('.DS_Store', [1], 'card/.DS_Store'),
  ]);
  assert.deepEqual(chosen.map(({ name }) => name), ['b.JPG', 'flight.MP4', 'log.csv', 'positions.TSV', 'rest.tar.gz']);
  assert.deepEqual(ignored.map(({ name }) => name), ['card/broken.jpg', 'card/empty.jpg', 'card/film.AVI', 'card/letter.docx', 'card/old.rar', 'card/one.gz', 'card/positions.xlsx', 'card/two.tar.zst']);
  assert.equal(new Set(ignored.map(({ reason }) => reason)).size, 6);
  assert.equal(folder, 'card');
});

test('a file that cannot be read, of a card that was taken out, is named, and the others are sent', async () => {
  const gone = file('gone.jpg', jpeg);
  /** @type {any} */ (gone.file).slice = () => ({ arrayBuffer: async () => { throw new DOMException('A requested file could not be found.', 'NotFoundError'); } });
  const { chosen, ignored } = await selectFiles([gone, file('here.jpg', jpeg)]);
  assert.deepEqual(chosen.map(({ name }) => name), ['here.jpg']);
  assert.match(ignored[0].reason, /cannot be read/);
});

test('photos of the same name in several card folders are all sent', async () => {
  const { chosen } = await selectFiles(['100MEDIA', '101MEDIA', '102MEDIA'].map((f) => file('DJI_0001.JPG', jpeg, `DCIM/${f}/DJI_0001.JPG`)));
  assert.deepEqual(chosen.map(({ name }) => name), ['100MEDIA_DJI_0001.JPG', '101MEDIA_DJI_0001.JPG', '102MEDIA_DJI_0001.JPG']);
});

test('files of one name keep their folders, and so do the lists beside them', () => {
  assert.deepEqual(namesApart(['DCIM/100MEDIA/DJI_0001.JPG', 'DCIM/101MEDIA/DJI_0001.JPG', 'DCIM/101MEDIA/DJI_0002.JPG', 'DCIM/101MEDIA/positions.csv', 'DCIM/notes.txt']), [
    '100MEDIA_DJI_0001.JPG', '101MEDIA_DJI_0001.JPG', 'DJI_0002.JPG', '101MEDIA_positions.csv', 'notes.txt']);
  assert.deepEqual(namesApart(['100/a.jpg', '101/a.jpg', '101/a.xmp', '101/b.jpg', '101/b.jpg.xmp', '101/c.srt']), ['100_a.jpg', '101_a.jpg', '101_a.xmp', 'b.jpg', 'b.jpg.xmp', '101_c.srt']);
  assert.deepEqual(namesApart(['a/100/x.jpg', 'b/100/X.JPG', 'c/x.jpg', 'x.jpg']), ['a_100_x.jpg', 'b_100_X.JPG', 'c_x.jpg', 'x.jpg']);
  assert.deepEqual(namesApart(['x.jpg', 'x.jpg', 'X.jpg']), ['x.jpg', 'x(2).jpg', 'X.jpg']);
});

test('previews and deleted photos in folders of network drives are passed over', async () => {
  const { chosen, ignored } = await selectFiles([
    file('DJI_0001.JPG', jpeg, 'photos/DJI_0001.JPG'),
    file('SYNOPHOTO_THUMB_M.jpg', jpeg, 'photos/@eaDir/DJI_0001.JPG/SYNOPHOTO_THUMB_M.jpg'),
    file('DJI_0002.JPG', jpeg, '#recycle/DJI_0002.JPG'),
    file('DJI_0003.JPG', jpeg, 'photos/.Trashes/501/DJI_0003.JPG'),
  ]);
  assert.deepEqual(chosen.map(({ name }) => name), ['DJI_0001.JPG']);
  assert.deepEqual(ignored, []);
});

test('a map that was made below the folder of its photos is passed over', async () => {
  const sent = async (/** @type {string[]} */ paths) => {
    const { chosen, ignored } = await selectFiles(paths.map((path) => file(path.slice(path.lastIndexOf('/') + 1), jpeg, path)));
    assert.deepEqual(ignored, []);
    return chosen.map(({ name }) => name).sort();
  };
  const map = ['mosaic.state', 'geo.txt', 'dsm.tif', 'thumbnail.png', 'frames/frames.json', 'frames/DJI_0007_0001.jpg'].map((name) => `photos/map/${name}`);
  assert.deepEqual(await sent(['photos/DJI_0001.JPG', 'photos/geo.txt', 'photos/map/notes.txt', ...map]), ['DJI_0001.JPG', 'geo.txt', 'notes.txt']);
  assert.deepEqual(await sent(['frames/frames.json', 'frames/DJI_0007_0001.jpg']), ['DJI_0007_0001.jpg', 'frames.json'], 'chosen themselves');
});

test('a photo is known by its first bytes', () => {
  assert.ok(looksLikePhoto(Uint8Array.from([0x4d, 0x4d, 0, 0x2a])));
  assert.ok(!looksLikePhoto(Uint8Array.from([0x50, 0x4b, 3, 4])));
  assert.ok(!looksLikePhoto(new Uint8Array(0)));
});

test('an answer that is cut off on its way is that of a server that cannot be reached, which passes', async () => {
  const cut = new Response(new ReadableStream({ start: (controller) => controller.error(new TypeError('terminated')) }));
  await assert.rejects(answerOf(Promise.resolve(cut)), (error) => error instanceof ApiError && error.is_away);
});

const blobs = (n) => Array.from({ length: n }, (_, i) => ({ name: `p${i}.jpg`, file: new Blob([new Uint8Array(1000)]) }));
const finish = (queue) => new Promise((resolve) => {
  queue.addEventListener('change', () => queue.picture.state === 'finished' && resolve(undefined));
  queue.start();
});

test('an upload keeps at most four files in flight and ends with all sent', async () => {
  let now = 0;
  let most = 0;
  const queue = new UploadQueue(blobs(20), async (item, on_progress) => {
    now += 1;
    most = Math.max(most, now);
    on_progress(500);
    await new Promise((resolve) => setTimeout(resolve, 2));
    now -= 1;
  });
  await finish(queue);
  assert.equal(most, 4);
  assert.equal(queue.picture.done, 20);
  assert.equal(queue.picture.sent_bytes, 20_000);
});

test('a passing failure is tried again, a lasting one is reported with its reason', async () => {
  const tries = new Map();
  const queue = new UploadQueue(blobs(3), async ({ name }) => {
    tries.set(name, (tries.get(name) ?? 0) + 1);
    if (name === 'p0.jpg' && tries.get(name) < 3) throw Object.assign(new Error('busy'), { is_passing: true });
    if (name === 'p1.jpg') throw Object.assign(new Error('not a photo'), { is_passing: false });
  }, { retry_delay_ms: 1 });
  await finish(queue);
  assert.equal(tries.get('p0.jpg'), 3);
  assert.equal(tries.get('p1.jpg'), 1);
  assert.deepEqual(queue.items.map(({ state }) => state), ['done', 'failed', 'done']);
  assert.equal(queue.items[1].reason, 'not a photo');
});

test('pausing stops what is in flight and going on sends it again', async () => {
  let started = 0;
  let is_held = true;
  /** @type {((value: unknown) => void)[]} */
  const ends = [];
  const queue = new UploadQueue(blobs(6), (_item, _progress, signal) => new Promise((resolve, reject) => {
    started += 1;
    signal.addEventListener('abort', () => reject(new Error('aborted')));
    if (is_held) ends.push(resolve);
    else resolve(undefined);
  }));
  const turn = () => new Promise((resolve) => setImmediate(resolve));
  queue.start();
  await turn();
  queue.pause();
  await turn();
  for (const end of ends) end(undefined);  // too late
  await turn();
  assert.equal(started, 4);
  assert.equal(queue.picture.done, 0);
  is_held = false;
  await finish(queue);
  assert.equal(queue.picture.done, 6);
  assert.equal(queue.picture.failed, 0);
});

test('files that are chosen again while they are being sent, or have arrived, are sent once', async () => {
  const queue = new UploadQueue(blobs(2), ({ name }) => new Promise((resolve) => name === 'p0.jpg' && resolve()));
  queue.start();
  await new Promise(setImmediate);
  queue.add(blobs(3));
  assert.deepEqual(queue.items.map(({ name, state }) => [name, state]), [['p0.jpg', 'done'], ['p1.jpg', 'sending'], ['p2.jpg', 'sending']]);
  assert.equal(queue.picture.files, 3);
});

test('a file that is chosen while another of its name is being sent comes after that, and alone counts', async () => {
  const turn = () => new Promise((resolve) => setImmediate(resolve));
  const chosen = (/** @type {string} */ text) => [{ name: 'p.jpg', file: new Blob([text]) }];
  const sent = [], ends = [];
  const queue = new UploadQueue(chosen('a'), (item) => (sent.push(item.bytes), new Promise((resolve) => ends.push(resolve))));
  queue.start();
  for (const text of ['ab', 'a', 'abc']) queue.add(chosen(text));
  queue.skipStored(new Map([['p.jpg', 3]]));
  assert.deepEqual([sent, queue.items.map(({ bytes }) => bytes)], [[1], [1, 3]], 'of those that wait the last one');
  ends[0]();
  await turn();
  assert.deepEqual(sent, [1, 3]);
  ends[1]();
  await turn();
  assert.deepEqual([queue.picture.state, queue.picture.files, queue.picture.done], ['finished', 1, 1]);
});

test('files the server has whole are not sent again', async () => {
  const sent = [];
  const queue = new UploadQueue(blobs(3), async ({ name }) => void sent.push(name));
  queue.skipStored(new Map([['p0.jpg', 1000], ['p1.jpg', 999]]));
  await finish(queue);
  assert.deepEqual(sent, ['p1.jpg', 'p2.jpg']);
});

test('a server that is away fails no file, and what it had of a file does not count as sent over this line', async () => {
  let tries = 0;
  let at_ms = 0;
  const queue = new UploadQueue(blobs(1), async (item, on_progress) => {
    tries += 1;
    if (tries < 30) throw Object.assign(new Error('away'), { is_passing: true, is_away: true });
    on_progress(600, 600);
    at_ms += 2000;
    on_progress(800, 600);
    assert.equal(queue.picture.bytes_per_s, 100);
    assert.equal(queue.picture.sent_bytes, 800);
    at_ms += 60_000;
    assert.equal(queue.picture.bytes_per_s, 0, 'nothing moves any more');
  }, { retry_delay_ms: 0, now_ms: () => at_ms });
  await finish(queue);
  assert.equal(tries, 30);
  assert.deepEqual([queue.picture.done, queue.picture.failed], [1, 0]);
});

test('addresses lie below the path that the page lies below', () => {
  for (const [pathname, base] of [['/', ''], ['/index.html', ''], ['/embed/01abc', ''], ['/skyquilt/', '/skyquilt'], ['/skyquilt/embed/01abc', '/skyquilt'], ['/maps/drone/', '/maps/drone']]) {
    assert.equal(baseOf(pathname), base, pathname);
  }
  assert.equal(at('/tiles/x.json', '/skyquilt'), '/skyquilt/tiles/x.json');
  assert.equal(at('/skyquilt/tiles/x.json', '/skyquilt'), '/skyquilt/tiles/x.json');
  assert.equal(at('/skyquilted', '/skyquilt'), '/skyquilt/skyquilted');
  assert.equal(at('https://example.org/x', '/skyquilt'), 'https://example.org/x');
  assert.equal(at('/tiles/x.json', ''), '/tiles/x.json');
});

test('a flight is named by the nearest town, across every border of the lists', () => {
  const list = 'Here\t4695\t744\t40\nThere\t4710\t744\t40\nEast\t-1700\t17990\t40\nCity\t4695\t770\t140\n';
  assert.equal(nearestIn(list, 46.96, 7.45), 'Here');
  assert.equal(nearestIn(list, 47.06, 7.44), 'There');
  assert.equal(nearestIn(list, 46.95, 7.51), 'City', 'of a city one is near further off');
  assert.equal(nearestIn(list, 47.4, 7.44), '', 'more than 25 km away is not near');
  assert.equal(nearestIn(list, -17.01, -179.95), 'East', 'across the antimeridian');
  assert.equal(nearestIn('', 0, 0), '');
  const near = (/** @type {number} */ lat, /** @type {number} */ lon) => nearestIn(readFileSync(`${web_root}/vendor/places/${squareOf(lat, lon)}.txt`, 'utf8'), lat, lon);
  assert.equal(near(46.8426, -91.9937), 'Duluth');
  assert.equal(near(46.948, 7.447), 'Bern');
  // On both sides of the border between two lists the same town.
  assert.equal(near(45.0001, 9.7), near(44.9999, 9.7));
  assert.notEqual(near(45.0001, 9.7), '');
  assert.equal(near(78.22, 14.95), 'Longyearbyen', 'in the far north a list reaches further round');
});
