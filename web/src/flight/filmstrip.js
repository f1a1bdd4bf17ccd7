// A strip of photos to choose from. Their small pictures are those that cameras write into the first bytes of a photo:
// fetched alone, and when they come into sight.
/** @import { SeenPhoto } from './photo_card.js' */
import { h, put, whenSeen } from '../shared/dom.js';
import { fixed, number } from '../shared/language.js';
import { strings } from '../shared/flight_strings.js';
import { embeddedPicture, kHeadBytes } from '../upload/exif_reader.js';

/**
 * @param {SeenPhoto[]} photos
 * @param {(index: number) => void} on_choose
 * @returns {{element: HTMLElement, show: (index: number) => void, close: () => void}}
 */
export function filmstrip(photos, on_choose) {
  const words = strings.photo;
  /** @type {string[]} */
  const addresses = [];
  const abort = new AbortController();
  const frames = photos.map(({ record, off_vertical_deg }, i) => {
    const label = [record.name, off_vertical_deg === null ? '' : words.off_vertical(off_vertical_deg)].filter(Boolean).join(', ');
    return h(
      'button',
      { type: 'button', class: 'frame', 'data-index': i, 'aria-label': label, title: label, on: { click: () => on_choose(i) } },
      h('span', { class: 'frame-picture', 'data-number': number(i + 1) }),  // shown until the picture is there
      h('span', { class: 'frame-name' }, off_vertical_deg === null ? record.name : `${fixed(off_vertical_deg, 0)}°`),
    );
  });
  const element = h('div', { class: 'filmstrip', role: 'group', 'aria-label': words.strip }, ...frames);
  const draw = async (/** @type {HTMLElement} */ frame) => {
    try {
      const picture = await smallPicture(photos[Number(frame.dataset.index)].url, abort.signal);
      if (!picture || abort.signal.aborted) return;
      const address = URL.createObjectURL(picture);
      addresses.push(address);
      put(/** @type {HTMLElement} */ (frame.firstElementChild), h('img', { src: address, alt: '', draggable: 'false' }));
    } catch (error) {
      if (!abort.signal.aborted) console.debug('no small picture', error);  // its number is there instead
    }
  };
  const in_sight = whenSeen((frame) => void draw(frame));
  for (const frame of frames) in_sight.observe(frame);
  return {
    element,
    show(index) {
      frames.forEach((frame, i) => frame.setAttribute('aria-current', String(i === index)));
      frames[index].scrollIntoView({ block: 'nearest', inline: 'nearest' });
    },
    close() {
      abort.abort();
      in_sight.disconnect();
      for (const address of addresses) URL.revokeObjectURL(address);
    },
  };
}

/**
 * @param {string} url of a photo
 * @param {AbortSignal} signal
 * @returns {Promise<Blob|null>} null where the photo has none
 */
async function smallPicture(url, signal) {
  const response = await fetch(url, { headers: { Range: `bytes=0-${kHeadBytes - 1}` }, signal });
  if (!response.ok) return null;
  const head = await response.blob();
  const embedded = embeddedPicture(await head.arrayBuffer());
  // A photo that is no larger than that is its own small picture.
  return embedded ?? (isWhole(response, head.size) ? head : null);
}

/** @param {Response} response @param {number} bytes */
function isWhole(response, bytes) {
  const range = response.headers.get('Content-Range');
  return bytes <= kHeadBytes && (response.status === 200 || range?.endsWith(`/${bytes}`) === true);
}
