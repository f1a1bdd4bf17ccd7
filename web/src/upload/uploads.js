// The uploads of this page, one per flight. They live on while the user looks at other flights; when every file of
// a flight has arrived, its job is queued.
/** @import { Job } from '../shared/types.js' */
/** @import { ChosenFile, IgnoredFile, Selection } from './drop_files.js' */
/** @import { Verdict } from './verdict.js' */
import * as api from '../shared/api.js';
import { announce, showError } from '../shared/announce.js';
import { sendFile } from './send_file.js';
import { strings } from '../shared/strings.js';
import { UploadQueue } from './upload_queue.js';
import { judge } from './verdict.js';

/** One flight's upload. Emits 'change', and 'job' when the map's job is queued. */
export class UploadSession extends EventTarget {
  /** @type {Job|null} */
  job = null;
  /** @type {IgnoredFile[]} */
  ignored = [];
  /** @type {Verdict|null} what the photos' own records say, soon after the start */
  verdict = null;
  /** @type {ChosenFile[]} */
  #files = [];
  #starting = false;

  /** @param {string} flight_id */
  constructor(flight_id) {
    super();
    this.flight_id = flight_id;
    this.queue = new UploadQueue([], (item, on_progress, signal) =>
      sendFile(flight_id, item.name, item.file, on_progress, signal),
    );
    this.queue.addEventListener('change', () => {
      this.dispatchEvent(new Event('change'));
      const { state, failed, done } = this.queue.picture;
      if (state === 'finished' && failed === 0 && done > 0) void this.startJob();
    });
  }

  /** @param {Selection} selection */
  async add(selection) {
    this.ignored.push(...selection.ignored);
    this.#files.push(...selection.chosen);
    judge(this.#files).then((verdict) => {
      this.verdict = verdict;
      this.dispatchEvent(new Event('change'));
    }, showError);
    this.queue.add(selection.chosen);
    const stored = new Map((await api.listFiles(this.flight_id)).map((file) => [file.name, file.bytes]));
    this.queue.skipStored(stored);
    this.queue.start();
  }

  /** Queues the flight's job: by itself when all has arrived, or when the user goes on without the failed files. */
  async startJob() {
    if (this.#starting) return;
    this.#starting = true;
    try {
      announce(strings.upload.done);
      this.job = await api.startJob(this.flight_id);
      sessions.delete(this.flight_id);
      this.dispatchEvent(new Event('job'));
    } catch (error) {
      this.#starting = false;
      sessions.delete(this.flight_id);
      showError(error);
      this.dispatchEvent(new Event('job'));
    }
  }

  stop() {
    this.queue.stop();
    sessions.delete(this.flight_id);
    this.dispatchEvent(new Event('job'));
  }
}

/** @type {Map<string, UploadSession>} */
const sessions = new Map();

/**
 * @param {string} flight_id
 * @returns {UploadSession|undefined} the upload under way
 */
export const uploadOf = (flight_id) => sessions.get(flight_id);

/** @returns {boolean} whether leaving the page would break an upload */
export const isUploading = () => [...sessions.values()].some(({ queue }) => queue.picture.state === 'running');

/**
 * @param {string} flight_id
 * @param {Selection} selection
 * @returns {UploadSession}
 */
export function startUpload(flight_id, selection) {
  let session = sessions.get(flight_id);
  if (!session) {
    session = new UploadSession(flight_id);
    sessions.set(flight_id, session);
  }
  session.add(selection).catch((error) => {
    showError(error);
    session?.queue.start();  // sending a file twice is harmless: the server replaces it
  });
  return session;
}
