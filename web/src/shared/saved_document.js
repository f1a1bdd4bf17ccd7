// A document that is changed here at once and sent to the server a moment later: what is said of its saving. Event: 'saved'.
import { answerOf, parsed } from './api.js';
import { at } from './router.js';
import { authorization, token_kept } from './token.js';

export const kPause_ms = 500;      // until a change is sent
export const kPatience_ms = 5000;  // until a server that was away, or a flight that was being stitched, is asked again

/** What the server does not have all of, or did not take. @type {Set<SavedDocument>} */
const unsaved = new Set();
// To be loaded anew, whoever asked for the token, would lose it.
token_kept.addEventListener('change', (event) => {
  if (unsaved.size > 0) event.preventDefault();
  for (const document of unsaved) void document.flush().catch(() => undefined);  // what came of it is the state
});

export class SavedDocument extends EventTarget {
  /** @type {'saved'|'saving'|'waiting'|'failed'} */
  state = 'saved';
  failure = '';
  asked = 0;  // of the server, so often: of two answers the one to what was asked later counts, whichever comes first
  #etag = '';
  /** @type {ReturnType<typeof setTimeout>|undefined} */
  #timer = undefined;

  /** @param {string} id of the flight @param {'control'|'notes'} name @param {RequestPriority} priority */
  constructor(id, name, priority) {
    super();
    this.id = id;
    this.name = name;
    this.priority = priority;
  }

  /** What the server has. @param {RequestInit} [init] @returns {Promise<any>} */
  async get(init = {}) {
    const turn = (this.asked += 1);
    const address = at(`/api/v1/flights/${encodeURIComponent(this.id)}/${this.name}`);
    const { response, text } = await answerOf(fetch(address, { priority: this.priority, ...init, headers: { ...authorization(), ...init.headers } })).catch((error) => {
      if (error.status === 401) import('./access.js').then(({ askForToken }) => askForToken()).catch(() => undefined);  // the state says it too
      throw error;
    });
    const document = parsed(response, text);
    if (turn === this.asked) this.#etag = response.headers.get('ETag') ?? '';
    return document;
  }

  /** In place of what was there the last time; 412 where that has changed. @param {string} type @param {object} next @returns {Promise<any>} */
  replace(type, next) {
    return this.get({ method: 'PUT', headers: { 'Content-Type': type, 'If-Match': this.#etag }, body: JSON.stringify(next) });
  }

  /** Sends what was not sent yet. */
  async flush() {}

  /** @param {number} pause_ms */
  flushLater(pause_ms) {
    this.endPause();
    this.#timer = setTimeout(() => void this.flush().catch(() => undefined), pause_ms);  // what came of it is the state
  }

  endPause() {
    clearTimeout(this.#timer);
  }

  /** @param {'saved'|'saving'|'waiting'|'failed'} state @param {string} [failure] in the server's words */
  tell(state, failure = '') {
    this.state = state;
    this.failure = failure;
    unsaved[state === 'saved' ? 'delete' : 'add'](this);
    this.dispatchEvent(new Event('saved'));
  }
}
