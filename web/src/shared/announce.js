// What changes on the page, said once to screen readers, and the short notes at the bottom of the window.
import { messageOf } from './api.js';
import { byId, h } from './dom.js';
import { button, iconButton } from './icons.js';
import { strings } from './strings.js';

const kSame_ms = 1000;
const kProgress_ms = 5000;

let last_text = '';
let last_ms = 0;

/**
 * Says a text politely. The same text is not said twice at once; running progress is said at most every few seconds, and not
 * while it stands still.
 * @param {string} text
 * @param {{is_progress?: boolean}} [options]
 */
export function announce(text, options = {}) {
  const now_ms = performance.now();
  const passed_ms = now_ms - last_ms;
  if (options.is_progress ? text === last_text || passed_ms < kProgress_ms : text === last_text && passed_ms < kSame_ms) return;
  last_text = text;
  last_ms = now_ms;
  const live = byId('live');
  live.textContent = live.textContent === text ? `${text}\u00a0` : text;  // what stays as it is is read to nobody
}

/**
 * A note that goes away by itself, but not while it is pointed at or has the focus; with at most one action.
 * @param {string} text
 * @param {{action?: {label: string, run: () => void}, duration_ms?: number, is_error?: boolean}} [options]
 * @returns {() => void} closes the note
 */
export function showNote(text, { action, duration_ms = 8000, is_error = false } = {}) {
  /** @type {ReturnType<typeof setTimeout>|undefined} */
  let timer;
  const stay = () => clearTimeout(timer);
  const goLater = () => {
    stay();
    timer = setTimeout(close, duration_ms);
  };
  const close = () => {
    stay();
    note.remove();
  };
  const note = h(
    'div',
    { class: is_error ? 'note note-error' : 'note', on: { pointerenter: stay, focusin: stay, pointerleave: goLater, focusout: goLater } },
    h('span', { class: 'note-text' }, text),
    action && button(action.label, () => {
      action.run();
      close();
    }, { class: 'note-action' }),
    iconButton('close', strings.page.close, close),
  );
  goLater();
  byId('toasts').append(note);
  announce(text);
  return close;
}

/**
 * @param {unknown} error
 */
export function showError(error) {
  showNote(messageOf(error), { is_error: true });
}
