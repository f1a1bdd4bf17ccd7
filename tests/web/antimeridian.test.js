// Maps across the antimeridian, whose bounds go on beyond 180 degrees, without a browser.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { shownFromSurveyed } from '../../web/src/control/control_guess.js';
import { coverageGrid } from '../../web/src/flight/report_pictures.js';
import { overlap } from '../../web/src/map/compare_view.js';
import { lonBeside } from '../../web/src/map/coordinates.js';
import { boundsOfData, readOwnData } from '../../web/src/map/own_data.js';
import { overlayParts } from '../../web/src/map/map_layers.js';
import { flightPath } from '../../web/src/map/map_style.js';
import { measurementOf, measurementsGeoJson } from '../../web/src/map/measurement_files.js';
import { outlineOf } from '../../web/src/map/outlines.js';
import { isAcross, sourceBounds, tilesIn } from '../../web/src/map/tile_addresses.js';
import { boundsOfNote, drawnNote, geometryOf, noteOf } from '../../web/src/notes/note_shape.js';
import { getIndexStatistics } from '../../web/src/shared/api.js';
import { verdictOf } from '../../web/src/upload/verdict.js';

/** @typedef {import('../../web/src/shared/types.js').Bounds} Bounds */

test('a map across the antimeridian has common ground with those on both sides of it', () => {
  const on = (/** @type {number} */ west, /** @type {number} */ east) => ({ bounds: /** @type {Bounds} */ ([west, -17, east, -16.9]) });
  const across = on(179.99, 180.01);
  for (const beside of [on(-179.995, -179.98), on(179.98, 179.995), on(179.995, 180.02)]) assert.deepEqual([overlap(across, beside), overlap(beside, across)], [true, true], String(beside.bounds));
  for (const away of [on(-179.98, -179.97), on(179.97, 179.98), on(-0.01, 0.01)]) assert.deepEqual([overlap(across, away), overlap(away, across)], [false, false], String(away.bounds));
  assert.equal(overlap(on(7, 8), on(7.5, 9)), true);
  assert.deepEqual([lonBeside(-179.75, 180), lonBeside(179.75, -180), lonBeside(7.25, 8), lonBeside(540.5, -179)], [180.25, -180.25, 7.25, -179.5]);
});

test('the library is given no bounds that it would cut at the antimeridian', () => {
  const across = /** @type {Bounds} */ ([179.99, -17, 180.01, -16.9]);
  assert.deepEqual([sourceBounds(across), sourceBounds(null), sourceBounds([7, 46, 8, 47])], [{}, {}, { bounds: [7, 46, 8, 47] }]);
  assert.deepEqual([isAcross(across), isAcross([-180, -85, 180, 85])], [true, false]);
  const legends = { photo: null };
  const tilejson = { tiles: [], bounds: across };
  assert.equal('bounds' in overlayParts('photo', tilejson, /** @type {any} */ (legends), 1).source, false);
});

test('tiles that change beyond the antimeridian are those at the other end', () => {
  const columns = tilesIn([179.99, -17, 180.01, -16.99], 10, 10).map(({ x }) => x);
  assert.deepEqual([...new Set(columns)], [1023, 0]);
});

test('lines and paths across the antimeridian do not go round the Earth, and leave with longitudes that there are', () => {
  const photo = (/** @type {string} */ name, /** @type {number} */ camera_lon) => ({ properties: { name, camera_lon, camera_lat: -17 } });
  const [path] = flightPath(/** @type {any} */ ({ features: [photo('a', 179.999), photo('b', -179.999), photo('c', 179.998)] })).features;
  assert.deepEqual(/** @type {any} */ (path.geometry).coordinates, [[179.999, -17], [180.001, -17], [179.998, -17]]);
  const line = noteOf('line', '', geometryOf([[179.999, -17], [180.001, -17]], 'distance'), 'n');
  assert.deepEqual(line.geometry.coordinates, [[179.999, -17], [-179.999, -17]]);
  assert.deepEqual(drawnNote(line).geometry.coordinates, [[179.999, -17], [180.001, -17]]);
  assert.deepEqual(boundsOfNote(line), [179.999, -17, 180.001, -17]);
  const area = noteOf('area', '', geometryOf([[179.999, -17], [180.001, -17], [180.001, -16.999]], 'area'), 'n');
  assert.deepEqual(drawnNote(area).geometry.coordinates, [[[179.999, -17], [180.001, -17], [180.001, -16.999], [179.999, -17]]]);
});

test('own lines and areas across the antimeridian do not go round the Earth, and what does stays', () => {
  const read = (/** @type {string} */ type, /** @type {any} */ coordinates) => {
    const data = readOwnData('x.geojson', JSON.stringify({ type, coordinates }));
    return [/** @type {any} */ (data.features[0].geometry).coordinates, boundsOfData(data)];
  };
  const area = { type: 'Polygon', coordinates: [[[179.5, -17], [180.5, -17], [180.5, -16], [179.5, -17]]] };
  assert.deepEqual(outlineOf('x', readOwnData('x.geojson', JSON.stringify(area)))?.geometry.coordinates, [[[179.5, -17], [-179.5, -17], [-179.5, -16], [179.5, -17]]], 'as the server takes it');
  assert.deepEqual(read('LineString', [[179.5, -17], [-179.5, -16]]), [[[179.5, -17], [180.5, -16]], [179.5, -17, 180.5, -16]]);
  const ring = (/** @type {number} */ west, /** @type {number} */ east) => [[west, -17], [east, -17], [east, -16], [west, -17]];
  assert.deepEqual(read('Polygon', [ring(179.5, -179.5), ring(-179.75, -179.625)]), [[ring(179.5, 180.5), ring(180.25, 180.375)], [179.5, -17, 180.5, -16]]);
  // Cut there, as RFC 7946 has it: each part stays where it is, and they are looked at together.
  assert.deepEqual(read('MultiPolygon', [[ring(179.5, 180)], [ring(-180, -179.5)]]), [[[ring(179.5, 180)], [ring(-180, -179.5)]], [179.5, -17, 180.5, -16]]);
  const earth = [[-180, -80], [0, -80], [180, -80], [180, 80], [-180, 80], [-180, -80]];
  assert.deepEqual(read('Polygon', [earth]), [[earth], [-180, -80, 180, 80]]);
});

test('measurements across the antimeridian are saved as GeoJSON that is cut there', () => {
  const saved = (/** @type {any} */ places, is_area = false) => JSON.parse(measurementsGeoJson([measurementOf('m', places, is_area)])).features[0].geometry;
  assert.deepEqual(saved([[179.5, -17], [180.5, -16], [179.75, -16]]), { type: 'MultiLineString', coordinates: [[[179.5, -17], [180, -16.5]], [[-180, -16.5], [-179.5, -16], [-180, -16]], [[180, -16], [179.75, -16]]] });
  assert.deepEqual(saved([[-179.5, -17], [-180, -16.5], [-180.5, -16]]).coordinates, [[[-179.5, -17], [-180, -16.5]], [[180, -16.5], [179.5, -16]]], 'a place on it');
  assert.deepEqual(saved([[179.5, -17], [180, -16.5], [179.5, -16]]), { type: 'LineString', coordinates: [[179.5, -17], [180, -16.5], [179.5, -16]] });
  assert.deepEqual(saved([[180.25, -17], [180.5, -17]]).coordinates, [[-179.75, -17], [-179.5, -17]]);
  const square = [[179.5, -17], [180.5, -17], [180.5, -16], [179.5, -16]];
  const { type, coordinates } = saved(square, true);
  assert.equal(type, 'MultiPolygon');
  assert.deepEqual(coordinates.map((/** @type {any} */ [ring]) => new Set(ring.map(String))), [new Set(['179.5,-17', '180,-17', '180,-16', '179.5,-16']), new Set(['-180,-17', '-179.5,-17', '-179.5,-16', '-180,-16'])]);
  assert.equal(saved([[179.5, -17], [180, -17], [180, -16]], true).type, 'Polygon');
});

test('photos on both sides of the antimeridian lie beside each other in the report and before they are sent', () => {
  const square = (/** @type {number} */ west) => ({ properties: {}, geometry: { type: 'Polygon', coordinates: [[[west, 0], [west + 0.002, 0], [west + 0.002, 0.002], [west, 0.002], [west, 0]]] } });
  const of = (/** @type {number[]} */ ...wests) => coverageGrid(/** @type {any} */ ({ features: wests.map(square) }), 40);
  const [across, elsewhere] = [of(179.997, 179.999, -179.999), of(6.997, 6.999, 7.001)];
  assert.deepEqual([across.width, across.height, across.most], [elsewhere.width, elsewhere.height, elsewhere.most]);
  const spanOf = (/** @type {number[]} */ ...lons) => verdictOf(lons.map((lon_deg, i) => ({ name: `${i}`, glance: { lon_deg, lat_deg: 0, taken_s: null, camera: '' } }))).span_m;
  assert.ok(Math.abs(spanOf(179.99, 179.999, -179.999, -179.99) - spanOf(6.99, 6.999, 7.001, 7.01)) < 1e-3);
});

test('a surveyed point beyond the antimeridian is expected beside the others', () => {
  // The map is twice too large.
  const guess = shownFromSurveyed([{ shown: [179.998, 0], is: [179.999, 0] }, { shown: [-179.998, 0], is: [-179.999, 0] }]);
  const [lon, lat] = guess?.([-179.998, 0]) ?? [NaN, NaN];
  assert.ok(Math.abs(lon + 179.996) < 1e-9 && Math.abs(lat) < 1e-9, `${lon} ${lat}`);
});

test('values of an index are counted on both sides of the antimeridian', async () => {
  /** @type {any[]} */
  const asked = [];
  globalThis.fetch = async (_, init) => {
    asked.push(JSON.parse(String(init?.body)));
    return new Response('{"index":{}}');
  };
  await getIndexStatistics('f', 'index=vari', [179, -17, 181, -16]);
  await getIndexStatistics('f', 'index=vari', [7, 46, 8, 47]);
  assert.deepEqual(asked, [
    { type: 'MultiPolygon', coordinates: [[[[179, -17], [180, -17], [180, -16], [179, -16], [179, -17]]], [[[-180, -17], [-179, -17], [-179, -16], [-180, -16], [-180, -17]]]] },
    { type: 'Polygon', coordinates: [[[7, 46], [8, 46], [8, 47], [7, 47], [7, 46]]] },
  ]);
});
