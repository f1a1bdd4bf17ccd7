// Every word the page shows, in the language of its user (language.js): src/languages has them. Only that language is
// fetched; English where it cannot be. index.html and embed.html start this file before all others, so that the words
// are on their way while the rest of the page is.
import { chosenLanguage, kFallback, speak } from './language.js';

/** @typedef {typeof import('../languages/en/page.js').page_words & typeof import('../languages/en/map.js').map_words} Strings */

/** @type {Record<import('./language.js').Language, () => Promise<[{page_words: typeof import('../languages/en/page.js').page_words}, {map_words: typeof import('../languages/en/map.js').map_words}]>>} */
const kFiles = {
  en: () => Promise.all([import('../languages/en/page.js'), import('../languages/en/map.js')]),
  de: () => Promise.all([import('../languages/de/page.js'), import('../languages/de/map.js')]),
};

/** @param {import('./language.js').Language} language @returns {Promise<Strings>} */
export async function loadStrings(language) {
  const [{ page_words }, { map_words }] = await kFiles[language]();
  speak(language);
  return { ...page_words, ...map_words };
}

/** @returns {Promise<Strings>} */
async function loadChosen() {
  const language = chosenLanguage();
  try {
    return await loadStrings(language);
  } catch (error) {
    if (language === kFallback) throw error;
    console.debug('no words', language, error);
    return loadStrings(kFallback);
  }
}

export const strings = await loadChosen();
