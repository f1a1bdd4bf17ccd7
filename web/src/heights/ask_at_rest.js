// Asks the server for what belongs to something drawn or pointed at once that rests, and tells of the last answer alone.

/** So long a drawing that is moved by keys must rest. */
export const kRest_ms = 250;

/**
 * @template T
 * @param {number} rest_ms
 * @param {(answer: T|null, error: unknown) => void} tell of the answer, or why there is none
 */
export function askAtRest(rest_ms, tell) {
  let asked = '';  // for this the answer is there or on its way
  /** @type {T|null} */
  let answer = null;
  let timer = 0;
  let abort = new AbortController();
  const drop = () => {
    clearTimeout(timer);
    abort.abort();
    asked = '';
    answer = null;
  };
  const ask = async (/** @type {(signal: AbortSignal) => Promise<T>} */ get, /** @type {AbortSignal} */ signal) => {
    try {
      const found = await get(signal);
      if (signal.aborted) return;
      answer = found;
    } catch (error) {
      if (signal.aborted) return;
      asked = '';  // the next change asks again
      tell(null, error);
      return;
    }
    tell(answer, null);
  };
  return {
    drop,
    /** Null until it is there. */
    get answer() {
      return answer;
    },
    /**
     * @param {string} subject what is asked about
     * @param {(signal: AbortSignal) => Promise<T>} get
     * @returns {boolean} false: its answer is there, or on its way
     */
    about(subject, get) {
      if (subject === asked) return false;
      drop();
      asked = subject;
      abort = new AbortController();
      const { signal } = abort;
      timer = setTimeout(() => void ask(get, signal), rest_ms);
      return true;
    },
  };
}
