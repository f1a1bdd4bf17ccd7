// One file to the server, by tus 1.0, the protocol of resumable uploads: what has arrived stays, and after a
// broken connection, a reload of the page or a restart of the server the same file goes on where it stopped.
import { authorization } from '../shared/token.js';
import { ApiError, problem } from '../shared/api.js';
import { at } from '../shared/router.js';
import { strings } from '../shared/strings.js';
import { isArchive } from './drop_files.js';

// Smaller files go with the request that announces them; larger ones after it, so that a cut loses nothing.
const kSmallFile_bytes = 512 * 1024;
// A line that is cut without a word, or a server that is stopped, never answers: after this long without a byte the
// file is tried again.
const kSilence_ms = 60_000;
// But for an archive that is there whole: the server answers when it has unpacked it.
const kUnpacking_ms = 30 * 60_000;

/**
 * @param {string} name
 * @param {number} bytes of the file
 * @param {number|null} sent_bytes of it; null where an earlier attempt may have sent all
 * @returns {number} how long no answer is waited for
 */
export const patience_ms = (name, bytes, sent_bytes) => (isArchive(name) && (sent_bytes ?? bytes) >= bytes ? kUnpacking_ms : kSilence_ms);

/**
 * @param {string} flight_id
 * @param {string} name
 * @param {File|Blob} file
 * @param {(sent_bytes: number, from_bytes: number) => void} on_progress from_bytes: what the server had before
 * @param {AbortSignal} signal stops the sending; the server keeps what it has
 * @returns {Promise<void>}
 */
export async function sendFile(flight_id, name, file, on_progress, signal) {
  const tus = await loadTus();
  if (signal.aborted) throw stopped();
  return new Promise((resolve, reject) => {
    const when = file instanceof File ? file.lastModified : 0;
    let from_bytes = 0;
    let silence = 0;
    const heard = (/** @type {number|null} */ arrived_bytes) => {
      clearTimeout(silence);
      silence = window.setTimeout(() => {
        upload.abort().catch(() => {});  // nothing was under way yet
        reject(new ApiError(0, strings.errors.silent));
      }, patience_ms(name, file.size, arrived_bytes));
    };
    const end = (/** @type {() => void} */ settle) => {
      clearTimeout(silence);
      settle();
    };
    const upload = new tus.Upload(file, {
      endpoint: at('/api/v1/uploads'),
      headers: authorization(),
      metadata: { flight: flight_id, filename: name },
      fingerprint: async () => ['skyquilt', flight_id, name, file.size, when].join('|'),
      uploadDataDuringCreation: file.size <= kSmallFile_bytes,
      removeFingerprintOnSuccess: true,
      retryDelays: null,  // the queue knows best when to try again
      onAfterResponse: (request, response) => {
        heard(0);
        if (request.getMethod() !== 'HEAD') return;
        // Whoever does not say what there is of the file takes nothing of it: tus by itself would begin it anew.
        const refusal = problem(response.getStatus(), response.getBody());
        if (refusal.is_away || refusal.status === 401) throw refusal;
        from_bytes = Number(response.getHeader('Upload-Offset') ?? 0) || 0;
      },
      onProgress: (sent_bytes) => {
        heard(sent_bytes);
        on_progress(sent_bytes, from_bytes);
      },
      onError: (error) => end(() => reject(asApiError(error, tus))),
      onSuccess: () => end(resolve),
    });
    signal.addEventListener(
      'abort',
      () => {
        clearTimeout(silence);
        upload.abort().catch(() => {});  // nothing was under way yet
        reject(stopped());
      },
      { once: true },
    );
    upload.findPreviousUploads().then((earlier) => {
      if (signal.aborted) return;
      heard(earlier.length > 0 ? null : 0);
      if (earlier.length > 0) upload.resumeFromPreviousUpload(earlier[0]);
      upload.start();
    }, reject);
  });
}

const stopped = () => new DOMException('upload stopped', 'AbortError');

let failures = 0;

/** With the first file: who only looks at maps does without. @returns {Promise<typeof import('../../vendor/tus.mjs')>} */
async function loadTus() {
  try {
    // Browsers before 2026 never ask again for a module that they could not have: it is another by its address.
    return await import(`../../vendor/tus.mjs${failures > 0 ? `?again=${failures}` : ''}`);
  } catch (error) {
    failures += 1;
    console.debug('tus', error);
    throw new ApiError(0, strings.errors.unreachable);
  }
}

/** @param {Error} error @param {Awaited<ReturnType<typeof loadTus>>} tus @returns {Error} */
function asApiError(error, tus) {
  if (!(error instanceof tus.DetailedError)) return error;
  if (error.causingError instanceof ApiError) return error.causingError;
  const answer = error.originalResponse;
  return answer ? problem(answer.getStatus(), answer.getBody()) : new ApiError(0, strings.errors.unreachable);
}
