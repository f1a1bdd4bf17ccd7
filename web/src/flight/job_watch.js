// Follows a job until it ends: polls every second, more slowly while the server does not answer.
/** @import { Job } from '../shared/types.js' */
import { ApiError, getJob } from '../shared/api.js';

/**
 * @param {string} job_id
 * @param {{on_job: (job: Job) => void, on_lost: () => void, on_gone: () => void}} listener
 *   on_lost: no answer, still trying; on_gone: the server no longer knows the job
 * @param {AbortSignal} signal stops the watching
 */
export async function watchJob(job_id, listener, signal) {
  let delay_ms = 1000;
  while (!signal.aborted) {
    try {
      const job = await getJob(job_id, signal);
      if (signal.aborted) return;
      listener.on_job(job);
      if (isOver(job)) return;
      delay_ms = 1000;
    } catch (error) {
      if (signal.aborted) return;
      if (!(error instanceof ApiError)) throw error;
      if (!error.is_passing) {
        listener.on_gone();
        return;
      }
      listener.on_lost();
      delay_ms = Math.min(delay_ms * 1.5, 10_000);
    }
    await new Promise((resolve) => setTimeout(resolve, delay_ms));
  }
}

/** @param {{state: string}} work a job, or an export */
export const isOver = ({ state }) => ['successful', 'failed', 'dismissed'].includes(state);

/** Does it move the map that is there, rather than make one? @param {Job|null|undefined} job */
export const movesMap = (job) => job?.options?.place !== undefined;
