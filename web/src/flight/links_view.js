// Downloads, and the addresses by which other programs read the map.
/** @import { Flight, TileJson } from '../shared/types.js' */
import { readable } from '../shared/access.js';
import { announce, showError } from '../shared/announce.js';
import { downloadPath, downloadSize } from '../shared/api.js';
import { connectFiles, josmAddress, saveText } from './connect_files.js';
import { h } from '../shared/dom.js';
import { formatBytes } from '../shared/format.js';
import { icon } from '../shared/icons.js';
import { strings } from '../shared/strings.js';
import { ownHost } from '../map/tile_addresses.js';

/**
 * @param {string} what
 * @param {string} text
 * @returns {HTMLButtonElement}
 */
export function copyButton(what, text) {
  const button = h(
    'button',
    { type: 'button', class: 'icon-button', 'aria-label': strings.links.copy(what), title: strings.links.copy(what) },
    icon('copy'),
  );
  button.addEventListener('click', async () => {
    try {
      await copyText(text);
    } catch (error) {
      showError(error);
      return;
    }
    announce(strings.links.copied);
    button.replaceChildren(icon('check'));
    setTimeout(() => button.replaceChildren(icon('copy')), 1500);
  });
  return button;
}

/** @param {string} text */
async function copyText(text) {
  if (navigator.clipboard) {
    await navigator.clipboard.writeText(text);
    return;
  }
  // The clipboard API exists on secure origins only; in a field network the page often comes over plain HTTP.
  const area = h('textarea', { class: 'visually-hidden', 'aria-hidden': 'true', value: text });
  document.body.append(area);
  area.select();
  document.execCommand('copy');
  area.remove();
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
  const download = (/** @type {'mbtiles'|'tif'} */ kind, /** @type {string} */ name, /** @type {string} */ hint) => {
    const small = h('small', {}, hint);
    downloadSize(flight.id, kind).then((bytes) => {
      if (bytes !== null) small.textContent = `${formatBytes(bytes)}, ${hint}`;
    }, showError);
    return h('a', { class: 'button download', href: readable(downloadPath(flight.id, kind)), download: '' }, icon('download'), h('span', {}, name, ' ', small));
  };
  const template = ownHost(tilejson.tiles[0]);
  const settings = connectFiles(flight, tilejson).map(({ label, file, text }) =>
    h('button', { type: 'button', class: 'button small', on: { click: () => saveText(file, text) } }, words.connect(label)),
  );
  return h(
    'section',
    { class: 'block no-print', 'aria-labelledby': 'links-heading' },
    h('h2', { id: 'links-heading' }, words.heading),
    h('div', { class: 'downloads' }, download('mbtiles', words.mbtiles, words.mbtiles_hint), download('tif', words.tif, words.tif_hint)),
    h('div', { class: 'row settings' }, ...settings),
    addressField(words.xyz, template),
    addressField(words.josm, josmAddress(template, tilejson)),
    addressField(words.tilejson, new URL(flight.tilejson ?? '', location.origin).href),
  );
}
