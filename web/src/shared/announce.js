// What changes on the page, said once to screen readers, and the short notes at the bottom of the window.
import { messageOf } from './api.js';
import { byId, h } from './dom.js';
import { button, icon } from './icons.js';
import { strings } from './strings.js';

let last_text = '';
let last_ms = 0;

/**
 * Says a text politely. The same text is not said twice; running progress is said at most every few seconds.
 * @param {string} text
 * @param {{is_progress?: boolean}} [options]
 */
export function announce(text, options = {}) {
  const now_ms = performance.now();
  if (text === last_text || (options.is_progress && now_ms - last_ms < 5000)) return;
  last_text = text;
  last_ms = now_ms;
  byId('live').textContent = text;
}

/**
 * A note that goes away by itself, with at most one action.
 * @param {string} text
 * @param {{action?: {label: string, run: () => void}, on_close?: () => void, duration_ms?: number,
 *          is_error?: boolean}} [options]
 * @returns {() => void} closes the note
 */
export function showNote(text, options = {}) {
  let closed = false;
  const close = () => {
    if (closed) return;
    closed = true;
    clearTimeout(timer);
    note.remove();
    options.on_close?.();
  };
  const action = options.action;
  const note = h(
    'div',
    { class: options.is_error ? 'note note-error' : 'note' },
    h('span', { class: 'note-text' }, text),
    action && button(action.label, () => {
      action.run();
      close();
    }, { class: 'note-action' }),
    h('button', { type: 'button', class: 'icon-button', 'aria-label': strings.page.close, on: { click: close } }, icon('close')),
  );
  const timer = setTimeout(close, options.duration_ms ?? 8000);
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
