// UploadQueue: sends files, a few at a time, with progress, pause, and patience with a poor connection: while the
// server is away it tries for as long as the page is open. Knows nothing of the page or of HTTP: the sender is handed
// in. Emits 'change' whenever the picture changed.

/**
 * @typedef {object} UploadItem
 * @property {string} name
 * @property {File|Blob} file
 * @property {number} bytes
 * @property {'waiting'|'sending'|'done'|'failed'} state
 * @property {boolean} was_there already on the server with the same size
 * @property {number} sent_bytes never less than before: what was sent is not taken back from the bar
 * @property {number} attempts
 * @property {string} reason why it failed, or why it is tried again
 * @property {number|null} retry_at_ms it waits until then to be tried again
 */

/**
 * @callback SendFile
 * @param {UploadItem} item
 * @param {(sent_bytes: number, from_bytes?: number) => void} on_progress from_bytes: what the server had of the file
 *   before this attempt
 * @param {AbortSignal} signal
 * @returns {Promise<void>} its errors say `is_passing` when another try may do, and `is_away` when the server could
 *   not be reached or is not ready: that passes, however long it takes
 */

/**
 * @typedef {object} UploadOptions
 * @property {number} [parallel] files in flight at once
 * @property {number} [max_attempts] tries per file when the failure may pass and the server is there
 * @property {number} [retry_delay_ms] before the second try; doubles with each, up to 15 s
 * @property {() => number} [now_ms]
 * @property {(name: string) => boolean} [may_differ] of files whose name and size do not say that they are the same: the
 *   sender finds out
 */

/**
 * @typedef {object} UploadPicture
 * @property {number} files
 * @property {number} done
 * @property {number} failed
 * @property {number} was_there
 * @property {number} bytes
 * @property {number} sent_bytes
 * @property {number} bytes_per_s over this connection, over the last seconds; 0 when unknown
 * @property {number|null} left_s
 * @property {{reason: string, at_ms: number}|null} retry everything waits for the next try, and when that is
 * @property {'running'|'paused'|'finished'} state
 */

const kWindow_ms = 8000;
const kLongestDelay_ms = 15_000;

export class UploadQueue extends EventTarget {
  /** @type {UploadItem[]} */
  items = [];
  /** @type {'running'|'paused'|'finished'} */
  #state = 'paused';
  /** @type {Map<UploadItem, AbortController>} */
  #aborts = new Map();
  /** @type {Map<UploadItem, () => void>} those that wait for their next try, and how to end that */
  #sleepers = new Map();
  /** What went over the line since the page is open. */
  #wire_bytes = 0;
  /** @type {{at_ms: number, wire_bytes: number}[]} */
  #history = [];
  #is_held = false;

  /**
   * @param {{name: string, file: File|Blob}[]} files
   * @param {SendFile} send
   * @param {UploadOptions} [options]
   */
  constructor(files, send, options = {}) {
    super();
    this.send = send;
    this.parallel = options.parallel ?? 4;
    this.max_attempts = options.max_attempts ?? 7;
    this.retry_delay_ms = options.retry_delay_ms ?? 1000;
    this.may_differ = options.may_differ ?? (() => false);
    this.now_ms = options.now_ms ?? (() => performance.now());
    this.#append(files);
  }

  /** @param {{name: string, file: File|Blob}[]} files */
  #append(files) {
    for (const { name, file } of files) {
      this.items.push({ name, file, bytes: file.size, state: 'waiting', was_there: false, sent_bytes: 0, attempts: 0, reason: '', retry_at_ms: null });
    }
  }

  /**
   * More files for the same flight; a file of the same name replaces the one that was to be sent, or comes after the one
   * that is on its way.
   * @param {{name: string, file: File|Blob}[]} files
   */
  add(files) {
    const chosen = new Map(files.map(({ name, file }) => [name, file.size]));
    // One that is on its way, or has arrived, is not sent twice.
    const stays = (/** @type {UploadItem} */ { name, state, bytes }) => state === 'sending' || !chosen.has(name) || (state === 'done' && chosen.get(name) === bytes && !this.may_differ(name));
    this.items = this.items.filter(stays);
    const there = new Map(this.items.map(({ name, bytes }) => [name, bytes]));
    const more = files.filter(({ name, file }) => there.get(name) !== file.size);
    this.#append(more);
    if (this.#state === 'running' || this.#state === 'finished') this.#run();
    else this.#changed();
  }

  /**
   * Files that the server already holds whole need not be sent again.
   * @param {Map<string, number>} stored name to size
   */
  skipStored(stored) {
    for (const item of this.items) {
      if (item.state === 'waiting' && !this.may_differ(item.name) && stored.get(item.name) === item.bytes && !this.#isSending(item.name)) {
        item.state = 'done';
        item.was_there = true;
        item.sent_bytes = item.bytes;
      }
    }
    this.#changed();
  }

  /** No further file is begun until `start`. */
  hold() {
    this.#is_held = true;
  }

  start() {
    this.#is_held = false;
    this.#run();
  }

  #run() {
    if (this.#state !== 'running') this.#history = [];
    this.#state = 'running';
    this.#pump();
    this.#changed();
  }

  pause() {
    if (this.#state !== 'running') return;
    this.#state = 'paused';
    this.#abortAll();
    this.#changed();
  }

  retryFailed() {
    for (const item of this.items) {
      if (item.state === 'failed') Object.assign(item, { state: 'waiting', attempts: 0, reason: '' });
    }
    this.start();
  }

  /** Whatever waits for its next try has it now. */
  retryNow() {
    for (const wake of [...this.#sleepers.values()]) wake();
  }

  /** @returns {UploadPicture} */
  get picture() {
    let sent = 0;
    let bytes = 0;
    const count = { done: 0, failed: 0, was_there: 0 };
    for (const item of this.items) {
      bytes += item.bytes;
      sent += Math.min(item.sent_bytes, item.bytes);
      if (item.state === 'done') count.done += 1;
      if (item.state === 'failed') count.failed += 1;
      if (item.was_there) count.was_there += 1;
    }
    const retry = this.#retry();
    const speed = retry ? 0 : this.#speed();
    return {
      files: this.items.length,
      ...count,
      bytes,
      sent_bytes: sent,
      bytes_per_s: speed,
      left_s: speed > 0 && this.#state === 'running' ? (bytes - sent) / speed : null,
      retry,
      state: this.#state,
    };
  }

  #retry() {
    if (this.#sleepers.size === 0 || this.#sleepers.size < this.#aborts.size) return null;
    const [first] = [...this.#sleepers.keys()].sort((a, b) => (a.retry_at_ms ?? 0) - (b.retry_at_ms ?? 0));
    return { reason: first.reason, at_ms: first.retry_at_ms ?? 0 };
  }

  #abortAll() {
    for (const [item, abort] of this.#aborts) {
      Object.assign(item, { state: 'waiting', attempts: 0, retry_at_ms: null });
      abort.abort();
      this.#dropIfReplaced(item);
    }
    this.#aborts.clear();
    this.#sleepers.clear();
  }

  #isSending(/** @type {string} */ name) {
    return [...this.#aborts.keys()].some((item) => item.name === name);
  }

  /** What was chosen later counts. @param {UploadItem} item that is on its way no more */
  #dropIfReplaced(item) {
    if (this.items.some((other) => other !== item && other.name === item.name)) this.items = this.items.filter((other) => other !== item);
  }

  #pump() {
    if (this.#is_held) return;
    while (this.#state === 'running' && this.#aborts.size < this.parallel) {
      // Of two of one name the server numbers what comes last.
      const item = this.items.find(({ name, state }) => state === 'waiting' && !this.#isSending(name));
      if (!item) break;
      void this.#sendOne(item);
    }
    if (this.#state === 'running' && this.#aborts.size === 0) {
      this.#state = 'finished';
      this.#changed();
    }
  }

  /** @param {UploadItem} item */
  async #sendOne(item) {
    const abort = new AbortController();
    this.#aborts.set(item, abort);
    item.state = 'sending';
    try {
      if (item.attempts > 0) await this.#sleep(item, abort.signal);
      item.attempts += 1;
      await this.send(item, this.#progressOf(item, abort), abort.signal);
      if (abort.signal.aborted) return;
      Object.assign(item, { state: 'done', sent_bytes: item.bytes, reason: '' });
      this.#serverIsThere();
    } catch (error) {
      if (abort.signal.aborted) return;  // paused or stopped: the item is waiting again
      const { is_passing, is_away } = /** @type {any} */ (error) ?? {};
      const again = is_away || (is_passing && item.attempts < this.max_attempts);
      item.state = again ? 'waiting' : 'failed';
      item.reason = error instanceof Error ? error.message : String(error);
    }
    this.#aborts.delete(item);
    this.#dropIfReplaced(item);
    this.#changed();
    this.#pump();
  }

  /** @param {UploadItem} item @param {AbortSignal} signal */
  async #sleep(item, signal) {
    const delay_ms = Math.min(kLongestDelay_ms, this.retry_delay_ms * 2 ** Math.min(item.attempts - 1, 20));
    item.retry_at_ms = this.now_ms() + delay_ms;
    try {
      await wait(delay_ms, signal, (wake) => this.#sleepers.set(item, wake));
    } finally {
      this.#sleepers.delete(item);
      item.retry_at_ms = null;
    }
  }

  /** One file has come through: the others need not wait any longer, and an outage does not count in the speed. */
  #serverIsThere() {
    if (this.#sleepers.size === 0) return;
    this.#history = [];
    this.retryNow();
  }

  /** @param {UploadItem} item @param {AbortController} abort */
  #progressOf(item, abort) {
    let counted = 0;
    return (/** @type {number} */ sent_bytes, from_bytes = 0) => {
      if (abort.signal.aborted) return;
      const own_bytes = Math.max(0, sent_bytes - from_bytes);
      this.#wire_bytes += Math.max(0, own_bytes - counted);
      counted = Math.max(counted, own_bytes);
      item.sent_bytes = Math.max(item.sent_bytes, sent_bytes);
      this.#changed();
    };
  }

  #changed() {
    const at_ms = this.now_ms();
    this.#history.push({ at_ms, wire_bytes: this.#wire_bytes });
    while (this.#history.length > 2 && at_ms - this.#history[0].at_ms > kWindow_ms) this.#history.shift();
    this.dispatchEvent(new Event('change'));
  }

  #speed() {
    // Up to now: a line on which nothing moves any more has no speed.
    const now_ms = this.now_ms();
    const first = this.#history.find(({ at_ms }) => now_ms - at_ms <= kWindow_ms);
    const last = this.#history[this.#history.length - 1];
    if (!first || now_ms - first.at_ms < 500) return 0;
    return Math.max(0, ((last.wire_bytes - first.wire_bytes) / (now_ms - first.at_ms)) * 1000);
  }
}

/**
 * @param {number} ms
 * @param {AbortSignal} signal
 * @param {(wake: () => void) => void} on_start gets what ends the waiting early
 * @returns {Promise<void>}
 */
export function wait(ms, signal, on_start = () => {}) {
  return new Promise((resolve, reject) => {
    const timer = setTimeout(resolve, ms);
    on_start(() => {
      clearTimeout(timer);
      resolve();
    });
    signal.addEventListener(
      'abort',
      () => {
        clearTimeout(timer);
        reject(new DOMException('stopped', 'AbortError'));
      },
      { once: true },
    );
  });
}
