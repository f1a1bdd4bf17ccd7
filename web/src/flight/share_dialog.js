// Shares a flight: makes a link that opens this one alone, for a while, lists those that were made, and revokes them.
/** @import { Flight, Share } from '../shared/types.js' */
import { addShare, listShares, removeShare } from '../shared/api.js';
import { at } from '../shared/router.js';
import { h, put } from '../shared/dom.js';
import { formatDate } from '../shared/format.js';
import { xmlText } from './connect_files.js';
import { addressField } from './links_view.js';
import { strings } from '../shared/flight_strings.js';

const kDays = /** @type {(number|null)[]} */ ([1, 7, 30, 365, null]);
const kUsualDays = 30;

/** @param {string} page as the server names it, "/#/flights/..." */
const absolute = (page) => new URL(at(page), location.origin).href;

/**
 * What a website takes to show the map in a frame, at the place that is shown now where the map was moved.
 * @param {Flight} flight
 * @param {string} embed as the server names it, "/embed/..."
 */
function embedField(flight, embed) {
  const view = new URLSearchParams(location.hash.split('?')[1] ?? '').get('at');
  const address = absolute(embed) + (view ? `${embed.includes('#') ? '&' : '#'}at=${view}` : '');
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
  const { needs_token, shares } = await listShares(flight.id);
  if (!needs_token) {
    put(body, h('p', {}, words.open), addressField(words.link, absolute(`/#/flights/${flight.id}`)), embedField(flight, `/embed/${flight.id}`));
    return;
  }
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
      body.querySelector('#share-made')?.append(h('p', { class: 'muted' }, words.once), addressField(words.link, absolute(share.page)), embedField(flight, share.embed));
    } catch (error) {
      make.disabled = false;
      showFailure(error);
    }
  });
  put(
    body,
    h('p', {}, words.text),
    h('div', { class: 'share-row' }, h('label', { for: 'share-days' }, words.expiry), choice, make),
    made,
    shares.length > 0 && h('h3', { class: 'share-heading' }, words.active),
    shares.length > 0 && h('ul', { class: 'shares' }, ...shares.map((share) => shareRow(flight, share, again, showFailure))),
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
