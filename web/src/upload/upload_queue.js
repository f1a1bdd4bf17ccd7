// UploadQueue: sends files, a few at a time, with progress, pause, and patience with a poor connection.
// Knows nothing of the page or of HTTP: the sender is handed in. Emits 'change' whenever the picture changed.

/**
 * @typedef {object} UploadItem
 * @property {string} name
 * @property {File|Blob} file
 * @property {number} bytes
 * @property {'waiting'|'sending'|'done'|'failed'} state
 * @property {boolean} was_there already on the server with the same size
 * @property {number} sent_bytes
 * @property {number} attempts
 * @property {string} reason why it failed
 */

/**
 * @callback SendFile
 * @param {UploadItem} item
 * @param {(sent_bytes: number) => void} on_progress
 * @param {AbortSignal} signal
 * @returns {Promise<void>}
 */

/**
 * @typedef {object} UploadOptions
 * @property {number} [parallel] files in flight at once
 * @property {number} [max_attempts] tries per file when the failure may pass
 * @property {number} [retry_delay_ms] before the second try; doubles with each, up to 15 s
 * @property {() => number} [now_ms]
 */

/**
 * @typedef {object} UploadPicture
 * @property {number} files
 * @property {number} done
 * @property {number} failed
 * @property {number} was_there
 * @property {number} bytes
 * @property {number} sent_bytes
 * @property {number} bytes_per_s over the last seconds; 0 when unknown
 * @property {number|null} left_s
 * @property {'running'|'paused'|'stopped'|'finished'} state
 */

const kWindow_ms = 8000;
// Seven tries with these pauses outlast a restart of the server or a walk around the truck.
const kLongestDelay_ms = 15_000;

export class UploadQueue extends EventTarget {
  /** @type {UploadItem[]} */
  items = [];
  /** @type {'running'|'paused'|'stopped'|'finished'} */
  #state = 'paused';
  #aborts = new Map();
  /** @type {{at_ms: number, sent_bytes: number}[]} */
  #history = [];

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
    this.now_ms = options.now_ms ?? (() => performance.now());
    this.#append(files);
  }

  /** @param {{name: string, file: File|Blob}[]} files */
  #append(files) {
    for (const { name, file } of files) {
      this.items.push({
        name,
        file,
        bytes: file.size,
        state: 'waiting',
        was_there: false,
        sent_bytes: 0,
        attempts: 0,
        reason: '',
      });
    }
  }

  /**
   * More files for the same flight; a file of the same name replaces the one that was to be sent.
   * @param {{name: string, file: File|Blob}[]} files
   */
  add(files) {
    const names = new Set(files.map(({ name }) => name));
    this.items = this.items.filter((item) => item.state === 'sending' || !names.has(item.name));
    this.#append(files);
    if (this.#state === 'running' || this.#state === 'finished') this.start();
    else this.#changed();
  }

  /**
   * Files that the server already holds whole need not be sent again.
   * @param {Map<string, number>} stored name to size
   */
  skipStored(stored) {
    for (const item of this.items) {
      if (item.state === 'waiting' && stored.get(item.name) === item.bytes) {
        item.state = 'done';
        item.was_there = true;
        item.sent_bytes = item.bytes;
      }
    }
    this.#changed();
  }

  start() {
    if (this.#state === 'stopped') return;
    this.#state = 'running';
    this.#history = [];
    this.#pump();
    this.#changed();
  }

  pause() {
    if (this.#state !== 'running') return;
    this.#state = 'paused';
    this.#abortAll();
    this.#changed();
  }

  stop() {
    this.#state = 'stopped';
    this.#abortAll();
    this.#changed();
  }

  retryFailed() {
    for (const item of this.items) {
      if (item.state === 'failed') Object.assign(item, { state: 'waiting', attempts: 0, reason: '', sent_bytes: 0 });
    }
    this.start();
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
    const speed = this.#speed();
    return {
      files: this.items.length,
      ...count,
      bytes,
      sent_bytes: sent,
      bytes_per_s: speed,
      left_s: speed > 0 && this.#state === 'running' ? (bytes - sent) / speed : null,
      state: this.#state,
    };
  }

  #abortAll() {
    for (const [item, abort] of this.#aborts) {
      Object.assign(item, { state: 'waiting', sent_bytes: 0, attempts: 0 });
      abort.abort();
    }
    this.#aborts.clear();
  }

  #pump() {
    while (this.#state === 'running' && this.#aborts.size < this.parallel) {
      const item = this.items.find((candidate) => candidate.state === 'waiting');
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
    item.attempts += 1;
    try {
      if (item.attempts > 1) await wait(Math.min(kLongestDelay_ms, this.retry_delay_ms * 2 ** (item.attempts - 2)), abort.signal);
      await this.send(item, (sent) => this.#progress(item, abort, sent), abort.signal);
      if (abort.signal.aborted) return;
      item.state = 'done';
      item.sent_bytes = item.bytes;
    } catch (error) {
      if (abort.signal.aborted) return;  // paused or stopped: the item is waiting again
      item.sent_bytes = 0;
      const passing = Boolean(/** @type {any} */ (error)?.is_passing);
      item.state = passing && item.attempts < this.max_attempts ? 'waiting' : 'failed';
      item.reason = error instanceof Error ? error.message : String(error);
    }
    this.#aborts.delete(item);
    this.#changed();
    this.#pump();
  }

  /** @param {UploadItem} item @param {AbortController} abort @param {number} sent_bytes */
  #progress(item, abort, sent_bytes) {
    if (abort.signal.aborted) return;
    item.sent_bytes = sent_bytes;
    this.#changed();
  }

  #changed() {
    const sent = this.items.reduce((sum, item) => sum + (item.was_there ? 0 : item.sent_bytes), 0);
    const at_ms = this.now_ms();
    this.#history.push({ at_ms, sent_bytes: sent });
    while (this.#history.length > 2 && at_ms - this.#history[0].at_ms > kWindow_ms) this.#history.shift();
    this.dispatchEvent(new Event('change'));
  }

  #speed() {
    const first = this.#history[0];
    const last = this.#history[this.#history.length - 1];
    if (!first || last.at_ms - first.at_ms < 500) return 0;
    return Math.max(0, ((last.sent_bytes - first.sent_bytes) / (last.at_ms - first.at_ms)) * 1000);
  }
}

/**
 * @param {number} ms
 * @param {AbortSignal} signal
 * @returns {Promise<void>}
 */
function wait(ms, signal) {
  return new Promise((resolve, reject) => {
    const timer = setTimeout(resolve, ms);
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
