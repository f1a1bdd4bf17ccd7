// The control points of an open flight: changed here at once, sent to the server a moment later, undone step by step.
// Events: 'change' (the points), 'saved' (what the state of saving is).
/** @import { ControlMark, ControlPoint } from './control_lists.js' */
import { ApiError, messageOf } from '../shared/api.js';
import { strings } from '../shared/flight_strings.js';
import { kPatience_ms, kPause_ms, SavedDocument } from '../shared/saved_document.js';

/** @typedef {{reference_system: string, points: ControlPoint[]}} ControlPoints */

const kMaxUndo = 200;
const kKept_px = 1e-3;  // as the server keeps marks

/** Are these the points that the server has? @param {ControlPoints} sent @param {ControlPoints} there */
function isKept(sent, there) {
  if (sent.points.length !== there.points.length) return false;
  if (sent.points.length > 0 && sent.reference_system !== there.reference_system) return false;
  const isSameMark = (/** @type {ControlMark} */ a, /** @type {ControlMark|undefined} */ b) => a.photo === b?.photo && Math.abs(a.x - b.x) < kKept_px && Math.abs(a.y - b.y) < kKept_px;
  return sent.points.every(({ name, x, y, height, marks }, i) => {
    const other = there.points[i];
    // To the server, heights that are zeros alone are none.
    return name === other.name && x === other.x && y === other.y && (height || null) === (other.height || null) && marks.length === other.marks.length && marks.every((mark, k) => isSameMark(mark, other.marks[k]));
  });
}

/** Of each flight one, for as long as the page is there. @type {Map<string, ControlDocument>} */
const documents = new Map();

/** Also of a panel that was closed before the server had all: who opens the points next goes on with them. @param {string} id of the flight */
export function controlOf(id) {
  const control = documents.get(id) ?? new ControlDocument(id);
  documents.set(id, control);
  return control;
}

export class ControlDocument extends SavedDocument {
  /** @type {ControlPoints} */
  #now = { reference_system: '', points: [] };
  /** @type {ControlPoints[]} */
  #before = [];
  #is_dirty = false;
  /** What was sent and not answered, as JSON: the server may have it. @type {Set<string>} */
  #unanswered = new Set();
  /** @type {Promise<void>|null} */
  #saving = null;
  /** What the server does not have yet is not lost without a question. */
  #onLeaving = (/** @type {Event} */ event) => {
    if (this.#is_unsaved) event.preventDefault();
  };

  /** @param {string} id of the flight */
  constructor(id) {
    super(id, 'control', 'auto');
    addEventListener('beforeunload', this.#onLeaving);
  }

  get points() {
    return this.#now.points;
  }
  get reference_system() {
    return this.#now.reference_system;
  }
  get can_undo() {
    return this.#before.length > 0;
  }

  get #is_unsaved() {
    return this.#is_dirty || this.#saving !== null;
  }

  /** The points, as far as they are not here and on their way still. Nothing may be changed before: what the flight has would be overwritten. */
  async load() {
    if (!this.#is_unsaved) return this.#read();
    this.dispatchEvent(new Event('saved'));
    this.dispatchEvent(new Event('change'));
    this.flushLater(0);
  }

  async #read() {
    const before = this.#now;
    const answer = this.get();
    const turn = this.asked;
    const there = await answer;
    if (turn !== this.asked) return;  // saved or read again since then
    // A dialog that was open when a new map came goes on marking.
    const is_changed = this.#now !== before;
    if (is_changed && isKept(before, there)) return;
    this.#now = there;
    this.#before = [];
    this.#is_dirty = false;
    this.tell(is_changed ? 'failed' : 'saved', is_changed ? strings.control.changed_elsewhere : '');
    this.dispatchEvent(new Event('change'));
  }

  /** @param {string} name @returns {ControlPoint|undefined} */
  point(name) {
    return this.points.find((point) => point.name === name);
  }

  /** @param {ControlPoints} next */
  change(next) {
    this.#before.push(this.#now);
    if (this.#before.length > kMaxUndo) this.#before.shift();
    this.#put(next);
  }

  /**
   * @param {string} name
   * @param {string} photo
   * @param {{x: number, y: number}|null} pixel null: none there any more
   */
  mark(name, photo, pixel) {
    const points = this.points.map((point) => {
      if (point.name !== name) return point;
      const at = point.marks.findIndex((mark) => mark.photo === photo);
      /** @type {ControlMark[]} */
      const others = point.marks.filter((_, i) => i !== at);
      return { ...point, marks: pixel ? [...others.slice(0, at < 0 ? others.length : at), { photo, ...pixel }, ...others.slice(at < 0 ? others.length : at)] : others };
    });
    this.change({ ...this.#now, points });
  }

  undo() {
    const before = this.#before.pop();
    if (before) this.#put(before);
  }

  /** @param {ControlPoints} next */
  #put(next) {
    this.#now = next;
    this.#is_dirty = true;
    this.tell('saving');
    this.dispatchEvent(new Event('change'));
    this.flushLater(kPause_ms);
  }

  /** Fails where the server did not take it. */
  async flush() {
    this.endPause();
    while (this.#saving) await this.#saving.catch(() => undefined);
    if (!this.#is_dirty) return;
    this.#saving = this.#save();
    try {
      await this.#saving;
    } finally {
      this.#saving = null;
    }
    if (this.#is_dirty) await this.flush();
  }

  /**
   * In place of what was there the last time, or of what was sent since then: on a poor line the answer alone may be lost.
   * @param {ControlPoints} next
   * @returns {Promise<ControlPoints>} as they are stored
   */
  async #send(next) {
    try {
      const stored = await this.replace('application/json', next);
      this.#unanswered.clear();
      return stored;
    } catch (error) {
      if (error instanceof ApiError && error.is_passing) this.#unanswered.add(JSON.stringify(next));
      if (!(error instanceof ApiError && error.status === 412) || this.#unanswered.size === 0) throw error;
      const there = await this.get();
      const is_own = [...this.#unanswered].some((sent) => isKept(JSON.parse(sent), there));
      this.#unanswered.clear();
      if (!is_own) throw error;
      return this.#send(next);
    }
  }

  async #save() {
    const sent = this.#now;
    this.#is_dirty = false;
    const points = sent.points.map(({ name, x, y, height, marks }) => ({ name, x, y, height, marks }));
    try {
      const stored = await this.#send({ reference_system: sent.reference_system, points });
      // Where points lie on Earth the server says; marks may have been set meanwhile.
      const placed = new Map(stored.points.map((point) => [point.name, point]));
      this.#now = { ...this.#now, points: this.points.map((point) => {
        const said = placed.get(point.name);
        return said && said.x === point.x && said.y === point.y ? { ...point, lon: said.lon, lat: said.lat } : point;
      }) };
      if (!this.#is_dirty) this.tell('saved');
      this.dispatchEvent(new Event('change'));
    } catch (error) {
      await this.#onRefused(error);
      throw error;
    }
  }

  /** @param {unknown} error */
  async #onRefused(error) {
    const status = error instanceof ApiError ? error.status : -1;
    if (status === 412) {
      // Somebody else was first: what is there now is shown.
      await this.#read().catch(() => undefined);
      this.tell('failed', strings.control.changed_elsewhere);
      return;
    }
    this.#is_dirty = true;
    const is_passing = status === 409 || (error instanceof ApiError && error.is_passing);
    this.tell(is_passing ? 'waiting' : 'failed', messageOf(error));
    if (is_passing) this.flushLater(kPatience_ms);
  }

  /** Saves what is left; what the server does not take now is sent later. */
  close() {
    void this.flush().catch(() => undefined);
  }
}
