// The language of the page: the one that was chosen here, else the first of the browser's that the page speaks, else
// English; and numbers, plurals, dates and lists as it has them. How the words get here: strings.js.
// And what else was chosen here, of units and the map below.

/** @typedef {'en'|'de'} Language a file of src/languages, which says how another one is added */

/** As each calls itself. @type {Record<Language, string>} */
export const kLanguages = { en: 'English', de: 'Deutsch' };
export const kFallback = /** @type {Language} */ ('en');

const kKey = 'skyquilt.language';

/** @param {string|null|undefined} tag like "de-AT" @returns {Language|null} */
function spokenIn(tag) {
  const language = (tag ?? '').toLowerCase().split('-')[0];
  return Object.hasOwn(kLanguages, language) ? /** @type {Language} */ (language) : null;
}

/** What the browser's user reads, best first. @returns {readonly string[]} */
const browserTags = () => globalThis.navigator?.languages ?? [];

/**
 * @param {string|null} kept
 * @param {readonly string[]} tags
 * @returns {Language}
 */
export const languageFor = (kept, tags) => spokenIn(kept) ?? tags.map(spokenIn).find((found) => found !== null) ?? kFallback;

/** @returns {Language} */
export const chosenLanguage = () => languageFor(keptChoice(kKey), browserTags());

/** For the next loading of the page. @param {Language} language */
export const keepLanguage = (language) => keepChoice(kKey, language);

/**
 * The browser's own form of a language: an Austrian who reads German reads Austrian dates.
 * @param {Language} language
 * @param {readonly string[]} tags
 * @returns {string}
 */
export function localeFor(language, tags) {
  const tag = tags.find((one) => spokenIn(one) === language) ?? language;
  try {
    return Intl.getCanonicalLocales(tag)[0];
  } catch {
    return language;  // a tag that is none
  }
}

/** What the page speaks now. @type {Language} */
export let language = kFallback;
/** @type {string} */
let locale = kFallback;

/** @param {Language} spoken whose words are loaded */
export function speak(spoken) {
  language = spoken;
  locale = localeFor(spoken, browserTags());
  made.clear();
  if (globalThis.document) document.documentElement.lang = spoken;
}

/** Formats take longer to make than to use. @type {Map<string, any>} */
const made = new Map();

/** @template T @param {string} key @param {() => T} make @returns {T} */
function once(key, make) {
  if (!made.has(key)) made.set(key, make());
  return made.get(key);
}

/**
 * @param {number} value
 * @param {Intl.NumberFormatOptions} [options]
 */
export const number = (value, options = {}) => once(`number ${JSON.stringify(options)}`, () => new Intl.NumberFormat(locale, options)).format(value);

/** With so many digits behind the point, no more and no fewer. @param {number} value @param {number} digits */
export const fixed = (value, digits) => number(value, { maximumFractionDigits: digits, minimumFractionDigits: digits });

/** @typedef {{other: string} & Partial<Record<Intl.LDMLPluralRule, string>>} Forms what goes with one, with two ... as far as a language tells them apart */

/** What goes with a number. @param {number} n @param {Forms} forms */
export const plural = (n, forms) => forms[once('plural', () => new Intl.PluralRules(locale)).select(n)] ?? forms.other;

/** The number and what goes with it: "1 photo", "2 photos". @param {number} n @param {Forms} forms */
export const count = (n, forms) => `${number(n)} ${plural(n, forms)}`;

/** "a, b and c". @param {string[]} parts */
export const list = (parts) => once('list', () => new Intl.ListFormat(locale, { type: 'conjunction' })).format(parts);

/** @param {Intl.DateTimeFormatOptions} options @returns {Intl.DateTimeFormat} */
export const dateFormat = (options) => once(`date ${JSON.stringify(options)}`, () => new Intl.DateTimeFormat(locale, options));

/** Orders names as its readers do, numbers by size. @returns {Intl.Collator} */
export const nameOrder = () => once('order', () => new Intl.Collator(locale, { numeric: true, sensitivity: 'base' }));

/** What the browser has no room for, or may not keep, counts until the page is left. @type {Map<string, string>} */
const unkept = new Map();

/** @param {string} key @returns {string|null} also null where the browser keeps nothing, as in frames of other sites: then there is no choice */
export function keptChoice(key) {
  try {
    return unkept.get(key) ?? localStorage.getItem(key);
  } catch {
    return null;
  }
}

/** @param {string} key @param {string} choice */
export function keepChoice(key, choice) {
  try {
    localStorage.setItem(key, choice);
    unkept.delete(key);
  } catch {
    unkept.set(key, choice);
  }
}

/** @param {string} key */
export function dropChoice(key) {
  unkept.delete(key);
  try {
    localStorage.removeItem(key);
  } catch {
    // A browser that may keep nothing has kept nothing.
  }
}
