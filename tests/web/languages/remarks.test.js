// What the server remarks: every code of core/flight/remarks/remarks_on_*.inc has its English sentence there and words in every
// language of the page, which say the same values; and the page shows them in place of the server's sentences.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { kLanguages, speak } from '../../../web/src/shared/language.js';
import { loadFlightWords } from '../../../web/src/shared/flight_strings.js';
import { loadPageWords, strings } from '../../../web/src/shared/strings.js';
import { remarkWords, serverWords } from '../../../web/src/shared/api.js';
import { inOneLine, saidOf, whyLeftOut } from '../../../web/src/shared/remarks.js';
import { errorTold, keepUnits } from '../../../web/src/shared/units.js';
import { absoluteWords, accuracyMark, relativeWords } from '../../../web/src/flight/flight_words.js';
import { web_root } from '../support/mock_server.js';

/** @typedef {import('../../../web/src/shared/language.js').Language} Language */
const tags = /** @type {Language[]} */ (Object.keys(kLanguages));

const source = (/** @type {string} */ name) => readFileSync(join(web_root, '../core/flight/remarks', name), 'utf8').replace(/\/\/.*/g, '');
const snake = (/** @type {string} */ name) => name.replace(/(?<!^)([A-Z])/g, '_$1').toLowerCase();

/** The row of every remark, and its code as its name in JSON. */
const lists = [...source('remarks.inc').matchAll(/remarks_on_\w+\.inc/g)].map(([name]) => source(name));
const rows = lists.join('').split('REMARK(k').slice(1);
const codes = rows.map((row) => snake(row.slice(0, row.indexOf(','))));

/** @type {Map<string, Set<string>>} by code, the values that its English sentence says */
const said_there = new Map(
  rows.map((row) => {
    const literals = [...row.matchAll(/"((?:[^"\\]|\\.)*)"/g)].map(([, text]) => text);
    const values = [...literals.slice(1).join('').matchAll(/\{(\w+)(?::[^}]*)?\}/g)].map(([, name]) => name);
    return [literals[0], new Set(values)];
  }),
);

/** What the server says only in English may be left out. @param {Iterable<string>} values */
const withoutEnglish = (values) => [...values].filter((name) => !name.endsWith('_words')).sort();

/** Of each kind of value one, far from all others. @param {string} name */
const example = (name) => (/_(m|km|cm|mm|ms|s|h|days|mps2|deg|percent|px|gib|mib)$|^(photos|total|points|used|groups|rows|models|more|remarks|pictures|times|lag|epsg|failed|captures|missing|target|marks|most|cells|places|outside|byte|bytes|wrong|imus|vehicles?|samples|samples_in_all|dropouts|messages|jumps|part|positions|dropped|skipped|unread|without_place|without_time|times_read|files|across|down|needed|cues|shapes|frames|events|headers|force|by_records|of_records|degrees|tiles)$/.test(name) ? 7 : `<${name}>`);

/** @param {(values: any) => string} say @returns {{text: string, asked: Set<string>}} */
function ask(say) {
  const asked = /** @type {Set<string>} */ (new Set());
  const text = say(new Proxy({}, { get: (_, name) => (asked.add(String(name)), example(String(name))) }));
  return { text, asked };
}

test('every code has an English sentence', () => {
  assert.ok(codes.length > 100, 'the codes were found');
  assert.deepEqual([...said_there.keys()], codes);
});

for (const tag of tags) {
  test(`${tag} has words for every code, with the values of its sentence`, async () => {
    const { remarks } = await loadFlightWords(tag);
    assert.deepEqual(Object.keys(remarks).sort(), [...codes].sort());
    for (const code of codes) {
      const there = said_there.get(code) ?? new Set();
      const { text, asked } = ask(remarks[code]);
      const is_detail = code === 'left_panorama';
      assert.deepEqual(withoutEnglish(asked), withoutEnglish(there), code);
      for (const name of asked) assert.ok(there.has(name), `${code}: the server gives no ${name}`);
      if (!is_detail) assert.doesNotMatch(text, /undefined|NaN|null|\[object/, code);
      assert.doesNotMatch(text, /`|--[a-z]|skyquilt /, `${code}: what the page shows names no commands`);
    }
  });
}

test('lengths in remarks have the units that are chosen', async () => {
  const { remarks } = await loadFlightWords('en');
  const said = () => [remarks.position_elsewhere({ off_m: 46.2 }), remarks.heights_jump({ before: 'a', after: 'b', by_m: 3.048 }), remarks.altitude_impossible({ altitude_m: 30_480 }), remarks.left_far_from_flight({ apart_km: 16.09344 }),
    remarks.fail_places_contradict({ apart_m: 6.096 }), remarks.fail_points_contradict({ apart_m: 9.144 }), remarks.export_system_inexact({ epsg: 1, error_m: 1.524 })].join('\n');
  keepUnits('imperial');
  assert.match(said(), /152\u00a0ft[^]*10\u00a0ft[^]*100,000\u00a0ft[^]*10\u00a0mi[^]* 20\.0\u00a0ft[^]* 30\.00\u00a0ft[^]* 5\.0\u00a0ft/);
  keepUnits('metric');
  assert.match(said(), /46\u00a0m[^]*3\u00a0m[^]*30,480\u00a0m[^]*16\u00a0km[^]* 6\.1\u00a0m[^]* 9\.14\u00a0m[^]* 1\.5\u00a0m/);
});

test('lengths in remarks are no zeros where they are small', async () => {
  const { remarks } = await loadFlightWords('en');
  const said = () => [0.034, 0.14].map((apart_m) => remarks.lists_apart({ file: 'a', other: 'b', photos: 3, apart_m, why: [] }).match(/, ([^,]+) apart/)?.[1]);
  keepUnits('imperial');
  assert.deepEqual(said(), ['1.3\u00a0in', '5.5\u00a0in']);
  keepUnits('metric');
  assert.deepEqual(said(), ['3.4\u00a0cm', '14\u00a0cm']);
});

test('accuracies of a map have the units that are chosen', () => {
  const quality = /** @type {any} */ ({ status: 'ready', absolute: { sigma_m: 3.048, by: 'gnss', count: 9 }, relative: { error_m: 0.03048, error_px: 0.7, by: 'seams', count: 31 }, limits: [] });
  const said = () => [accuracyMark(quality), absoluteWords(quality), relativeWords(quality)].join('\n');
  keepUnits('imperial');
  assert.match(said(), /^\u00b110\u00a0ft\n\u00b110\u00a0ft .*\n1\.2\u00a0in \(0\.7\u00a0px\)/);
  const told = (/** @type {number[]} */ ...inches) => inches.map((length_in) => errorTold(length_in * 0.0254).replace('\u00a0', ' '));
  assert.deepEqual(told(0.021, 0.94, 11.2, 18, 1200), ['0.021 in', '0.94 in', '11 in', '1.5 ft', '100 ft']);
  keepUnits('metric');
  assert.match(said(), /^\u00b13\u00a0m\n\u00b13\u00a0m .*\n3\u00a0cm \(0\.7\u00a0px\)/);
});

test('no two languages say the same sentence', async () => {
  const [english, german] = [(await loadFlightWords('en')).remarks, (await loadFlightWords('de')).remarks];
  const same = codes.filter((code) => ask(english[code]).text === ask(german[code]).text);
  assert.deepEqual(same, ['then', 'photo_does', 'text', 'sentences', 'of_photo', 'of_file', 'file_not_read', 'reading_system']);
});

test('a remark is said in the language of the page, one that it does not know as the server says it', async () => {
  speak('de');
  Object.assign(strings, await loadFlightWords('de'));
  const groups = { code: 'groups', values: { groups: 3 } };
  const blurred = { code: 'of_photo', values: { photo: 'a.jpg', said: [{ code: 'doubt_blurred', values: {} }] } };
  const noted = { code: 'of_photo', values: { photo: 'a.jpg', said: [{ code: 'text', values: { text_words: 'A note.' } }] } };
  const unknown = { code: 'of_photo', values: { photo: 'a.jpg', said: [{ code: 'constructor', values: {} }] } };
  assert.equal(remarkWords(blurred), 'a.jpg: ist unscharf');
  const said = saidOf({ warnings: ['Three groups.', 'a.jpg: is blurred', 'a.jpg: A note.', 'New.', 'Old.'], remarks: [groups, blurred, noted, unknown] });
  assert.match(said[0].text, /^Die Fotos bilden 3 Gruppen/);
  assert.deepEqual(said.map(({ photo }) => photo), [null, 'a.jpg', 'a.jpg', 'a.jpg', null]);
  assert.deepEqual(said.map(({ language }) => language), [null, null, 'en', 'en', 'en']);
  assert.deepEqual(said.slice(2).map(({ text }) => text), ['a.jpg: A note.', 'New.', 'Old.']);
  assert.equal(whyLeftOut({ name: 'b.jpg', code: 'conflict', reason: 'The same bytes as a.jpg.', remark: { code: 'left_same_bytes', values: { other: 'a.jpg' } } }), 'Dieselbe Datei wie a.jpg.');
  assert.match(whyLeftOut({ name: 'c.jpg', code: 'corrupt', reason: 'It ends early.', remark: { code: 'text', values: { text_words: 'It ends early.' } } }), /: It ends early\.$/);
  const few_points = { code: 'by_pose_few_points', values: { points: 3 } };
  assert.equal(inOneLine([few_points, { code: 'doubt_blurred', values: {} }], 'English.'), 'liegt nach den Metadaten: zu wenige Punkte gemeinsam mit anderen Fotos (3); ist unscharf');
  assert.equal(inOneLine([few_points, { code: 'constructor', values: {} }], 'English.'), 'English.');
  assert.equal(inOneLine(undefined, 'English.'), 'English.');
  assert.deepEqual([inOneLine([], 'English.'), inOneLine(undefined, null)], ['', '']);
  speak('en');
});

test('why nothing came of it is said by its reason, and quoted where the page has no words for that', async () => {
  const memory = { code: 'fail_memory', values: { limit_gib: 4.5, where: [{ code: 'in_stage_at', values: { stage: 'check', at_words: 'photo 3 of 9' } }] } };
  const english = 'The job was ended because it needed more than 4.5 GiB of memory.';
  speak('de');
  Object.assign(strings, await loadPageWords('de'), await loadFlightWords('de'));
  assert.match(serverWords('unprocessable', english, memory), /im Schritt „Fotos werden geprüft“ beendet: Es brauchte mehr als 4,5\u00a0GiB/);
  assert.equal(serverWords('unprocessable', english, { code: 'fail_of_tomorrow', values: {} }), `Verarbeitung nicht möglich. Im Wortlaut: ${english}`);
  for (const none of [undefined, null, { code: 'text', values: { text_words: english } }])
    assert.equal(serverWords('unprocessable', english, none), `Verarbeitung nicht möglich. Im Wortlaut: ${english}`);
  assert.equal(serverWords('of_tomorrow', english), english);
  const few = { code: 'fail_few_points', values: { points: 4, used: 2, needed: 3 } };
  const noted = { code: 'control_noted', values: { point: 'P1', reason: [{ code: 'point_few_marks', values: {} }] } };
  const row = { code: 'sentences', values: { first: [few], then: [noted, { code: 'then', values: { said: [noted] } }] } };
  assert.match(serverWords('unprocessable', english, row), /^2 von 4 Passpunkten .*\. Passpunkt P1: .*\. Passpunkt P1: /);
  const shown = (/** @type {string} */ code, /** @type {string} */ column) => ({ code, values: { column, cell: '"8.1"', line: 2 } });
  const columns = [
    { code: 'columns_known', values: { columns: 'lat' } },
    { code: 'columns_unknown_and_more', values: { columns: [shown('column_shown', 'x'), shown('and_column_shown', 'y')], more_columns: 'z' } },
  ];
  const table = { code: 'table_lacks', values: { file: 'a.csv', missing: [{ code: 'lacks_longitude', values: {} }], columns } };
  assert.match(serverWords('unsupported_format', english, table), /Länge erkannt; erkannt wurden lat; nicht erkannt wurden x \("8\.1" in Zeile 2\), y \("8\.1" in Zeile 2\), z\. Benennen/);
  const force = { code: 'column_contradicts', values: { column: '"ax"', why: [{ code: 'gravity_of_no_unit', values: { force: 3.14159 } }] } };
  assert.match(serverWords('unprocessable', english, { code: 'table_not_used', values: { file: 'a.csv', why: [force] } }), /^a\.csv wird nicht verwendet\. Spalte "ax": Der Median der Beschleunigung ist 3,14, /);
  Object.assign(strings, await loadPageWords('en'), await loadFlightWords('en'));
  speak('en');
  assert.match(serverWords('unprocessable', english, memory), /in the step “Checking .*4\.5\u00a0GiB/);
  assert.equal(serverWords('unprocessable', english), english);
});
