// English: notes and measurements that are kept with a flight.
import { number } from '../../shared/language.js';

export const note_words = {
  heading: 'Notes and measurements',
  count: (/** @type {number} */ n) => `(${number(n)})`,
  none: 'Nothing noted yet. Add a note, or measure on the map and save it here.',
  add: 'Add note',
  edit: (/** @type {string} */ name) => `Edit ${name}`,
  remove: (/** @type {string} */ name) => `Delete ${name}`,
  show: (/** @type {string} */ name) => `Show ${name} on the map`,
  removed: (/** @type {string} */ name) => `${name} was deleted.`,
  name: 'Name',
  text: 'Text',
  place: 'Click the map where the note belongs, or drag its mark.',
  at_centre: 'Use map centre',
  mark: 'Place of the note',
  too_long: 'This is too long.',
  keep: 'Save with the flight',
  kept: (/** @type {string} */ name) => `${name} is saved with the flight, under Notes and measurements.`,
  saved: 'Everyone who opens this flight can see them.',
  saving: 'Saving \u2026',
  waiting: (/** @type {string} */ why) => `Not on the server yet. Kept in this browser and sent again: ${why}`,
  failed: (/** @type {string} */ why) => `Not on the server. Kept in this browser: ${why}`,
  merged: 'Someone else changed the same notes in the meantime. Both versions are kept.',
  own_copy: (/** @type {string} */ name) => `${name} (my version)`,
  file_name: 'notes',
  unread: (/** @type {string} */ why) => `The notes could not be read: ${why}`,
};
