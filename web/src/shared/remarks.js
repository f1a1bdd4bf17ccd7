// What the server remarks, in the page's language: by its code, and by the server's own sentence where the page does not
// know the code.
/** @import { LeftOut, Remark } from './types.js' */
import { remarkWords, serverWords } from './api.js';

/** Is it, or what it goes on to say, a sentence that only the server has? @param {Remark} remark @returns {boolean} */
const isEnglish = ({ code, values }) => code === 'text' || Object.values(values).some((value) => Array.isArray(value) && value.some(isEnglish));

/**
 * @param {{warnings?: string[], remarks?: Remark[]}} told remarks: one for each warning; without them in what was written by
 *   earlier versions
 * @returns {{text: string, language: string|null, photo: string|null}[]} language: where it is not the page's own; photo: that
 *   it is of alone
 */
export function saidOf({ warnings = [], remarks = [] }) {
  return warnings.map((sentence, i) => {
    const remark = remarks[i];
    const words = remarkWords(remark);
    return {
      text: words ?? sentence,
      language: words === null || isEnglish(remark) ? 'en' : null,
      photo: remark?.code === 'of_photo' ? String(remark.values.photo) : null,
    };
  });
}

/**
 * @param {Remark[]|undefined} remarks without them in what was written by earlier versions
 * @param {string|null|undefined} sentence of the server
 * @returns {string} all of them, one after the other
 */
export function inOneLine(remarks, sentence) {
  const said = (remarks ?? [undefined]).map(remarkWords);
  return said.includes(null) ? sentence ?? '' : said.join('; ');
}

/** @param {LeftOut} left_out @returns {string} why it is not in the map */
export const whyLeftOut = ({ code, reason, remark }) => serverWords(code, reason, remark);
