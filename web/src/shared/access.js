// The access token that a shared server requires. It comes from a share link (#/flights/ID?token=..., which is sent to
// nobody, or ?token=...), and stays for this tab, or from the user, and stays in this browser. Requests carry it in their header; pictures and downloads, which cannot, in their
// address, where the server takes it for reading only.
import { at } from './router.js';
import { h } from './dom.js';
import { strings } from './strings.js';

const kKey = 'skyquilt-token';

/**
 * Keeps the token of a share link, before the first request.
 * @returns {boolean} whether there was one
 */
export function takeSharedToken() {
  const address = new URL(location.href);
  const [route, query = ''] = address.hash.split('?');
  const shared = new URLSearchParams(query).get('token') ?? address.searchParams.get('token');
  if (!shared) return false;
  sessionStorage.setItem(kKey, shared);
  address.searchParams.delete('token');
  const rest = new URLSearchParams(query);
  rest.delete('token');
  address.hash = rest.size > 0 ? `${route}?${decodeURIComponent(rest.toString())}` : route;
  history.replaceState(null, '', address);  // a copied address or a history must not give it away
  return true;
}

/** @type {string|null} */
let held = null;

/**
 * For a page in the frame of another, where the browser may keep nothing: requests carry this token and no other, and
 * nobody is asked for one.
 * @param {string} text '' for none
 */
export function holdToken(text) {
  held = text;
}

const token = () => held ?? sessionStorage.getItem(kKey) ?? localStorage.getItem(kKey) ?? '';

/** @returns {Record<string, string>} headers */
export const authorization = () => (token() ? { Authorization: `Bearer ${token()}` } : {});

/** @param {string} path @returns {string} the same for an <img> or a link */
export function readable(path) {
  return withToken(at(path), token());
}

/** The page's own token, for addresses that are handed out; '' where there is none. */
export const pageToken = () => token();

/** @param {string} address @param {string} bearer @returns {string} */
export const withToken = (address, bearer) => (bearer ? `${address}${address.includes('?') ? '&' : '?'}token=${encodeURIComponent(bearer)}` : address);

let is_asking = false;

/** Prompts for a token, stores it and reloads the page. Once at a time. */
export function askForToken() {
  if (is_asking || held !== null) return;
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
      h('p', { class: 'muted' }, token() ? words.refused : words.hint),
      input,
      h('div', { class: 'dialog-actions' }, h('button', { type: 'submit', class: 'button primary', value: 'go' }, words.go)),
    ),
  );
  dialog.addEventListener('close', () => {
    dialog.remove();
    is_asking = false;
    if (dialog.returnValue !== 'go') return;
    sessionStorage.removeItem(kKey);
    localStorage.setItem(kKey, input.value.trim());
    location.reload();
  });
  document.body.append(dialog);
  dialog.showModal();
}
