// The page's icons as stroke paths on a 24 x 24 grid; drawn in the colour of the text around them.
import { h, svg } from './dom.js';

/** @type {Record<string, string>} */
const paths = {
  back: 'M15 5l-7 7 7 7',
  close: 'M6 6l12 12M18 6L6 18',
  upload: 'M12 16V4M7 9l5-5 5 5M4 16v3a1 1 0 001 1h14a1 1 0 001-1v-3',
  download: 'M12 4v12M7 11l5 5 5-5M4 20h16',
  folder: 'M3 7a1 1 0 011-1h5l2 2h9a1 1 0 011 1v9a1 1 0 01-1 1H4a1 1 0 01-1-1z',
  pencil: 'M4 20l1-4L16 5l3 3L8 19zM14 7l3 3',
  trash: 'M5 7h14M10 7V4h4v3M7 7l1 13h8l1-13M10 11v5M14 11v5',
  share: 'M7 12l10-6M7 12l10 6M6.500 9.500a2.500 2.500 0 100 5 2.500 2.500 0 000-5zM17.500 3.500a2.500 2.500 0 100 5 2.500 2.500 0 000-5zM17.500 15.500a2.500 2.500 0 100 5 2.500 2.500 0 000-5z',
  copy: 'M9 9h10v11H9zM5 15V4h10',
  check: 'M5 12.5l4.5 4.5L19 7.5',
  warning: 'M12 4l9 16H3zM12 10v4M12 17v.5',
  pause: 'M8 5v14M16 5v14',
  play: 'M7 4.5v15l12-7.5z',
  sliders: 'M4 7h9M17 7h3M13 5v4M4 12h3M11 12h9M7 10v4M4 17h11M19 17h1M15 15v4',
  retry: 'M19 12a7 7 0 11-2.1-5M19 4v4h-4',
  layers: 'M12 4l9 5-9 5-9-5zM3.5 13.5L12 18l8.5-4.5',
  fit: 'M4 9V4h5M15 4h5v5M20 15v5h-5M9 20H4v-5',
  ruler: 'M3 16L16 3l5 5L8 21zM7 12l2 2M10 9l3 3M13 6l2 2',
  area: 'M5 7l8-3 7 6-3 9-11-1zM5 7h.01M13 4h.01M20 10h.01M17 19h.01M6 18h.01',
  compare: 'M12 3v18M4 6h5v12H4zM15 6h5v12h-5z',
  plus: 'M12 5v14M5 12h14',
  minus: 'M5 12h14',
  next: 'M9 5l7 7-7 7',
  print: 'M7 9V4h10v5M6 18H4v-7a2 2 0 012-2h12a2 2 0 012 2v7h-2M7 15h10v5H7z',
  photo: 'M3 7h4l2-3h6l2 3h4v12H3zM12 9.500a4 4 0 100 8 4 4 0 000-8z',
  move: 'M12 3v18M3 12h18M9 6l3-3 3 3M9 18l3 3 3-3M6 9l-3 3 3 3M18 9l3 3-3 3',
  undo: 'M9 5L4 10l5 5M4 10h10a5 5 0 010 10h-3',
  search: 'M10.500 4a6.500 6.500 0 100 13 6.500 6.500 0 000-13zM15.500 15.500L20 20',
};

/**
 * A decorative icon; the words beside it or the button's aria-label carry the meaning.
 * @param {string} name
 * @returns {SVGSVGElement}
 */
export function icon(name) {
  const path = paths[name];
  if (!path) throw new Error(`no icon named ${name}`);
  return svg(
    'svg',
    { class: 'icon', viewBox: '0 0 24 24', 'aria-hidden': 'true', focusable: 'false' },
    svg('path', { d: path }),
  );
}

/**
 * For a button that takes its row out of a list: the second half of a double click would take the one that comes in its place.
 * @param {() => void} run
 * @returns {(event: MouseEvent) => void}
 */
export const onFirstClick = (run) => (event) => {
  if (event.detail < 2) run();
};

/**
 * A button with words.
 * @param {string} label
 * @param {((event: MouseEvent) => void)|null} run
 * @param {{picture?: string, [attribute: string]: any}} [look] picture: the icon before the words
 * @returns {HTMLButtonElement}
 */
export const button = (label, run, { picture = '', ...attributes } = {}) =>
  h('button', { type: 'button', class: 'button small', on: run && { click: run }, ...attributes }, picture !== '' && icon(picture), label);

/**
 * A button is pressed once, and again where that failed.
 * @param {HTMLButtonElement} pressed
 * @param {() => Promise<unknown>} work
 * @param {(error: unknown) => void} fail
 */
export async function runOnce(pressed, work, fail) {
  const had_focus = pressed === document.activeElement;
  pressed.disabled = true;  // which takes its focus
  try {
    await work();
  } catch (error) {
    pressed.disabled = false;
    if (had_focus && (document.activeElement === document.body || document.activeElement === pressed)) pressed.focus();
    fail(error);
  }
}

/**
 * A button that shows no word: its label is read out, and shown where it is pointed at.
 * @param {string|Node} picture the name of an icon, or what is drawn
 * @param {string} label
 * @param {((event: MouseEvent) => void)|null} run
 * @param {string} [id]
 * @param {string} [style] class
 * @returns {HTMLButtonElement}
 */
export const iconButton = (picture, label, run, id = '', style = 'icon-button') =>
  h('button', { type: 'button', class: style, id: id || null, 'aria-label': label, title: label, on: run && { click: run } }, typeof picture === 'string' ? icon(picture) : picture);

/** Over a map. @param {string|Node} picture @param {string} label @param {((event: MouseEvent) => void)|null} run @param {string} [id] */
export const toolButton = (picture, label, run, id = '') => iconButton(picture, label, run, id, 'tool');

/**
 * North arrow for the compass button; turned by the map.
 * @returns {SVGSVGElement}
 */
export function compassNeedle() {
  return svg(
    'svg',
    { class: 'icon needle', viewBox: '0 0 24 24', 'aria-hidden': 'true', focusable: 'false' },
    svg('path', { class: 'needle-north', d: 'M12 2.500l4 9.500H8z' }),
    svg('path', { class: 'needle-south', d: 'M12 21.500l-4-9.500h8z' }),
  );
}
