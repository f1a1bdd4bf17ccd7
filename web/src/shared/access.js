// Asks for the access token that a shared server requires (token.js) where a request came without a good one.
import { h } from './dom.js';
import { strings } from './strings.js';
import { isTokenHeld, keepToken, pageToken } from './token.js';

let is_asking = false;

/** Prompts for a token, stores it and reloads the page. Once at a time. */
export function askForToken() {
  if (is_asking || isTokenHeld()) return;
  is_asking = true;
  const words = strings.access;
  const input = h('input', { type: 'password', id: 'token-input', class: 'field mono', required: true, autocomplete: 'current-password' });
  const dialog = h(
    'dialog',
    { class: 'dialog', 'aria-label': words.title, id: 'token-dialog' },
    h(
      'form',
      { method: 'dialog' },
      h('label', { for: 'token-input', class: 'dialog-title' }, words.title),
      h('p', { class: 'muted' }, pageToken() ? words.refused : words.hint),
      input,
      h('div', { class: 'dialog-actions' }, h('button', { type: 'submit', class: 'button primary', value: 'go' }, words.go)),
    ),
  );
  dialog.addEventListener('close', () => {
    dialog.remove();
    is_asking = false;
    if (dialog.returnValue !== 'go') return;
    keepToken(input.value.trim());
    location.reload();
  });
  document.body.append(dialog);
  dialog.showModal();
}
