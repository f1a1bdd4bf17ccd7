// Shares a flight: makes a link that opens this one alone, for reading and for a while, lists those that were made, and
// revokes them. Says who can open it: a server that listens to its own machine alone has links for that machine, until it is
// opened to the network from there.
/** @import { Flight, Share } from '../shared/types.js' */
import { addShare, listShares, messageOf, openNetwork, removeShare } from '../shared/api.js';
import { serverAddress } from '../shared/router.js';
import { showDialog } from '../shared/dialogs.js';
import { fill, h, put } from '../shared/dom.js';
import { formatDate } from '../shared/format.js';
import { button, runOnce } from '../shared/icons.js';
import { xmlText } from './connect_files.js';
import { showDownloads } from '../flight/flight_actions.js';
import { addressField } from './links_view.js';
import { qrCode } from './qr_code.js';
import { strings } from '../shared/flight_strings.js';

const kDays = /** @type {(number|null)[]} */ ([1, 7, 30, 365, null]);
const kUsualDays = 30;

/** @param {string} host @returns {boolean} whether it is this computer, for whoever opens it */
export const isLoopback = (host) => /^(localhost|.+\.localhost|127(\.\d+){3}|\[::1\])$/i.test(host);

/**
 * What a website takes to show the map in a frame, at the place that is shown now where the map was moved.
 * @param {Flight} flight
 * @param {string} server its address
 * @param {string} token
 */
function embedField(flight, server, token) {
  const view = new URLSearchParams(location.hash.split('?')[1] ?? '').get('at');
  const address = `${server}/embed/${encodeURIComponent(flight.id)}#token=${token}${view ? `&at=${view}` : ''}`;
  return addressField(strings.share.embed, `<iframe src="${xmlText(address)}" title="${xmlText(flight.name)}" width="800" height="500" style="border:0" loading="lazy" allowfullscreen></iframe>`);
}

/** @param {Flight} flight */
export function showShareDialog(flight) {
  const words = strings.share;
  const body = h('div', { id: 'share-body', 'aria-live': 'polite' }, h('p', { class: 'muted' }, words.loading));
  showDialog('share-dialog', words.title(flight.name), body);
  const showFailure = (/** @type {unknown} */ error) => body.append(h('p', { class: 'callout callout-error', role: 'alert' }, messageOf(error)));
  fillIn(flight, body, showFailure).catch(showFailure);
}

/** @param {Flight} flight @param {HTMLElement} body @param {(error: unknown) => void} showFailure */
async function fillIn(flight, body, showFailure) {
  const words = strings.share;
  const { needs_token, may_open_network, addresses, shares } = await listShares(flight.id);
  const reached_at = isLoopback(location.hostname) ? addresses[0] : serverAddress();
  const server = reached_at ?? serverAddress();
  const is_opened = may_open_network && addresses.length > 0;
  const again = () => fillIn(flight, body, showFailure).catch(showFailure);
  const choice = h(
    'select',
    { id: 'share-days', class: 'field' },
    ...kDays.map((days) => h('option', { value: String(days), selected: days === kUsualDays }, words.days(days))),
  );
  const made = h('div', { id: 'share-made' });
  const make = button(words.make, () => runOnce(make, async () => {
    const share = await addShare(flight.id, choice.value === 'null' ? null : Number(choice.value));
    await again();
    const link = `${server}/#/flights/${encodeURIComponent(flight.id)}?token=${share.token}`;
    // On a phone beside this computer it is read off the screen.
    const code = is_opened ? await qrCode(link, words.code).catch(() => null) : null;  // the link is there all the same
    fill(/** @type {HTMLElement} */ (body.querySelector('#share-made')), [h('p', { class: 'muted' }, words.once), addressField(reached_at ? words.link : words.link_local, link), code, embedField(flight, server, share.token)]);
  }, showFailure), { class: 'button primary', id: 'share-make' });
  put(
    body,
    h('p', { id: 'share-who' }, reached_at ? words.text : words.local),
    reached_at && !needs_token && h('p', { class: 'callout callout-warning', id: 'share-open' }, words.open),
    is_opened && h('p', { class: 'muted', id: 'share-network' }, words.opened(addresses[0])),
    h('div', { class: 'share-row' }, h('label', { for: 'share-days' }, words.expiry), choice, make),
    made,
    !reached_at && localPart(flight, may_open_network ? openButton(again, showFailure) : null),
    shares.length > 0 && h('h3', { class: 'share-heading' }, words.active),
    shares.length > 0 && h('ul', { class: 'shares' }, ...shares.map((share) => shareRow(flight, share, again, showFailure))),
  );
}

/** @param {() => Promise<void>} again @param {(error: unknown) => void} showFailure */
function openButton(again, showFailure) {
  const open = button(strings.share.open_network, () => runOnce(open, async () => {
    await openNetwork();
    await again();
    document.getElementById('share-make')?.focus();
  }, showFailure), { id: 'share-open-network' });
  return open;
}

/**
 * How others see it all the same.
 * @param {Flight} flight
 * @param {HTMLElement|null} open lets them; null: not from here
 */
function localPart(flight, open) {
  const words = strings.share;
  const file = button(words.choose_file, () => {
    file.closest('dialog')?.close();
    showDownloads(flight, []);
  }, { id: 'share-file' });
  return h(
    'div',
    { id: 'share-local' },
    h('p', { class: 'muted' }, open ? words.open_network_hint : words.ask_operator),
    open && h('p', { class: 'row' }, open),
    flight.tilejson && h('p', { class: 'row' }, h('span', { class: 'muted' }, words.local_file), file),
  );
}

/** @param {Flight} flight @param {Share} share @param {() => Promise<void>} again @param {(error: unknown) => void} showFailure */
function shareRow(flight, share, again, showFailure) {
  const words = strings.share;
  const text = words.row(formatDate(share.created_at), share.expires_at ? formatDate(share.expires_at) : null);
  const revoke = button(words.revoke, () => runOnce(revoke, async () => {
    await removeShare(flight.id, share.id);
    await again();
  }, showFailure), { 'aria-label': `${words.revoke}: ${text}` });
  return h('li', {}, h('span', {}, text), revoke);
}
