// Lists of surveyed points as they come, also broken ones; and where a map is expected to show a point.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { guessedPlace, shownFromSurveyed } from '../../../web/src/control/control_guess.js';
import { isCheckPoint, listText, nameOfSeveral, parseControlList, withPoints } from '../../../web/src/control/control_lists.js';
import { byQuality } from '../../../web/src/map/sighting_order.js';
import { predictionOf, residualsOf } from '../../../web/src/control/control_residuals.js';

const point = (name, x, y, height = null, marks = []) => ({ name, x, y, height, marks });

test('a gcp_list.txt is read with its marks', () => {
  const list = parseControlList('EPSG:32611\n235269.88\t3811198.11\t0.5\t1443.45\t917.22\tIMG_0037.jpg\tgcp02\n235269.88 3811198.11 0.5 235.5 410.5 IMG_0121.jpg gcp02\n1 2 nan 0 0 - later\nnonsense\n');
  assert.equal(list.reference_system, 'EPSG:32611');
  assert.equal(list.points.length, 2);
  assert.deepEqual(list.points[0].marks[1], { photo: 'IMG_0121.jpg', x: 235, y: 410 });
  assert.deepEqual(list.points[1], point('later', 1, 2));
  assert.deepEqual(list.bad_lines, [5]);
});

test('names of photos in a gcp_list.txt may hold blanks and stand in quotes', () => {
  const { points, bad_lines } = parseControlList('EPSG:4326\n8.1 46.8 400 10.5 20.5 DJI  0001.JPG corner\n8.2 46.8 400 30.5 40.5 "IMG 2 (3).jpg" pole\n8.2 46.8 400 50.5 60.5 DJI_7 pole\n');
  assert.deepEqual(bad_lines, []);
  assert.deepEqual(points.map(({ name, marks }) => [name, ...marks.map(({ photo }) => photo)]), [['corner', 'DJI  0001.JPG'], ['pole', 'IMG 2 (3).jpg', 'DJI_7']]);
});

test('marks stand below names of columns too, northing first or with decimal commas, and say which points only check', () => {
  const wanted = [point('A', 576691.5, 5188169.5, 158.5, [{ photo: 'a.jpg', x: 296.5, y: 377 }]), point('B_check', 576692.5, 5188169.5, 158.5, [{ photo: 'a.jpg', x: 10, y: 20 }])];
  for (const text of [
    'EPSG:32615\nx,y,z,px,py,image,name,check\n576691.5,5188169.5,158.5,297,377.5,a.jpg,A,\n576692.5,5188169.5,158.5,10.5,20.5,a.jpg,B,yes',
    'northing easting z px py image name\n5188169.5 576691.5 158.5 297 377.5 a.jpg A\n5188169.5 576692.5 158.5 10.5 20.5 a.jpg B check',
    '576691,5;5188169,5;158,5;297;377,5;a.jpg;A\n576692,5;5188169,5;158,5;10,5;20,5;a.jpg;B_check',
  ]) assert.deepEqual(parseControlList(text).points, wanted, text);
  assert.deepEqual(parseControlList('name,x,y,z,check\nA,1,2,3,\nB,4,5,6,1').points.map(({ name }) => name), ['A', 'B_check']);
  assert.deepEqual(['A', 'B_check', 'C CHECK', 'checked'].filter(isCheckPoint), ['B_check', 'C CHECK']);
});

test('tables are read with commas, semicolons, tabs or blanks, with and without a header', () => {
  const wanted = [point('A', 323456.12, 4005678.34, 12.5), point('B 2', 323460, 4005680, null)];
  for (const text of [
    'A, 323456.12, 4005678.34, 12.5\nB 2, 323460, 4005680',
    'EPSG:32632\r\nName;Nord;Ost;Höhe\r\nA;4005678,34;323456,12;12,5\r\nB 2;4005680;323460;',
    'id\televation\teasting (m)\tnorthing (m)\nA\t12.5\t323456.12\t4005678.34\nB 2\t\t323460\t4005680',
    '# a comment\n"A","323456.12","4005678.34","12.5"\n"B 2","323460","4005680",""',
    'epsg,name,x,y,z\n32632,A,323456.12,4005678.34,12.5\n32632,B 2,323460,4005680,',
  ]) assert.deepEqual(parseControlList(text).points, wanted, text);
  assert.equal(parseControlList('epsg,name,x,y,z\n32632,A,1,2,3').reference_system, 'EPSG:32632');
  assert.deepEqual(parseControlList('7.1 46.8 500.1\n7.2 46.9 500.2').points.map(({ name, x }) => [name, x]), [['gcp1', 7.1], ['gcp2', 7.2]]);
  assert.deepEqual(parseControlList('1 7.1 46.8\n2 7.2 46.9').points, [point('1', 7.1, 46.8), point('2', 7.2, 46.9)]);
});

test('northing stands before easting without a header too, where the system leaves no other reading', () => {
  const of = (/** @type {string} */ text, system = '') => parseControlList(text, system).points;
  const surveyed = [point('1', 576691.665, 5188169.628, 158.5), point('2', 576700, 5188200.5, 160)];
  const rows = '1,5188169.628,576691.665,158.5,CP\n2,5188200.5,576700,160,nail in road';
  for (const system of ['EPSG:32615', 'EPSG:26915', 'WGS84 UTM 15N', '+proj=utm +zone=15']) {
    assert.deepEqual(of(rows, system), surveyed, system);
    assert.deepEqual(of(`${system}\n1 576691.665 5188169.628 158.5\n2 576700 5188200.5 160`), surveyed, system);
  }
  assert.deepEqual(of('5188169.628\t576691.665\t158.5', 'EPSG:32615')[0].x, 576691.665);
  for (const system of ['', 'EPSG:2193', 'EPSG:3857', '+proj=utm +zone=15 +units=us-ft']) assert.equal(of(rows, system)[0].x, 5188169.628, system);
  assert.equal(of('1,32576691.5,5188169.5,158.5', 'EPSG:25832')[0].x, 32576691.5, 'with its zone before it');
  assert.deepEqual(of('1,46.84265,-91.99456,198\n2,46.8427,-91.9945,198', 'EPSG:4326').map(({ x, y }) => [x, y]), [[-91.99456, 46.84265], [-91.9945, 46.8427]]);
  assert.equal(of('1,46.84265,8.5,198', 'EPSG:4326')[0].x, 46.84265);
});

test('a list is read as programs save it: in UTF-8, in UTF-16, in the letters of Windows', () => {
  const text = 'Name;Nord;Ost;Höhe\nBrücke;4005678,34;323456,12;12,5';
  const wide = (/** @type {boolean} */ is_little) => Uint8Array.from([...`\ufeff${text}`].flatMap((letter) => [letter.charCodeAt(0) & 255, letter.charCodeAt(0) >> 8]).map((byte, i, all) => all[is_little ? i : i ^ 1]));
  const windows = Uint8Array.from([...text].map((letter) => letter.charCodeAt(0)));
  for (const bytes of [new TextEncoder().encode(text), new TextEncoder().encode(`\ufeff${text}`), wide(true), wide(false), windows]) {
    assert.deepEqual(parseControlList(listText(bytes)).points, [point('Brücke', 323456.12, 4005678.34, 12.5)]);
  }
});

test('of two heights those above the ellipsoid count, unless the system says what heights count from', () => {
  const height = (/** @type {string} */ text, /** @type {string} */ system) => parseControlList(text, system).points[0].height;
  const row = 'Name,Easting,Northing,Elevation,Ellipsoidal height\nA,1,2,100,147';
  assert.deepEqual(['EPSG:32632', 'EPSG:32632+5773', '+proj=utm +zone=32', ''].map((system) => height(row, system)), [147, 100, 147, 147]);
  assert.equal(height(`EPSG:25832+7837\n${row}`, 'EPSG:32632'), 100);
  assert.equal(height('Name,E,N,H\nA,1,2,100', 'EPSG:32632'), 100);
});

test('heights of a column in feet are taken in the unit of the system, and not where that is not known', () => {
  const heights = (/** @type {string} */ heading, /** @type {string} */ system) => {
    const { points, is_height_unit_unknown } = parseControlList(`Name,${heading}\nA,1.5,2.5,1000`, system);
    return [points[0].height, is_height_unit_unknown];
  };
  for (const heading of ['Longitude,Latitude,Elevation (ft)', 'lon,lat,height_ft', 'Easting [m],Northing [m],Z [US ft]']) {
    for (const system of ['EPSG:4326', 'EPSG:32615', 'EPSG:32615+5703', 'WGS84 UTM 32N', '+proj=utm +zone=15 +units=m']) assert.deepEqual(heights(heading, system), [304.8, false], `${heading} ${system}`);
  }
  assert.deepEqual(heights('x (ft),y (ft),z (ft)', 'EPSG:2263'), [1000, false]);
  assert.deepEqual(heights('x (ft),y (ft),z (m)', 'EPSG:2263'), [3280.8399, false]);
  for (const system of ['EPSG:2263', 'EPSG:32615+6360', '+proj=utm +zone=15 +units=us-ft']) assert.deepEqual(heights('x,y,z (ft)', system), [1000, true], system);
  for (const heading of ['x,y,z', 'x,y,z (m)']) assert.deepEqual(heights(heading, 'EPSG:2056'), [1000, false], heading);
  const marks = parseControlList('EPSG:32615\nx,y,z (ft),px,py,image\n1.5,2.5,1000,3,4,a.jpg');
  assert.deepEqual(marks.points.map(({ height }) => height), [304.8]);
});

test('what is no list is no points, and never a failure', () => {
  for (const text of ['', '\n\n', '\u0000\uffff', 'EPSG:4326', 'a,b,c', ',,,,\n;;;;', '1', '{"points": []}', '"', 'x;y\n;', 'A 1e999 3 4', '\uFEFF', 'name,x,y\nA,NaN,Infinity', '\t'.repeat(1000)]) {
    assert.deepEqual(parseControlList(text).points, [], JSON.stringify(text.slice(0, 20)));
  }
  const many = parseControlList(Array.from({ length: 30_000 }, (_, i) => `P${i},${i}.5,1.5`).join('\n'));
  assert.equal(many.points.length, 2000);
  let text = 'EPSG:4326\nA;7,1;46,8;500\n1 2 3 4 5 b.jpg c\n';
  let seed = 7;
  for (let i = 0; i < 3000; i += 1) {
    seed = (seed * 48271) % 2147483647;
    const at = seed % text.length;
    const changed = text.slice(0, at) + String.fromCharCode(seed % 127) + text.slice(at + (seed % 3));
    for (const { name, marks } of parseControlList(changed).points) assert.ok(typeof name === 'string' && Array.isArray(marks));
    if (i % 50 === 0) text = changed.slice(0, 200) || 'x';
  }
});

test('an imported list replaces coordinates and keeps marks; marks name photos as the flight calls them', () => {
  const before = [point('A', 1, 2, null, [{ photo: 'DJI_1.JPG', x: 5, y: 6 }]), point('B', 3, 4)];
  const merged = withPoints(before, [point('A', 10, 20, 1, [{ photo: 'dji_2', x: 1, y: 1 }, { photo: 'dji_1.jpg', x: 7, y: 8 }]), point('C', 5, 6)], ['DJI_1.JPG', 'DJI_2.JPG']);
  assert.deepEqual(merged.map(({ name }) => name), ['A', 'B', 'C']);
  assert.equal(merged[0].x, 10);
  assert.deepEqual(merged[0].marks, [{ photo: 'DJI_1.JPG', x: 7, y: 8 }, { photo: 'DJI_2.JPG', x: 1, y: 1 }]);
});

test('where a map shows a point is told by its mark, its survey or the other points', () => {
  const at = (name, lon, lat) => ({ ...point(name, lon, lat), lon, lat });
  const points = [at('A', 7.1, 46.8), at('B', 7.102, 46.8), at('C', 7.1, 46.801)];
  assert.deepEqual(guessedPlace(points[2], new Map(), points, true), [7.1, 46.801]);
  assert.equal(guessedPlace(points[2], new Map(), points, false), null);
  // The map lies at 0, 0, turned by a quarter and half as large.
  const shown = new Map([['A', [0, 0]], ['B', [0, 0.001 * Math.cos((46.8 * Math.PI) / 180)]]]);
  const [lon, lat] = guessedPlace(points[2], shown, points, false);
  assert.ok(Math.abs(lon + 0.0005) < 1e-6 && Math.abs(lat) < 1e-6, `${lon}, ${lat}`);
  assert.equal(guessedPlace(points[0], shown, points, false), shown.get('A'));
  // One that is marked says by how much a placed map is off.
  const near = guessedPlace(points[1], new Map([['A', [7.1001, 46.8002]]]), points, true);
  assert.ok(Math.abs(near[0] - 7.1021) < 1e-6 && Math.abs(near[1] - 46.8002) < 1e-6);
  assert.equal(shownFromSurveyed([]), null);
  assert.equal(shownFromSurveyed([{ shown: [0, 0], is: [1, 1] }, { shown: [1, 0], is: [1, 1] }]), null);
});

test('photos of a place come sharpest and most vertical first, aligned ones before others', () => {
  const order = (/** @type {any[]} */ ...seen) => seen.sort(byQuality).map(({ name }) => name).join('');
  assert.equal(order({ name: 'a', off_nadir_deg: 3, quality: 0.4 }, { name: 'b', off_nadir_deg: 20, quality: 0.88 }, { name: 'c', quality: 1, placement: 'pose_only' }), 'bac');
  assert.equal(order({ name: 'a', off_nadir_deg: 30 }, { name: 'b', off_nadir_deg: 1, sigma_m: 2 }, { name: 'c', off_nadir_deg: 2, sigma_m: 1 }), 'cba', 'of servers that say no quality by the angle; views alike by their placement');
});

test('what a map placed by the other points says of each is summed up', () => {
  const figures = (/** @type {string} */ name, /** @type {number|null} */ east) => ({ name, sightings: 2, is_used: true, reason: '', miss_east_m: 0, miss_north_m: 0, miss_up_m: 0, residual_px: 1, ...(east === null ? {} : { left_out: { miss_east_m: east, miss_north_m: 0, miss_up_m: 0 } }) });
  const of = (/** @type {(number|null)[]} */ ...easts) => predictionOf(residualsOf(/** @type {any} */ ({ alignment: { ground_control: easts.map((east, i) => figures(`P${i}`, east)) } })));
  assert.deepEqual(of(0.02, -0.5, null, 0.03), { median_m: 0.03, worst_m: 0.5, worst: 'P1' });
  assert.equal(of(null, null), null);
  assert.equal(of(), null);
});

test('points and marks that stand out are flagged', () => {
  const mark = (photo, residual_px, is_used = true) => ({ photo, residual_px, residual_m: residual_px / 100, is_used });
  const figures = (name, east, marks, is_used = true) => ({ name, sightings: 2, is_used, reason: '', miss_east_m: east, miss_north_m: 0, miss_up_m: 0, residual_px: 1, marks });
  const report = /** @type {any} */ ({ gsd_m: 0.02, alignment: { ground_control: [
    figures('A', 0.02, [mark('1', 1), mark('2', 9)]), figures('B', 0.03, [mark('1', 1.2), mark('2', 80, false)]), figures('C', 0.5, [mark('1', 0.8)]), figures('D', 30, [], false)] } });
  const found = residualsOf(report);
  assert.deepEqual(found.map(({ is_outlier }) => is_outlier), [false, false, true, true]);
  assert.deepEqual(found.flatMap(({ marks }) => marks.map(({ is_outlier }) => is_outlier)), [false, true, false, true, false]);
  assert.deepEqual(residualsOf(null), []);
});

test('points of one name with different coordinates are none that one may be taken of', () => {
  const listed = (/** @type {string} */ text) => nameOfSeveral(parseControlList(text).points);
  assert.equal(listed('name,x,y,z\nA,1.5,2.5,3\nB,4.5,5.5,6\nA,1.5,2.6,3'), 'A', 'measured twice');
  assert.equal(listed('EPSG:4326\n8.1 46.8 400 10 20 a.jpg A\n8.2 46.8 400 30 40 b.jpg A'), 'A', 'a digit is mistyped in one row');
  assert.equal(listed('name,x,y,z\nA,1.5,2.5,3\nA,1.5,2.5,4'), 'A');
  assert.equal(listed('name,x,y,z\nA,1.5,2.5,3\nB,4.5,5.5,\nA,1.5,2.5,3'), '');
  assert.equal(nameOfSeveral([]), '');
});
