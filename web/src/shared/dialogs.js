// The page's few questions, as native <dialog>s (focus is kept inside and returns by itself).
import { byId, h, put } from './dom.js';
import { button } from './icons.js';
import { strings } from './strings.js';

/** What is said stands in the dialog that was opened last: what lies beside that is inert, and read to nobody. */
function moveNotes() {
  const place = [...document.querySelectorAll('dialog[open]')].at(-1) ?? document.body;
  place.append(byId('toasts'), byId('live'));
}

/**
 * @param {HTMLDialogElement} dialog
 * @returns {Promise<string>} what was chosen; '' when closed by Escape
 */
export function ask(dialog) {
  document.body.append(dialog);
  dialog.showModal();
  moveNotes();
  return new Promise((resolve) => {
    dialog.addEventListener('close', () => {
      moveNotes();
      dialog.remove();
      resolve(dialog.returnValue);
    });
  });
}

/** Leaves the dialog that it stands in. @param {string} [label] @returns {HTMLButtonElement} */
export function closeButton(label = strings.flights.cancel) {
  const close = button(label, () => close.closest('dialog')?.close(), { class: 'button' });
  return close;
}

/** @param {string} id @param {string} title @param {...import('./dom.js').Child} content @returns {HTMLDialogElement} */
export const titledDialog = (id, title, ...content) =>
  h('dialog', { class: 'dialog', 'aria-labelledby': `${id}-title`, id }, h('h2', { id: `${id}-title`, class: 'dialog-title' }, title), ...content);

/** Shows something until it is closed. @param {string} id @param {string} title @param {HTMLElement} body @returns {HTMLDialogElement} */
export function showDialog(id, title, body) {
  const dialog = titledDialog(id, title, body, h('div', { class: 'dialog-actions' }, closeButton(strings.page.close)));
  void ask(dialog);
  return dialog;
}

/**
 * @param {string} id
 * @param {string} title
 * @param {string} text
 * @param {{value: string, label: string, id?: string, is_primary?: boolean}[]} ways in their order; value: '' changes nothing
 * @returns {Promise<string>} what was chosen
 */
export function choose(id, title, text, ways) {
  const actions = ways.map(({ value, label, id: own, is_primary }) => button(label, () => dialog.close(value), { id: own, class: is_primary ? 'button primary' : 'button' }));
  const dialog = titledDialog(id, title, h('p', {}, text), h('div', { class: 'dialog-actions' }, ...actions));
  return ask(dialog);
}

/** Where a form says, in sight, what is refused. @param {string} id of what it says @returns {{element: HTMLElement, refuse: (why: string) => void}} refuse: '' takes it back */
export function refusalBox(id) {
  const element = h('div', { 'aria-live': 'assertive' });
  return {
    element,
    refuse(why) {
      put(element, why && h('p', { class: 'callout callout-error', role: 'alert', id }, why));
      if (why) element.scrollIntoView({ block: 'nearest' });
    },
  };
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
      h('div', { class: 'dialog-actions' }, closeButton(), h('button', { type: 'submit', class: 'button primary', value: 'save' }, strings.flights.save)),
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
  const words = strings.drop;
  return /** @type {'add'|'new'|''} */ (await choose('where', words.choice_title, (has_map ? words.choice_text : words.choice_text_first)(count, flight_name), [
    { value: '', label: strings.flights.cancel },
    { value: 'add', label: words.choice_add },
    { value: 'new', label: strings.flights.new_flight, is_primary: true },
  ]));
}

/** @param {string} name of the flight @returns {Promise<boolean>} */
export async function askToRemove(name) {
  return (await choose('remove', strings.trash.title(name), strings.trash.text, [
    { value: '', label: strings.flights.cancel },
    { value: 'remove', label: strings.trash.remove, id: 'remove-confirm', is_primary: true },
  ])) === 'remove';
}
