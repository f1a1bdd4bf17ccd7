// The uploads of this page, one per flight. They live on while the user looks at other flights; when every file of
// a flight has arrived, its job is queued. One that was stopped keeps its files and can go on.
/** @import { Job, ServerVerdict } from '../shared/types.js' */
/** @import { ChosenFile, IgnoredFile, Selection } from './drop_files.js' */
/** @import { UploadItem } from './upload_queue.js' */
/** @import { Verdict } from './verdict.js' */
import * as api from '../shared/api.js';
import { announce, showError, showNote } from '../shared/announce.js';
import { held, sessions } from './drop_zone.js';
import { confirmCoarse } from '../flight/coarse_map.js';
import { chooseOptions, chosenOptions, forgetChosen } from '../flight/job_options.js';
import { isOver } from '../flight/job_watch.js';
import { sendFile } from './send_file.js';
import { strings } from '../shared/flight_strings.js';
import { token_kept } from '../shared/token.js';
import { isLog } from './drop_files.js';
import { toldApart } from './edited_files.js';
import { forgetUpload, rememberName, rememberUpload } from './upload_memory.js';
import { UploadQueue, wait } from './upload_queue.js';
import { judge } from './verdict.js';

const kLongestDelay_ms = 15_000;
// The server is asked for its verdict after so many files, and again when four times as many are there.
const kFirstVerdict_files = 3;
const kUntilClosed_ms = 600_000;

/** No file fails by it: the next token is waited for as a server that is away is. */
class TokenEnded extends api.ApiError {
  get is_away() {
    return true;
  }
}

const isMissing = (/** @type {unknown} */ error) => error instanceof api.ApiError && error.status === 404;

/** @param {unknown} error @returns {never} */
function askForNextToken(error) {
  if (!(error instanceof api.ApiError) || error.status !== 401) throw error;
  import('../shared/access.js').then(({ askForToken }) => askForToken()).catch(() => undefined);  // the upload says it too
  throw new TokenEnded(error.status, error.message);
}

/** One flight's upload. Emits 'change', and 'job' when the map's job is queued or the upload was stopped. */
export class UploadSession extends EventTarget {
  /** @type {Job|null} */
  job = null;
  /** @type {IgnoredFile[]} */
  ignored = [];
  /** @type {Verdict|null} what the photos' own records say, soon after the start */
  verdict = null;
  /** @type {ServerVerdict|null} what the server makes of the first files */
  server_verdict = null;
  /** @type {string} why the server cannot be told that all is there; '' when nothing is wrong */
  trouble = '';
  /** All is there, and a map is being made without it: the next one is begun when that has ended. */
  waits_for_map = false;
  /** @type {ChosenFile[]} */
  #files = [];
  #starting = false;
  #verdict_from = kFirstVerdict_files;
  #verdict_files = 0;  // that were there when what is known was asked for
  #abort = new AbortController();
  /** Name to size of what the flight has, as far as it is known. @type {Map<string, number>} */
  #there = new Map();
  /** Lists and the like of which another lies in the flight: its name, and that of what was sent. @type {Map<string, string>} */
  #beside = new Map();
  #endTelling = () => {};

  /** @param {string} flight_id */
  constructor(flight_id) {
    super();
    this.flight_id = flight_id;
    this.queue = new UploadQueue(
      [],
      (item, on_progress, signal) => this.#send(item, on_progress, signal).catch(askForNextToken).catch((error) => this.#onRefused(error, signal)),
      { may_differ: isLog },
    );
    this.queue.addEventListener('change', () => {
      this.#changed();
      const { state, failed, done, files } = this.queue.picture;
      // The last verdict comes with the flight itself.
      if (done >= this.#verdict_from && done < files) void this.#askServer(done);
      if (state === 'finished' && failed === 0 && done > 0) void this.startJob();
    });
  }

  /** @type {import('./upload_queue.js').SendFile} */
  async #send(item, on_progress, signal) {
    if (isLog(item.name) && (await this.#isThere(item, signal))) return;
    await sendFile(this.flight_id, item.name, item.file, on_progress, signal);
    this.#there.set(item.name, item.bytes);
  }

  /** @param {UploadItem} item @param {AbortSignal} signal */
  async #isThere(item, signal) {
    const before = item.name;
    const { name, is_there } = await toldApart(this.flight_id, item, this.#there, signal);
    signal.throwIfAborted();
    item.was_there = is_there;
    if (name === before) return is_there;
    item.name = name;
    rememberName(this.flight_id, before, name);
    this.#beside.set(before, name);
    this.#tellBeside();
    return is_there;
  }

  /** Both count, until the old one is deleted. */
  #tellBeside() {
    const words = strings.upload;
    const beside = new Map(this.#beside);
    const [[old, name]] = beside;
    const removeOld = async () => {
      for (const one of beside.keys()) {
        await api.deleteFile(this.flight_id, one).catch((error) => {
          if (!isMissing(error)) throw error;
        });
        this.#beside.delete(one);
        this.#there.delete(one);
      }
      announce(words.old_deleted(beside.size));
    };
    const run = () => void removeOld().catch((error) => {
      showError(error);
      this.#tellBeside();
    });
    this.#endTelling();
    this.#endTelling = showNote(words.beside(old, name, beside.size), { action: { label: words.delete_old(beside.size), run }, duration_ms: kUntilClosed_ms });
  }

  /** @param {unknown} error @param {AbortSignal} signal of the file @returns {Promise<never>} */
  async #onRefused(error, signal) {
    if (isMissing(error) && (await api.getFlight(this.flight_id, signal).then(() => false, isMissing)) && !signal.aborted) this.stopAsGone();
    throw error;
  }

  #changed() {
    this.dispatchEvent(new Event('change'));
  }

  /** @param {number} files that are there now */
  async #askServer(files) {
    this.#verdict_from = 4 * files;
    try {
      const verdict = await api.getVerdict(this.flight_id, this.#abort.signal);
      if (!verdict || files < this.#verdict_files) return;  // nothing yet, or what was asked for later tells more
      this.#verdict_files = files;
      this.server_verdict = verdict;
      this.#changed();
    } catch (error) {
      // Files of which nothing can be said yet (logs before the first photo), or no server: the next time tells.
      console.debug('no verdict', error);
    }
  }

  /** @param {Selection} selection */
  async add(selection) {
    this.ignored = withMore(this.ignored, selection.ignored);
    this.#files = withMore(this.#files, selection.chosen);
    rememberUpload(this.flight_id, selection.chosen);
    this.queue.hold();
    judge(this.#files).then((verdict) => {
      this.verdict = verdict;
      this.#changed();
    }, showError);
    this.queue.add(logsFirst(selection.chosen));
    await this.resume();
  }

  /** Sends what the server does not have. */
  async resume() {
    this.#abort.abort();
    this.#abort = new AbortController();
    const { signal } = this.#abort;
    sessions.set(this.flight_id, this);
    held.delete(this.flight_id);
    this.#starting = false;
    // Not before it is known: what the server has it would keep twice.
    const files = await this.#untilReached(() => api.listFiles(this.flight_id), signal, (error) => error.is_passing);
    if (signal.aborted) return;
    this.#there = new Map(files.map((file) => [file.name, file.bytes]));
    this.queue.skipStored(this.#there);
    this.queue.start();
  }

  /**
   * Tries for as long as the upload is not stopped: a server that is away comes back.
   * @template T
   * @param {() => Promise<T>} ask
   * @param {AbortSignal} signal
   * @param {(error: api.ApiError) => boolean} passes what is waited for
   * @returns {Promise<T>}
   */
  async #untilReached(ask, signal, passes = (error) => error.is_away) {
    for (let delay_ms = 1000; ; delay_ms = Math.min(2 * delay_ms, kLongestDelay_ms)) {
      try {
        const answer = await ask();
        this.trouble = '';
        this.waits_for_map = false;
        return answer;
      } catch (error) {
        signal.throwIfAborted();  // stopped meanwhile: whatever came of it is no failure
        if (!(error instanceof api.ApiError)) throw error;
        this.waits_for_map = error.status === 409 && (await this.#isMapBeingMade(signal));
        signal.throwIfAborted();
        if (!passes(error) && !this.waits_for_map && error.status !== 401) {
          this.trouble = '';
          throw error;
        }
        this.trouble = this.waits_for_map ? strings.upload.after_map : error.message;
        this.#changed();
        await wait(delay_ms, signal);
      }
    }
  }

  /** Is one under way, which takes no more files? @param {AbortSignal} signal */
  async #isMapBeingMade(signal) {
    const { job } = await api.getFlight(this.flight_id, signal).catch(() => ({ job: null }));
    return Boolean(job && !isOver(job));
  }

  /** Queues the flight's job: by itself when all has arrived, or when the user goes on without the failed files. */
  async startJob() {
    if (this.#starting) return;
    this.#starting = true;
    const { signal } = this.#abort;
    /** @type {Map<string, string>} by options */
    const keys = new Map();
    try {
      announce(strings.upload.done);
      this.job = await this.#untilReached(() => this.#beginMap(keys, signal), signal);
    } catch (error) {
      if (signal.aborted) return;
      this.#starting = false;
      showError(error);
    }
    sessions.delete(this.flight_id);
    this.dispatchEvent(new Event('job'));
  }

  /**
   * With what is chosen now: others may have been while a server, or a map, was waited for.
   * @param {Map<string, string>} keys of what was asked for already: the answer alone may be lost
   * @param {AbortSignal} signal
   * @returns {Promise<Job|null>} null: so coarse a map is not meant, the flight waits with its options
   */
  async #beginMap(keys, signal) {
    const meant = await confirmCoarse(this.flight_id, chosenOptions(this.flight_id), { photos_gsd_m: this.server_verdict?.gsd_m || undefined, signal });
    signal.throwIfAborted();
    if (!meant) return null;
    if (meant.any_gsd) chooseOptions(this.flight_id, meant);  // asked once
    const wish = JSON.stringify(meant);
    if (!keys.has(wish)) keys.set(wish, api.newId());
    const job = await api.startJob(this.flight_id, meant, keys.get(wish));
    forgetChosen(this.flight_id, meant);
    forgetUpload(this.flight_id);
    return job;
  }

  /** The flight was deleted elsewhere, which is said once and not of each file. Restored, it takes the rest. */
  stopAsGone() {
    showNote(strings.flights.gone, { is_error: true });
    this.stop();
  }

  /** Until `resume`. @param {{tells?: boolean}} [how] tells: who shows the flight is told by 'job' */
  stop({ tells = true } = {}) {
    this.#abort.abort();
    this.queue.pause();
    sessions.delete(this.flight_id);
    held.set(this.flight_id, this);
    if (tells) this.dispatchEvent(new Event('job'));
  }
}

/**
 * @template {{name: string}} T
 * @param {T[]} before
 * @param {T[]} more in place of those of their names: a folder may be chosen again
 * @returns {T[]}
 */
function withMore(before, more) {
  const names = new Set(more.map(({ name }) => name));
  return [...before.filter(({ name }) => !names.has(name)), ...more];
}

/**
 * Logs are small and tell much: with them the verdict on the first photos is that on the flight.
 * @param {ChosenFile[]} files
 * @returns {ChosenFile[]}
 */
function logsFirst(files) {
  return [...files.filter(({ name }) => isLog(name)), ...files.filter(({ name }) => !isLog(name))];
}

// The line is back, or there is a token again: nobody waits for the next try.
const retryNow = () => {
  for (const { queue } of sessions.values()) queue.retryNow();
};
addEventListener('online', retryNow);
token_kept.addEventListener('change', retryNow);

/**
 * @param {string} flight_id
 * @param {Selection} selection
 * @returns {UploadSession}
 */
export function startUpload(flight_id, selection) {
  const session = sessions.get(flight_id) ?? held.get(flight_id) ?? new UploadSession(flight_id);
  sessions.set(flight_id, session);
  sendAnyway(session, session.add(selection));
  return session;
}

/** @param {UploadSession} session one that was stopped */
export const resumeUpload = (session) => sendAnyway(session, session.resume());

/** Also where the server refuses to say what it has: it says of each file why. @param {UploadSession} session @param {Promise<void>} beginning */
function sendAnyway(session, beginning) {
  beginning.catch((error) => {
    if (error instanceof DOMException && error.name === 'AbortError') return;  // stopped meanwhile
    if (isMissing(error)) {
      session.stopAsGone();
      return;
    }
    showError(error);
    session.queue.start();
  });
}
