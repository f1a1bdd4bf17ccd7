// The words that the first view does without: of uploads and of an open flight. Loaded once with what needs them, before
// any of it is shown. In the language that the page speaks already, else in English.
import { kFallback, language } from './language.js';
import { strings as page_strings } from './strings.js';

/** @typedef {typeof import('../languages/en/flight.js').flight_words} FlightWords */

/** @type {Record<import('./language.js').Language, () => Promise<{flight_words: FlightWords}>>} */
const kFiles = {
  en: () => import('../languages/en/flight.js'),
  de: () => import('../languages/de/flight.js'),
};

/** All words of the page; those of flights once loadFlightStrings has come back. */
export const strings = /** @type {import('./strings.js').PageWords & FlightWords} */ (page_strings);

/** @param {import('./language.js').Language} tag @returns {Promise<FlightWords>} */
export const loadFlightWords = async (tag) => (await kFiles[tag]()).flight_words;

/** Again where the server was away. */
export async function loadFlightStrings() {
  if ('report' in page_strings) return;
  const words = await loadFlightWords(language).catch((error) => {
    console.debug('no words', language, error);
    return loadFlightWords(kFallback);
  });
  Object.assign(page_strings, words);
}
