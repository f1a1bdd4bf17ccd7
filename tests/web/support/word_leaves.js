// The words of a language as one list.

/** @param {any} words @param {string} [path] @returns {[string, any][]} every text and function by its path */
export const leavesOf = (words, path = '') =>
  typeof words === 'object' && words !== null
    ? Object.entries(words).flatMap(([key, value]) => leavesOf(value, path === '' ? key : `${path}.${key}`))
    : [[path, words]];
