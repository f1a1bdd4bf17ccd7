// Shares a flight: makes a link that opens this one alone, for reading and for a while, lists those that were made, and
// revokes them. Says who can open it: a server that listens to its own machine alone has links for that machine.
/** @import { Flight, Share } from '../shared/types.js' */
import { addShare, listShares, removeShare } from '../shared/api.js';
import { serverAddress } from '../shared/router.js';
import { h, put } from '../shared/dom.js';
import { formatDate } from '../shared/format.js';
import { xmlText } from './connect_files.js';
import { showDownloads } from './flight_actions.js';
import { addressField } from './links_view.js';
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
  const dialog = h(
    'dialog',
    { class: 'dialog', 'aria-labelledby': 'share-title', id: 'share-dialog' },
    h('h2', { id: 'share-title', class: 'dialog-title' }, words.title(flight.name)),
    body,
    h('div', { class: 'dialog-actions' }, h('button', { type: 'button', class: 'button', on: { click: () => dialog.close() } }, words.close)),
  );
  dialog.addEventListener('close', () => dialog.remove());
  document.body.append(dialog);
  dialog.showModal();
  /** @param {unknown} error */
  const showFailure = (error) => {
    const text = error instanceof Error ? error.message : String(error);
    body.append(h('p', { class: 'callout callout-error', role: 'alert' }, text));
  };
  fillIn(flight, body, showFailure).catch(showFailure);
}

/** @param {Flight} flight @param {HTMLElement} body @param {(error: unknown) => void} showFailure */
async function fillIn(flight, body, showFailure) {
  const words = strings.share;
  const { needs_token, addresses, shares } = await listShares(flight.id);
  const reached_at = isLoopback(location.hostname) ? addresses[0] : serverAddress();
  const server = reached_at ?? serverAddress();
  const again = () => fillIn(flight, body, showFailure).catch(showFailure);
  const choice = h(
    'select',
    { id: 'share-days', class: 'field' },
    ...kDays.map((days) => h('option', { value: String(days), selected: days === kUsualDays }, words.days(days))),
  );
  const made = h('div', { id: 'share-made' });
  const make = h('button', { type: 'button', class: 'button primary', id: 'share-make' }, words.make);
  make.addEventListener('click', async () => {
    make.disabled = true;
    try {
      const share = await addShare(flight.id, choice.value === 'null' ? null : Number(choice.value));
      await again();
      const link = `${server}/#/flights/${encodeURIComponent(flight.id)}?token=${share.token}`;
      body.querySelector('#share-made')?.append(h('p', { class: 'muted' }, words.once), addressField(reached_at ? words.link : words.link_local, link), embedField(flight, server, share.token));
    } catch (error) {
      make.disabled = false;
      showFailure(error);
    }
  });
  put(
    body,
    h('p', { id: 'share-who' }, reached_at ? words.text : words.local),
    reached_at && !needs_token && h('p', { class: 'callout callout-warning', id: 'share-open' }, words.open),
    h('div', { class: 'share-row' }, h('label', { for: 'share-days' }, words.expiry), choice, make),
    made,
    !reached_at && localPart(flight, needs_token),
    shares.length > 0 && h('h3', { class: 'share-heading' }, words.active),
    shares.length > 0 && h('ul', { class: 'shares' }, ...shares.map((share) => shareRow(flight, share, again, showFailure))),
  );
}

/**
 * How others see it all the same.
 * @param {Flight} flight
 * @param {boolean} needs_token
 */
function localPart(flight, needs_token) {
  const words = strings.share;
  const commands = [...(needs_token ? [] : ['skyquilt token add me --data data --scope admin']), `skyquilt serve --data data --listen 0.0.0.0:${location.port || '80'}`];
  const file = h('button', { type: 'button', class: 'button small', id: 'share-file' }, words.choose_file);
  file.addEventListener('click', () => {
    file.closest('dialog')?.close();
    showDownloads(flight, []);
  });
  return h(
    'div',
    { id: 'share-local' },
    h('p', { class: 'muted' }, words.local_how(needs_token)),
    h('pre', { class: 'command' }, h('code', {}, commands.join('\n'))),
    flight.tilejson && h('p', { class: 'row' }, h('span', { class: 'muted' }, words.local_file), file),
  );
}

/** @param {Flight} flight @param {Share} share @param {() => Promise<void>} again @param {(error: unknown) => void} showFailure */
function shareRow(flight, share, again, showFailure) {
  const words = strings.share;
  const text = words.row(formatDate(share.created_at), share.expires_at ? formatDate(share.expires_at) : null);
  const revoke = h('button', { type: 'button', class: 'button small', 'aria-label': `${words.revoke}: ${text}` }, words.revoke);
  revoke.addEventListener('click', async () => {
    revoke.disabled = true;
    try {
      await removeShare(flight.id, share.id);
      await again();
    } catch (error) {
      revoke.disabled = false;
      showFailure(error);
    }
  });
  return h('li', {}, h('span', {}, text), revoke);
}
