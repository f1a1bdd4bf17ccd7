// A document that is changed here at once and sent to the server a moment later: what is said of its saving. Event: 'saved'.

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
