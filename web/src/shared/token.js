// The access token that a shared server requires. It comes from a share link (#/flights/ID?token=..., which is sent to
// nobody, or ?token=...), and stays for this tab, or from the user, and stays in this browser. Requests carry it in their
// header; pictures and downloads, which cannot, in their address, where the server takes it for reading only.
// And the answers that the first script asks for while the page's own code is on its way.
import { at } from './router.js';

const kKey = 'skyquilt-token';

/** That the page was opened with. @type {string|null} */
let of_link = null;

/**
 * Keeps the token of a share link, before the first request.
 * @returns {boolean} whether there was one
 */
export function takeSharedToken() {
  const address = new URL(location.href);
  const [route, query = ''] = address.hash.split('?');
  const shared = new URLSearchParams(query).get('token') ?? address.searchParams.get('token');
  if (!shared) return false;
  of_link = shared;
  try {
    sessionStorage.setItem(kKey, shared);
  } catch {
    // A browser that may keep nothing has it until the page is left.
  }
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

export const isTokenHeld = () => held !== null;

/** @param {'sessionStorage'|'localStorage'} where @returns {string|null} also null where the browser may keep nothing */
function keptIn(where) {
  try {
    return window[where].getItem(kKey);
  } catch {
    return null;
  }
}

/** Emits 'change' when one was typed; who has what would be lost with the page prevents that this is loaded anew. */
export const token_kept = new EventTarget();

const linkToken = () => of_link ?? keptIn('sessionStorage');
const token = () => held ?? linkToken() ?? keptIn('localStorage') ?? '';

/** Came the token with a link? Then whoever reads this knows of links, and nothing of tokens. */
export const isFromLink = () => held === null && linkToken() !== null;

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

/**
 * For this browser, in place of any other; where it may keep nothing, until the page is left.
 * @param {string} text
 */
export function keepToken(text) {
  of_link = null;
  try {
    sessionStorage.removeItem(kKey);
    localStorage.setItem(kKey, text);
  } catch {
    of_link = text;
  }
}

/** The page anew, with its token: by its address, which takeSharedToken clears at once, where the browser keeps none. */
export function reloadWithToken() {
  if ((keptIn('sessionStorage') ?? keptIn('localStorage') ?? '') !== token()) history.replaceState(null, '', withToken(location.hash || '#/', token()));
  location.reload();
}

const kYoung_ms = 10_000;

/** @type {Map<string, {answer: Promise<Response>, asked_ms: number}>} */
const asked = new Map();

/**
 * @param {string} path
 * @returns {Promise<any>} the JSON; null where there is none
 */
export async function askEarly(path) {
  const answer = fetch(at(path), { headers: authorization() });
  asked.set(path, { answer, asked_ms: performance.now() });
  try {
    const response = await answer;
    return response.ok ? await response.clone().json() : null;
  } catch {
    return null;  // who takes the answer says so
  }
}

/** @param {string} path @returns {Promise<Response>|null} */
export function takeEarly(path) {
  const found = asked.get(path);
  asked.delete(path);
  return found && performance.now() - found.asked_ms < kYoung_ms ? found.answer : null;
}
