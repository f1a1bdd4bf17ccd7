// The words of the page in the language of its user (language.js): src/languages has them. Only that language is fetched;
// English where it cannot be. index.html starts this file before all others, so that the words are on their way while
// the rest of the page is. What an open flight says comes with it: flight_strings.js.
import { chosenLanguage, kFallback, speak } from './language.js';

/** @typedef {typeof import('../languages/en/page.js').page_words} PageWords */

/** @type {Record<import('./language.js').Language, () => Promise<{page_words: PageWords}>>} */
const kFiles = {
  en: () => import('../languages/en/page.js'),
  de: () => import('../languages/de/page.js'),
};

/** From now on the page speaks this language. @param {import('./language.js').Language} language @returns {Promise<PageWords>} */
export async function loadPageWords(language) {
  const { page_words } = await kFiles[language]();
  speak(language);
  return page_words;
}

/** @returns {Promise<PageWords>} */
async function loadChosen() {
  const language = chosenLanguage();
  try {
    return await loadPageWords(language);
  } catch (error) {
    if (language === kFallback) throw error;
    console.debug('no words', language, error);
    return loadPageWords(kFallback);
  }
}

export const strings = { ...(await loadChosen()) };
