// The page's words: every language has all of them, with the same numbers and names in each, and no word is left in the
// code or the markup.
import assert from 'node:assert/strict';
import { existsSync, readdirSync, readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join, relative } from 'node:path';
import { test } from 'node:test';
import { formatArea, formatDate, formatDuration, formatError, formatLength } from '../../../web/src/shared/format.js';
import { count, kLanguages, languageFor, list, localeFor, speak } from '../../../web/src/shared/language.js';
import { loadFlightWords } from '../../../web/src/shared/flight_strings.js';
import { loadPageWords } from '../../../web/src/shared/strings.js';
import { web_root } from '../support/mock_server.js';
import { leavesOf as leaves } from '../support/page_faults.js';
import { literalsIn } from './text_literals.js';

/** @typedef {import('../../../web/src/shared/language.js').Language} Language */
const tags = /** @type {Language[]} */ (Object.keys(kLanguages));

/** But for remarks, whose values have names (remarks.test.js). */
async function loadStrings(/** @type {Language} */ tag) {
  const { remarks, ...words } = { ...(await loadPageWords(tag)), ...(await loadFlightWords(tag)) };
  assert.ok(remarks);
  return words;
}

/** Far apart, so that each is found again in what a function says. */
const kNumbers = [1011, 2022, 3033];
const digits = (/** @type {string} */ text) => text.replace(/(\d)[.,\u2019\u00a0\u202f](?=\d)/g, '$1');

/** @param {(...values: any[]) => string} say @returns {number[]} which of its values it says */
function saidBy(say) {
  const text = digits(say(...kNumbers.slice(0, say.length)));
  return kNumbers.map((value, i) => (text.includes(String(value)) ? i : -1)).filter((i) => i >= 0);
}

test('every language is a folder, and every folder a language', () => {
  assert.deepEqual(readdirSync(join(web_root, 'src/languages')).sort(), [...tags].sort());
});

for (const tag of tags) {
  test(`${tag} has the words of English, with the same values in them`, async () => {
    const [english, words] = [await loadStrings('en'), await loadStrings(tag)];
    const wanted = new Map(leaves(english));
    const found = new Map(leaves(words));
    assert.deepEqual([...found.keys()].sort(), [...wanted.keys()].sort());
    for (const [path, value] of found) {
      const original = wanted.get(path);
      assert.equal(typeof value, typeof original, path);
      if (typeof value === 'string') assert.equal(value.trim() === '', original.trim() === '', `${path} is empty`);
      if (typeof value !== 'function') continue;
      assert.ok(value.length <= original.length, `${path} takes more than it is given`);
      assert.deepEqual(saidBy(value), saidBy(original), `${path}: what it says of its values`);
      for (const number of [0, 1, 2, 5]) assert.doesNotMatch(String(value(...Array(original.length).fill(number))), /undefined|NaN|null|^\s*$/, `${path}(${number})`);
    }
  });

  test(`${tag} tells one from many wherever English does`, async () => {
    const isCounting = (/** @type {(...values: any[]) => string} */ say) =>
      say.length > 0 && say(...Array(say.length).fill(1)) !== say(...Array(say.length).fill(2)).replaceAll('2', '1');
    const english = leaves(await loadStrings('en')).filter(([, value]) => typeof value === 'function' && isCounting(value));
    assert.ok(english.length > 25, 'the English words count');
    const words = new Map(leaves(await loadStrings(tag)));
    const same = english.map(([path]) => path).filter((path) => !isCounting(words.get(path)));
    assert.deepEqual(same, []);
  });
}

test('no sentence was left in English', async () => {
  const english = new Map(leaves(await loadStrings('en')));
  for (const tag of tags.filter((one) => one !== 'en')) {
    const left = leaves(await loadStrings(tag)).filter(([path, value]) => typeof value === 'string' && / [a-z]/.test(value) && value === english.get(path));
    assert.deepEqual(left.map(([path]) => path), ['measure.unit_names.metric']);
  }
});

test('German has one word for a check point, and another for a control point', () => {
  const folder = join(web_root, 'src/languages/de');
  assert.deepEqual(readdirSync(folder).filter((name) => /kontrollpunkt/i.test(readFileSync(join(folder, name), 'utf8'))), [], 'they are Prüfpunkte and Passpunkte');
});

test('the language is the one chosen, else the first of the browser that the page speaks, else English', () => {
  assert.equal(languageFor(null, ['de-AT', 'en']), 'de');
  assert.equal(languageFor(null, ['fr-CH', 'de-CH', 'en']), 'de');
  assert.equal(languageFor(null, ['en-GB', 'de']), 'en');
  assert.equal(languageFor(null, ['fr', 'it']), 'en');
  assert.equal(languageFor(null, []), 'en');
  assert.equal(languageFor('de', ['en-US']), 'de');
  assert.equal(languageFor('tlh', ['de']), 'de');
  assert.equal(languageFor('constructor', ['toString']), 'en');
  assert.equal(localeFor('de', ['fr', 'de-AT', 'de']), 'de-AT');
  assert.equal(localeFor('de', ['en-US']), 'de');
  assert.equal(localeFor('en', ['en_broken']), 'en');
});

test('numbers, dates, plurals and lists are those of the language', async () => {
  const date = '2026-05-12T09:31:00Z';
  const german = await loadStrings('de');
  assert.equal(count(1, { one: 'Foto', other: 'Fotos' }), '1 Foto');
  assert.equal(count(12_345, { one: 'Foto', other: 'Fotos' }), '12.345 Fotos');
  assert.equal(formatLength(1234.4), '1,234\u00a0km');
  assert.equal(formatArea(24_300), '2,43\u00a0ha');
  assert.equal(formatError(0.284), '28\u00a0cm');
  assert.equal(german.quantities.below_second, 'weniger als 1\u00a0s');
  assert.equal(formatDate(date, { time_zone: 'UTC' }), '12.05.2026');
  assert.equal(list(['a', 'b', 'c']), 'a, b und c');
  const english = await loadStrings('en');
  assert.equal(english.flights.photos(1), '1 photo');
  assert.equal(english.flights.photos(12_345), '12,345 photos');
  assert.equal(formatDuration(0.2), 'less than 1\u00a0s');
  assert.match(formatDate(date, { time_zone: 'UTC' }), /^(May 12, 2026|12 May 2026)$/);
  speak('en');
});

const skip = existsSync(join(web_root, 'node_modules/typescript')) ? false : 'web/node_modules is missing (npm ci in web/)';

test('no word stands in the code', { skip }, () => {
  const typescript = createRequire(`${web_root}/package.json`)('typescript');
  const found = readdirSync(join(web_root, 'src'), { recursive: true, encoding: 'utf8' })
    .filter((name) => name.endsWith('.js') && !name.startsWith('languages/'))
    .flatMap((name) => literalsIn(typescript, readFileSync(join(web_root, 'src', name), 'utf8')).map((text) => `${name}: ${text}`));
  assert.deepEqual(found, []);
  // And the search finds what it is there for.
  const planted = (/** @type {string} */ code) => literalsIn(typescript, code).length;
  assert.equal(planted("h('p', {}, 'Flights')"), 1);
  assert.equal(planted("h('p', {}, `Flights of ${day}`)"), 1);
  assert.equal(planted("h('p', {}, done ? 'Done' : words.open)"), 1);
  assert.equal(planted("h('button', { 'aria-label': 'Close' })"), 1);
  assert.equal(planted("h('input', { placeholder: kind + ' name', title: 'Name' })"), 2);
  assert.equal(planted("note.textContent = 'Ready'"), 1);
  assert.equal(planted("showNote('It is done')"), 1);
  assert.equal(planted("const text = 'The map could not be moved.'"), 1);
  assert.equal(planted("element.setAttribute('aria-label', 'Map')"), 1);
  assert.equal(planted("h('p', { class: 'muted fine' }, words.open, ' · ', `${n} m`); throw new Error('no icon named x'); console.debug('no verdict at all')"), 0);
});

test('the markup has no words but the name of the program, and what is said without JavaScript, in every language', () => {
  for (const file of ['index.html', 'embed.html']) {
    const markup = readFileSync(join(web_root, file), 'utf8');
    const body = markup.slice(markup.indexOf('<body'));
    const without_script = body.match(/<noscript>([^]*?)<\/noscript>/)?.[1] ?? '';
    assert.equal(without_script.match(/<p/g)?.length, tags.length, relative(web_root, file));
    const rest = body.replace(without_script, '');
    const texts = [...rest.matchAll(/>([^<]*\p{L}[^<]*)</gu)].map((match) => match[1].trim());
    assert.deepEqual(texts.filter((text) => text !== 'Skyquilt'), [], file);
    assert.doesNotMatch(rest, /\s(aria-label|title|alt|placeholder)="[^"]*\p{L}/u, file);
  }
});
