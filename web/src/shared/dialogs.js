// The page's few questions, as native <dialog>s (focus is kept inside and returns by itself).
import { h } from './dom.js';
import { strings } from './strings.js';

/**
 * @param {HTMLDialogElement} dialog
 * @returns {Promise<string>} what was chosen; '' when closed by Escape
 */
export function ask(dialog) {
  document.body.append(dialog);
  dialog.showModal();
  return new Promise((resolve) => {
    dialog.addEventListener('close', () => {
      dialog.remove();
      resolve(dialog.returnValue);
    });
  });
}

/** Leaves the dialog that it stands in. @param {string} [label] @returns {HTMLButtonElement} */
export function closeButton(label = strings.flights.cancel) {
  const button = h('button', { type: 'button', class: 'button', on: { click: () => button.closest('dialog')?.close() } }, label);
  return button;
}

/**
 * Shows something until it is closed.
 * @param {string} id
 * @param {string} title
 * @param {HTMLElement} body
 * @returns {HTMLDialogElement}
 */
export function showDialog(id, title, body) {
  const dialog = h(
    'dialog',
    { class: 'dialog', 'aria-labelledby': `${id}-title`, id },
    h('h2', { id: `${id}-title`, class: 'dialog-title' }, title),
    body,
    h('div', { class: 'dialog-actions' }, closeButton(strings.page.close)),
  );
  void ask(dialog);
  return dialog;
}

/**
 * @param {string} name
 * @returns {Promise<string|null>} the new name, or null
 */
export async function askName(name) {
  const input = h('input', { type: 'text', value: name, maxlength: 200, required: true, id: 'rename-input', class: 'field' });
  const dialog = h(
    'dialog',
    { class: 'dialog', 'aria-label': strings.flights.rename },
    h(
      'form',
      { method: 'dialog' },
      h('label', { for: 'rename-input', class: 'dialog-title' }, strings.flights.rename_label),
      input,
      h(
        'div',
        { class: 'dialog-actions' },
        closeButton(),
        h('button', { type: 'submit', class: 'button primary', value: 'save' }, strings.flights.save),
      ),
    ),
  );
  const chosen = ask(dialog);
  input.select();
  const trimmed = (await chosen) === 'save' ? input.value.trim() : '';
  return trimmed === '' || trimmed === name ? null : trimmed;
}

/**
 * @param {number} count of files
 * @param {string} flight_name
 * @param {boolean} has_map that would be made anew
 * @returns {Promise<'add'|'new'|''>}
 */
export async function askWhereTo(count, flight_name, has_map) {
  const choose = (/** @type {string} */ value) => () => dialog.close(value);
  const dialog = h(
    'dialog',
    { class: 'dialog', 'aria-labelledby': 'where-title' },
    h('h2', { id: 'where-title', class: 'dialog-title' }, strings.drop.choice_title),
    h('p', {}, (has_map ? strings.drop.choice_text : strings.drop.choice_text_first)(count, flight_name)),
    h(
      'div',
      { class: 'dialog-actions' },
      closeButton(),
      h('button', { type: 'button', class: 'button', on: { click: choose('add') } }, strings.drop.choice_add),
      h('button', { type: 'button', class: 'button primary', on: { click: choose('new') } }, strings.drop.choice_new),
    ),
  );
  return /** @type {'add'|'new'|''} */ (await ask(dialog));
}

/**
 * @param {string} name of the flight
 * @returns {Promise<boolean>}
 */
export async function askToRemove(name) {
  const dialog = h(
    'dialog',
    { class: 'dialog', 'aria-labelledby': 'remove-title' },
    h('h2', { id: 'remove-title', class: 'dialog-title' }, strings.trash.title(name)),
    h('p', {}, strings.trash.text),
    h(
      'div',
      { class: 'dialog-actions' },
      closeButton(),
      h('button', { type: 'button', class: 'button primary', id: 'remove-confirm', on: { click: () => dialog.close('remove') } }, strings.trash.remove),
    ),
  );
  return (await ask(dialog)) === 'remove';
}
