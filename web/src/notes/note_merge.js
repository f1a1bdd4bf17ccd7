// Changes of notes that the server does not have yet, and how they go together with what others changed meanwhile. Nothing
// that anybody wrote is lost: where two changed the same note, there are two afterwards. No DOM, no HTTP.
/** @import { Note } from './note_shape.js' */
import { noteOf } from './note_shape.js';

/**
 * @typedef {object} Change
 * @property {Note|null} next null: it is deleted
 * @property {string} base the note as the server had it before, as JSON; '' where it had none
 */

/** @typedef {Map<string, Change>} Changes by the note's id */

/**
 * @param {Note[]} kept by the server
 * @param {Changes} changes
 * @returns {Note[]} in the server's order, new ones last
 */
export function withChanges(kept, changes) {
  const known = new Set(kept.map(({ id }) => id));
  const changed = kept.flatMap((note) => {
    const change = changes.get(note.id);
    return !change ? [note] : change.next ? [change.next] : [];
  });
  const added = [...changes].flatMap(([id, { next }]) => (next && !known.has(id) ? [next] : []));
  return [...changed, ...added];
}

/**
 * @param {Note[]} kept what the server has now
 * @param {Changes} changes
 * @param {(name: string) => string} nameOfCopy
 * @returns {{changes: Changes, conflicts: number}} changes that are still to be made, based on what is kept
 */
export function rebased(kept, changes, nameOfCopy) {
  const theirs = new Map(kept.map((note) => [note.id, JSON.stringify(note)]));
  /** @type {Changes} */
  const left = new Map();
  let conflicts = 0;
  for (const [id, { next, base }] of changes) {
    const now = theirs.get(id) ?? '';
    if (now === (next ? JSON.stringify(next) : '')) continue;  // it is so already
    if (now === base) {
      left.set(id, { next, base });
      continue;
    }
    conflicts += 1;
    if (!next) continue;  // deleted here, changed by another: it stays
    if (now === '') {
      left.set(id, { next, base: '' });  // changed here, deleted by another: it comes back
      continue;
    }
    const copy = noteOf(nameOfCopy(next.properties.name), next.properties.text ?? '', next.geometry);
    left.set(copy.id, { next: copy, base: '' });
  }
  return { changes: left, conflicts };
}
