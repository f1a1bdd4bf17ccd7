// What the page says of a flight before it is sent: EXIF against exiftool, verdicts, settings files against GDAL; how long an
// answer to a file is waited for.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { existsSync, mkdtempSync, readdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { after, test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { gdalXml, josmAddress, qgisXml, xmlText } from '../../web/src/sharing/connect_files.js';
import { isUploading, sessions } from '../../web/src/upload/drop_zone.js';
import { glanceAtPhoto, kHeadBytes } from '../../web/src/upload/exif_reader.js';
import { patience_ms } from '../../web/src/upload/send_file.js';
import { verdictWords } from '../../web/src/upload/verdict_view.js';
import { judge, verdictOf } from '../../web/src/upload/verdict.js';
import { boundsOf } from './support/mock_flight.js';
import { startMockServer } from './support/mock_server.js';
import { loadFlightStrings } from '../../web/src/shared/flight_strings.js';
import { keepUnits } from '../../web/src/shared/units.js';

await loadFlightStrings();

const data = process.env.SKYQUILT_DATA ?? join(dirname(fileURLToPath(import.meta.url)), '../../../shared/data');
const has = (/** @type {string} */ program) => !spawnSync(program, ['-ver']).error;
const folder = mkdtempSync(join(tmpdir(), 'skyquilt-verdict-'));
after(() => rmSync(folder, { recursive: true, force: true }));

/** @param {string} path */
const glance = (path) => {
  const bytes = readFileSync(path);
  return glanceAtPhoto(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + Math.min(kHeadBytes, bytes.length)));
};
/** @param {string} path */
const exiftool = (path) =>
  JSON.parse(spawnSync('exiftool', ['-j', '-n', '-EXIF:GPSLatitude', '-EXIF:GPSLongitude', '-GPSLatitudeRef', '-GPSLongitudeRef', '-GPSAltitude', '-EXIF:DateTimeOriginal', path], { encoding: 'utf8' }).stdout)[0];

/** @param {string} path */
function assertAgrees(path) {
  const ours = glance(path);
  const truth = exiftool(path);
  const sign = (/** @type {string} */ ref, /** @type {number} */ value) => (/^[SW]/i.test(ref) ? -Math.abs(value) : value);
  assert.ok(Math.abs(ours.lat_deg - sign(truth.GPSLatitudeRef, truth.GPSLatitude)) < 1e-9, path);
  assert.ok(Math.abs(ours.lon_deg - sign(truth.GPSLongitudeRef, truth.GPSLongitude)) < 1e-9, path);
  assert.equal(new Date(ours.taken_s * 1000).toISOString().slice(0, 19), truth.DateTimeOriginal.replace(/(\d+):(\d+):(\d+) /, '$1-$2-$3T'), path);
}

const images = ['brighton_beach', 'seneca_40'].map((name) => join(data, name, 'images')).filter(existsSync);
test('an archive that is there whole is waited for while the server unpacks it, other silence is not', () => {
  const minutes = (/** @type {[string, number, number|null]} */ ...of) => patience_ms(...of) / 60_000;
  assert.equal(minutes('A.JPG', 100, 100), 1);
  assert.deepEqual([minutes('flight.zip', 100, 0), minutes('flight.zip', 100, 99)], [1, 1], 'on a line that is cut it is sent again');
  assert.ok(minutes('flight.zip', 100, 100) >= 10);
  assert.ok(minutes('flight.tar.gz', 100, null) >= 10, 'who asks again is answered when it is unpacked');
  assert.equal(minutes('A.JPG', 100, null), 1);
});

test('the page is not left without a question while the server cannot be told that all is there', () => {
  const upload = (/** @type {string} */ state, /** @type {string} */ trouble) => void sessions.set('f', /** @type {any} */ ({ queue: { picture: { state } }, trouble }));
  /** @type {[string, string, boolean][]} */
  const cases = [['running', '', true], ['finished', 'The server is away.', true], ['paused', 'The server is away.', true], ['paused', '', false], ['finished', '', false]];
  for (const [state, trouble, is_asked] of cases) {
    upload(state, trouble);
    assert.equal(isUploading(), is_asked, `${state} ${trouble}`);
  }
  sessions.clear();
});

test('nothing is sent before it is known what the server has, which it would keep twice', async () => {
  Object.assign(globalThis, { addEventListener: () => {} });
  const answers = [new Response('', { status: 500 }), Response.json({ files: [{ name: 'a.jpg', bytes: 1 }] })];
  const { fetch } = globalThis;
  globalThis.fetch = async () => answers.shift() ?? new Response('', { status: 503 });
  const { UploadSession } = await import('../../web/src/upload/uploads.js');
  const session = new UploadSession('f');
  /** @type {string[]} */
  const sent = [];
  session.queue.send = ({ name }) => {
    sent.push(name);
    return new Promise(() => {});
  };
  const chosen = ['a.jpg', 'b.jpg'].map((name) => ({ name, file: /** @type {any} */ (new Blob(['x'])) }));
  await session.add({ chosen, ignored: [], folder: '' });
  assert.deepEqual([sent, answers.length, session.trouble], [['b.jpg'], 0, '']);
  session.stop();
  globalThis.fetch = fetch;
});

test('real photos are read as exiftool reads them', { skip: !has('exiftool') ? 'no exiftool' : images.length === 0 ? `no photos at ${data}` : false }, () => {
  for (const path of images.flatMap((f) => readdirSync(f).filter((n) => /\.jpe?g$/i.test(n)).slice(0, 4).map((n) => join(f, n)))) assertAgrees(path);
});

test('written positions in all quarters of the world are read back', { skip: has('exiftool') ? false : 'no exiftool' }, () => {
  // A small but complete JPEG (1 x 1 pixel), into which exiftool writes.
  const jpeg = Buffer.from('/9j/4AAQSkZJRgABAQEASABIAAD/2wBDAP//////////////////////////////////////////////////////////////////////////////////////wAALCAABAAEBAREA/8QAFAABAAAAAAAAAAAAAAAAAAAAA//EABQQAQAAAAAAAAAAAAAAAAAAAAD/2gAIAQEAAD8AN//Z', 'base64');
  for (const [i, [lat, lon]] of [[46.9512345, 7.4391], [-33.4489, -70.6693], [-41.3, 174.78], [64.13, -21.94]].entries()) {
    const path = join(folder, `${i}.jpg`);
    writeFileSync(path, jpeg);
    const result = spawnSync('exiftool', ['-q', '-overwrite_original', `-GPSLatitude=${Math.abs(lat)}`, `-GPSLatitudeRef=${lat < 0 ? 'S' : 'N'}`, `-GPSLongitude=${Math.abs(lon)}`, `-GPSLongitudeRef=${lon < 0 ? 'W' : 'E'}`, '-EXIF:DateTimeOriginal=2026:05:12 09:31:00', i % 2 ? '-ExifByteOrder=MM' : '-ExifByteOrder=II', path], { encoding: 'utf8' });
    assert.equal(result.status, 0, result.stderr);
    assertAgrees(path);
  }
});

test('no bytes whatever can break the reader', () => {
  const good = Buffer.from([0xff, 0xd8, 0xff, 0xe1, 0, 60, 0x45, 0x78, 0x69, 0x66, 0, 0, 0x49, 0x49, 0x2a, 0, 8, 0, 0, 0, 2, 0, 0x25, 0x88, 4, 0, 1, 0, 0, 0, 8, 0, 0, 0, 0x10, 1, 2, 0, 0xff, 0xff, 0xff, 0xff, 200, 0, 0, 0, 0, 0, 0, 0]);
  let state = 7;
  for (let i = 0; i < 20_000; i += 1) {
    const bytes = Buffer.from(good);
    for (let k = 0; k < 3; k += 1) {
      state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
      bytes[state % bytes.length] = state >>> 24;
    }
    const cut = bytes.subarray(0, 1 + (state % bytes.length));
    const found = glanceAtPhoto(cut.buffer.slice(cut.byteOffset, cut.byteOffset + cut.length));
    assert.ok(found.lat_deg === null || Math.abs(found.lat_deg) <= 90);
  }
});

const photo = (/** @type {number} */ i, more = {}) => ({
  name: `p${i}.jpg`,
  glance: { lon_deg: 7 + i * 1e-4, lat_deg: 46, taken_s: 1000 + 3 * i, camera: 'FC300S', ...more },
});

test('a good flight is called good, with its size and time', () => {
  const verdict = { ...verdictOf(Array.from({ length: 20 }, (_, i) => photo(i))), logs: 0, archives: 0, films: 0 };
  keepUnits('metric');  // newer versions of Node speak American English
  const words = verdictWords(verdict);
  assert.deepEqual(words.warnings, []);
  assert.ok(Math.abs(verdict.span_m - 147) < 1);
  assert.match(words.facts, /^20 photos · FC300S · 147\.\d\sm across · flown in 57\ss$/);
  keepUnits('imperial');
  assert.match(verdictWords(verdict).facts, / 48\d\.\d\sft across /);
  keepUnits('metric');
});

test('missing positions, a stray photo and a long pause are told', () => {
  const flight = Array.from({ length: 20 }, (_, i) => photo(i, { taken_s: 1000 + 3 * i + (i > 10 ? 600 : 0) }));
  flight[3] = photo(3, { lon_deg: null, lat_deg: null });
  flight[5] = photo(5, { lat_deg: 45 });
  const { warnings } = verdictWords({ ...verdictOf(flight), logs: 0, archives: 0, films: 0 });
  assert.equal(warnings.length, 3);
  assert.match(warnings[0], /^1 photo has no GPS/);
  assert.match(warnings[1], /p5\.jpg/);
  assert.match(warnings[2], /10\smin/);
  const in_archive = verdictWords({ ...verdictOf([]), logs: 0, archives: 1, films: 0 });
  assert.deepEqual(in_archive.warnings, []);
  assert.match(in_archive.facts, /^1 archive; contents are checked/);
  assert.match(verdictWords({ ...verdictOf([photo(0, { lat_deg: null, lon_deg: null })]), logs: 0, archives: 0, films: 0 }).warnings[0], /cannot be placed/);
});

test('a video is neither a log nor a lack of photos', async () => {
  const chosen = (/** @type {string[]} */ ...names) => names.map((name) => ({ name, file: /** @type {any} */ (new Blob(['x'])) }));
  const film = verdictWords(await judge(chosen('DJI_0001.MP4', 'DJI_0001.SRT')));
  assert.deepEqual(film, { facts: '1 video · 1 flight log', warnings: [] });
  assert.deepEqual(verdictWords(await judge(chosen('DJI_0001.mov', 'DJI_0002.MOV', 'DJI_0003.JPG'))), { facts: '1 photo · 2 videos', warnings: ['1 photo has no GPS position. Add a flight log if you have one.'] });
  assert.deepEqual(verdictWords(await judge(chosen('flight.csv'))).warnings, ['These files contain logs but no photos.']);
});

test('settings for other programs hold any name', () => {
  assert.equal(xmlText('a<b>&"\u0007'), 'a&lt;b&gt;&amp;&quot;');
  const tilejson = { tiles: [], minzoom: 14, maxzoom: 21 };
  assert.match(qgisXml('"A" & B', 'http://h/{z}/{x}/{y}.png', tilejson), /name="&quot;A&quot; &amp; B" url="http:\/\/h\/\{z\}\/\{x\}\/\{y\}\.png" zmin="14" zmax="21"/);
  assert.equal(josmAddress('http://h/{z}/{x}/{y}.png', tilejson), 'tms[14,21]:http://h/{zoom}/{x}/{y}.png');
});

test('GDAL reads the map through its settings file', { skip: has('gdal_translate') ? false : 'no GDAL programs' }, async () => {
  const mock = await startMockServer();
  try {
    const flight = mock.seedReady('Meadow');
    const path = join(folder, 'map.gdal.xml');
    writeFileSync(path, gdalXml(`${mock.url}tiles/${flight.id}/{z}/{x}/{y}.png`, { tiles: [], minzoom: 14, maxzoom: 21, bounds: boundsOf(flight.place) }));
    const { lon, lat } = flight.place;
    const x = (lon / 180) * 20037508.342789244;
    const y = (Math.atanh(Math.sin((lat * Math.PI) / 180)) / Math.PI) * 20037508.342789244;
    // GDAL asks this very process for tiles, so it must not be waited for in a blocking way.
    const { spawn } = await import('node:child_process');
    const child = spawn('gdal_translate', ['-q', '-of', 'PNG', '-projwin', ...[x - 30, y + 30, x + 30, y - 30].map(String), '-outsize', '64', '64', path, join(folder, 'window.png')], { cwd: folder });
    let said = '';
    child.stderr.on('data', (chunk) => (said += chunk));
    const status = await new Promise((resolve) => child.on('exit', resolve));
    assert.equal(status, 0, said);
    const picture = readFileSync(join(folder, 'window.png'));
    assert.ok(picture.length > 4000, `a picture of the fields has details; this one has ${picture.length} bytes`);
  } finally {
    await mock.close();
  }
});
