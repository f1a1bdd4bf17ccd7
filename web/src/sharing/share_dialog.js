// Shares a flight: makes a link that opens this one alone, for reading and for a while, lists those that were made, and
// revokes them. Says who can open it: a server that listens to its own machine alone has links for that machine, until it is
// opened to the network from there.
/** @import { Flight, Share } from '../shared/types.js' */
import { addShare, listShares, messageOf, openNetwork, removeShare } from '../shared/api.js';
import { serverAddress } from '../shared/router.js';
import { showDialog } from '../shared/dialogs.js';
import { arrange, h, keptElements, put } from '../shared/dom.js';
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
  const loading = h('p', { class: 'muted' }, words.loading);
  const body = h('div', { id: 'share-body', 'aria-live': 'polite' }, loading);
  showDialog('share-dialog', words.title(flight.name), body);
  const showFailure = (/** @type {unknown} */ error) => {
    for (const before of [loading, body.querySelector('.callout-error')]) before?.remove();
    body.append(h('p', { class: 'callout callout-error', role: 'alert' }, messageOf(error)));
  };
  void showShares(flight, body, showFailure);
}

/**
 * Draws what the server has of them, and again after each change. What can be pressed stays while it is drawn anew, and so
 * does a link that was just made: it is shown once.
 * @param {Flight} flight
 * @param {HTMLElement} body
 * @param {(error: unknown) => void} showFailure
 */
function showShares(flight, body, showFailure) {
  const words = strings.share;
  /** @type {Awaited<ReturnType<typeof listShares>>} as the server said last */
  let said = { needs_token: false, may_open_network: false, addresses: [], shares: [] };
  let made_id = '';  // whose link is shown
  let turn = 0;
  const choice = h(
    'select',
    { id: 'share-days', class: 'field' },
    ...kDays.map((days) => h('option', { value: String(days), selected: days === kUsualDays }, words.days(days))),
  );
  const made = h('div', { id: 'share-made' });
  const reachedAt = () => (isLoopback(location.hostname) ? said.addresses[0] : serverAddress());
  const isOpened = () => said.may_open_network && said.addresses.length > 0;
  const make = button(words.make, () => runOnce(make, async () => {
    const share = await addShare(flight.id, choice.value === 'null' ? null : Number(choice.value));
    await again();
    const server = reachedAt() ?? serverAddress();
    const link = `${server}/#/flights/${encodeURIComponent(flight.id)}?token=${share.token}`;
    // On a phone beside this computer it is read off the screen.
    const code = isOpened() ? await qrCode(link, words.code).catch(() => null) : null;  // the link is there all the same
    made_id = share.id;
    put(made, h('p', { class: 'muted' }, words.once), addressField(reachedAt() ? words.link : words.link_local, link), code, embedField(flight, server, share.token));
    make.disabled = false;
    make.focus();
  }, showFailure), { class: 'button primary', id: 'share-make' });
  const row = h('div', { class: 'share-row' }, h('label', { for: 'share-days' }, words.expiry), choice, make);
  const heading = h('h3', { class: 'share-heading' }, words.active);
  const list = h('ul', { class: 'shares' });
  // What had the keyboard's focus went away with its row.
  const goOn = () => (/** @type {HTMLElement|null} */ (list.querySelector('button')) ?? make).focus();
  const rowsOf = keptElements((/** @type {Share} */ share) => share.id, JSON.stringify, (share) => shareRow(flight, share, () => again().then(goOn), showFailure));

  const draw = () => {
    const reached_at = reachedAt();
    if (!said.shares.some(({ id }) => id === made_id)) put(made);
    arrange(list, rowsOf(said.shares));
    arrange(body, [
      h('p', { id: 'share-who' }, reached_at ? words.text : words.local),
      ...(reached_at && !said.needs_token ? [h('p', { class: 'callout callout-warning', id: 'share-open' }, words.open)] : []),
      ...(isOpened() ? [h('p', { class: 'muted', id: 'share-network' }, words.opened(said.addresses[0]))] : []),
      row,
      made,
      ...(reached_at ? [] : [localPart(flight, said.may_open_network ? openButton(opened, showFailure) : null)]),
      ...(said.shares.length > 0 ? [heading, list] : []),
    ]);
  };
  const again = async () => {
    const own_turn = (turn += 1);
    try {
      const found = await listShares(flight.id);
      if (own_turn !== turn) return;  // asked again meanwhile: what was revoked since then would be back
      said = found;
      draw();
    } catch (error) {
      if (own_turn === turn) showFailure(error);
    }
  };
  const opened = () => {
    made_id = '';  // its link is one for this computer
    return again();
  };
  return again();
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
