// The notes of an open flight: changed here at once, kept in this browser until the server has them, sent a moment later.
// Events: 'change' (the notes), 'saved' (what the state of saving is), 'merged' (others had changed the same notes).
/** @import { Changes } from './note_merge.js' */
/** @import { Note } from './note_shape.js' */
import { ApiError, messageOf } from '../shared/api.js';
import { strings } from '../shared/flight_strings.js';
import { kPatience_ms, kPause_ms, SavedDocument } from '../shared/saved_document.js';
import { rebased, withChanges } from './note_merge.js';

const kMaxTurns = 5;  // of others who save at the same moment

const memoryKey = (/** @type {string} */ id) => `skyquilt.notes.${id}`;

/** @param {string} id of the flight @returns {Changes} that a page left behind */
function remembered(id) {
  try {
    return new Map(JSON.parse(localStorage.getItem(memoryKey(id)) ?? '[]'));
  } catch (error) {
    console.debug('no notes remembered', error);
    return new Map();
  }
}

export class NoteDocument extends SavedDocument {
  /** @type {Note[]} */
  #kept = [];
  /** @type {Changes} */
  #changes = new Map();
  /** @type {Promise<void>|null} */
  #saving = null;
  /** Whose changes this browser keeps for this document; others are of another tab. @type {Set<string>} */
  #own = new Set();
  #is_closed = false;
  #is_read = false;
  #online = () => void (this.#is_read && this.#later(0));

  /** @param {string} id of the flight @param {boolean} may_change */
  constructor(id, may_change) {
    super(id, 'notes', 'low');
    this.may_change = may_change;
    addEventListener('online', this.#online);
  }

  /** @returns {Note[]} */
  get notes() {
    return withChanges(this.#kept, this.#changes);
  }

  /** What the server has, and what was not sent to it the last time. */
  async load() {
    if (this.may_change) this.#changes = remembered(this.id);
    this.#own = new Set(this.#changes.keys());
    await this.#read();
    if (this.#changes.size > 0) this.#later(0);
  }

  /** What others did meanwhile, where nothing is under way here. */
  async refresh() {
    if (this.#changes.size === 0 && !this.#saving) await this.#read();
  }

  async #read() {
    const answer = this.get();
    const turn = this.asked;
    const found = await answer;
    if (!found) throw new ApiError(200, strings.errors.not_json);
    this.#is_read = true;
    if (turn !== this.asked) return;  // saved or read again since then
    this.#kept = found.features;
    const { changes, conflicts } = rebased(this.#kept, this.#changes, strings.notes.own_copy);
    this.#changes = changes;
    this.#remember();
    this.dispatchEvent(new Event('change'));
    if (conflicts > 0) this.dispatchEvent(new Event('merged'));
  }

  /** Adds a note, or puts it in place of the one with its id. @param {Note} note */
  set(note) {
    this.#put(note.id, note);
  }

  /** @param {string} id */
  remove(id) {
    this.#put(id, null);
  }

  /** @param {string} id @param {Note|null} next */
  #put(id, next) {
    const known = this.#kept.find((note) => note.id === id);
    const base = this.#changes.get(id)?.base ?? (known ? JSON.stringify(known) : '');
    // One that is being sent this moment may be there when it is removed.
    if (next || base || this.#saving) this.#changes.set(id, { next, base });
    else this.#changes.delete(id);
    this.#remember();
    this.dispatchEvent(new Event('change'));
    this.tell('saving');
    this.#later(kPause_ms);
  }

  #remember() {
    const others = [...remembered(this.id)].filter(([id]) => !this.#own.has(id) && !this.#changes.has(id));
    const kept = [...others, ...this.#changes];
    this.#own = new Set(this.#changes.keys());
    try {
      if (kept.length > 0) localStorage.setItem(memoryKey(this.id), JSON.stringify(kept));
      else localStorage.removeItem(memoryKey(this.id));
    } catch (error) {
      console.debug('the browser keeps no more', error);  // the page still has them
    }
  }

  /** @param {number} pause_ms */
  #later(pause_ms) {
    if (!this.#is_closed) this.flushLater(pause_ms);
  }

  async flush() {
    this.endPause();
    while (this.#saving) await this.#saving;
    this.#saving = this.#save().catch((error) => this.#onRefused(error));
    await this.#saving;
    this.#saving = null;
  }

  async #save() {
    for (let turn = 1; this.#changes.size > 0; turn += 1) {
      this.tell('saving');
      const sent = this.#changes;
      this.#changes = new Map(sent);
      try {
        /** @type {Note[]} */
        const notes = (await this.replace('application/geo+json', { type: 'FeatureCollection', features: withChanges(this.#kept, sent) })).features;
        this.#kept = notes;
        for (const [id, { next }] of sent) {
          if (this.#changes.get(id)?.next !== next) {
            const known = notes.find((note) => note.id === id);
            const later = this.#changes.get(id);
            if (later) later.base = known ? JSON.stringify(known) : '';
          } else this.#changes.delete(id);
        }
        this.#remember();
      } catch (error) {
        if (!(error instanceof ApiError && error.status === 412) || turn === kMaxTurns) throw error;
        await this.#read();
      }
    }
    this.tell('saved');
    this.dispatchEvent(new Event('change'));
  }

  /** @param {unknown} error */
  #onRefused(error) {
    const is_passing = error instanceof ApiError && (error.is_passing || error.status === 409 || error.status === 412);
    this.tell(is_passing ? 'waiting' : 'failed', messageOf(error));
    if (is_passing) this.#later(kPatience_ms);
  }

  /** Sends what is left, once; what the server does not take now stays in this browser. */
  close() {
    this.endPause();
    removeEventListener('online', this.#online);
    if (this.#changes.size > 0) void this.flush();
    this.#is_closed = true;
  }
}
