// The addresses by which other programs read the map.
/** @import { Flight, TileJson } from '../shared/types.js' */
import { pageToken, withToken } from '../shared/token.js';
import { announce, showError } from '../shared/announce.js';
import { addShare, ownAccess } from '../shared/api.js';
import { connectFiles, josmAddress, saveText } from './connect_files.js';
import { at } from '../shared/router.js';
import { h, put } from '../shared/dom.js';
import { mayChange } from '../flight/flight_words.js';
import { button, icon, iconButton, runOnce } from '../shared/icons.js';
import { strings } from '../shared/flight_strings.js';
import { ownHost } from '../map/tile_addresses.js';

/**
 * @param {string} what
 * @param {string} text
 * @returns {HTMLButtonElement}
 */
export function copyButton(what, text) {
  const copy = iconButton('copy', strings.page.copy(what), async () => {
    try {
      await copyText(text);
    } catch (error) {
      showError(error);
      return;
    }
    announce(strings.page.copied);
    copy.replaceChildren(icon('check'));
    setTimeout(() => copy.replaceChildren(icon('copy')), 1500);
  });
  return copy;
}

/** @param {string} text */
async function copyText(text) {
  // The clipboard API exists on secure origins only, and may be refused; in a field network the page often comes over plain HTTP.
  if (await navigator.clipboard?.writeText(text).then(() => true, () => false)) return;
  const focused = document.activeElement;
  const area = h('textarea', { class: 'visually-hidden', 'aria-hidden': 'true', value: text });
  (document.querySelector('dialog[open]') ?? document.body).append(area);  // what lies behind a dialog cannot be selected
  area.select();
  const is_copied = document.execCommand('copy');
  area.remove();
  if (focused instanceof HTMLElement) focused.focus();
  if (!is_copied) throw new Error(strings.errors.not_copied);
}

/**
 * @param {string} label
 * @param {string} address
 * @returns {HTMLElement}
 */
export function addressField(label, address) {
  const id = `address-${label.toLowerCase().replace(/[^a-z]+/g, '-')}`;
  const input = h('input', { id, class: 'field mono', type: 'text', readonly: true, value: address });
  input.addEventListener('focus', () => input.select());
  return h('div', { class: 'address' }, h('label', { for: id }, label), h('div', { class: 'address-row' }, input, copyButton(label, address)));
}

/**
 * @param {Flight} flight
 * @param {TileJson} tilejson
 * @returns {HTMLElement}
 */
export function linksView(flight, tilejson) {
  const words = strings.links;
  const addresses = h('div', { id: 'map-addresses' });
  void drawAddresses(flight, tilejson, addresses);
  return h(
    'section',
    { class: 'block no-print', 'aria-labelledby': 'links-heading' },
    h('h2', { id: 'links-heading' }, words.heading),
    addresses,
  );
}

/** Tokens of links that were made here for other programs, by flight. @type {Map<string, string>} */
const made_tokens = new Map();

/**
 * Addresses carry a token where the server asks for one: other programs cannot sign in. The page's own where it only
 * reads, like a guest's; never one that may change things.
 * @param {Flight} flight
 * @param {HTMLElement} element shows how to get such a token while there is none
 * @param {() => Promise<void>} again when there is
 * @returns {Promise<string|null>} '' where none is needed, null while there is none
 */
export async function tokenForPrograms(flight, element, again) {
  const access = await ownAccess();
  // A guest's link only reads also where nobody needs a token.
  const is_guest = access?.scope === 'read' && pageToken() !== '';
  const asks = is_guest || (access?.needs_token ?? pageToken() !== '');
  if (!asks) return '';
  const token = access?.scope === 'read' ? pageToken() : (made_tokens.get(flight.id) ?? '');
  if (token) return token;
  put(element, mayChange(flight) ? makeToken(flight, again) : h('p', { class: 'muted' }, strings.links.needs_read_token));
  return null;
}

/**
 * @param {Flight} flight
 * @param {TileJson} tilejson
 * @param {HTMLElement} element
 */
async function drawAddresses(flight, tilejson, element) {
  const words = strings.links;
  const token = await tokenForPrograms(flight, element, () => drawAddresses(flight, tilejson, element));
  if (token === null) return;
  const template = withToken(ownHost(tilejson.tiles[0]), token);
  const settings = connectFiles(flight, tilejson, template).map(({ label, file, text }) =>
    button(words.connect(label), () => saveText(file, text)),
  );
  put(
    element,
    h('div', { class: 'row settings' }, ...settings),
    token && h('p', { class: 'muted' }, words.carries_token),
    addressField(words.xyz, template),
    addressField(words.josm, josmAddress(template, tilejson)),
    addressField(words.tilejson, withToken(new URL(at(flight.tilejson ?? ''), location.origin).href, token)),
  );
}

/** @param {Flight} flight @param {() => Promise<void>} again */
function makeToken(flight, again) {
  const make = button(strings.links.make, () => runOnce(make, async () => {
    made_tokens.set(flight.id, (await addShare(flight.id, null)).token);
    await again();
  }, showError), { id: 'links-make' });
  return h('div', {}, h('p', { class: 'muted' }, strings.links.make_hint), make);
}
