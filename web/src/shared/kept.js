// A choice that this browser keeps.

/** @param {string} key @returns {string|null} also null where the browser keeps nothing, as in frames of other sites: then there is no choice */
export function keptChoice(key) {
  try {
    return localStorage.getItem(key);
  } catch {
    return null;
  }
}
