// Asks for the access token that a shared server requires (token.js) where a request came without a good one. Who came by a
// link is told that it is over: a token is asked for where one is at hand.
import { ask } from './dialogs.js';
import { h } from './dom.js';
import { strings } from './strings.js';
import { isFromLink, isTokenHeld, keepToken, pageToken, reloadWithToken, token_kept } from './token.js';

let is_asking = false;
/** The dialog was closed: what asks the server by itself, again and again, does not open it until somebody does something. */
let is_declined = false;
for (const act of ['click', 'keydown', 'drop']) addEventListener(act, () => (is_declined = false), { capture: true });

/** Prompts for a token and stores it. Once at a time. The page is loaded anew with it, unless something would be lost. */
export function askForToken() {
  if (is_asking || is_declined || isTokenHeld()) return;
  is_asking = true;
  const words = strings.access;
  const is_link = isFromLink();
  const title = is_link ? words.link_title : words.title;
  const input = h('input', { type: 'password', id: 'token-input', class: 'field mono', required: true, autocomplete: 'current-password' });
  const dialog = h(
    'dialog',
    { class: 'dialog', 'aria-label': title, id: 'token-dialog' },
    h(
      'form',
      { method: 'dialog' },
      is_link ? h('h2', { class: 'dialog-title' }, title) : h('label', { for: 'token-input', class: 'dialog-title' }, title),
      h('p', { class: 'muted' }, is_link ? words.link_over : pageToken() ? words.refused : words.hint),
      is_link && h('label', { for: 'token-input', class: 'small-label' }, words.link_token),
      input,
      h('div', { class: 'dialog-actions' }, h('button', { type: 'submit', class: 'button primary', value: 'go' }, words.go)),
    ),
  );
  void ask(dialog).then((choice) => {
    is_asking = false;
    is_declined = choice !== 'go';
    if (is_declined) return;
    keepToken(input.value.trim());
    const may_reload = token_kept.dispatchEvent(new Event('change', { cancelable: true }));
    if (may_reload) reloadWithToken();
  });
}
