// A document that is changed here at once and sent to the server a moment later: what is said of its saving. Event: 'saved'.
import { ApiError, problem } from './api.js';
import { at } from './router.js';
import { strings } from './strings.js';
import { authorization } from './token.js';

export const kPause_ms = 500;      // until a change is sent
export const kPatience_ms = 5000;  // until a server that was away, or a flight that was being stitched, is asked again

/**
 * @param {string} id of the flight
 * @param {'control'|'notes'} name
 * @param {RequestInit} [init]
 * @returns {Promise<{document: any, etag: string}>}
 */
export async function askDocument(id, name, init = {}) {
  let response;
  try {
    response = await fetch(at(`/api/v1/flights/${encodeURIComponent(id)}/${name}`), { ...init, headers: { ...authorization(), ...init.headers } });
  } catch {
    throw new ApiError(0, strings.errors.unreachable);
  }
  const text = await response.text();
  if (!response.ok) throw problem(response.status, text);
  try {
    return { document: JSON.parse(text), etag: response.headers.get('ETag') ?? '' };
  } catch {
    throw new ApiError(response.status, strings.errors.not_json);
  }
}

export class SavedDocument extends EventTarget {
  /** @type {'saved'|'saving'|'waiting'|'failed'} */
  state = 'saved';
  failure = '';

  /** @param {'saved'|'saving'|'waiting'|'failed'} state @param {string} [failure] in the server's words */
  tell(state, failure = '') {
    this.state = state;
    this.failure = failure;
    this.dispatchEvent(new Event('saved'));
  }
}
