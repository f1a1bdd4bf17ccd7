// Two flights of one place over each other: swipe between them, or fade one into the other.
// A second map lies on the first, moves with it, and is clipped (swipe) or made translucent (fade).
/** @import { Flight } from '../shared/types.js' */
/** @import { MapView } from './map_view.js' */
import { getTileJson, listFlights } from '../shared/api.js';
import { h, onEscape } from '../shared/dom.js';
import { formatDate } from '../shared/format.js';
import { takenDay } from '../flight/flight_words.js';
import { iconButton } from '../shared/icons.js';
import { lonBeside } from './coordinates.js';
import { isAcross } from './tile_addresses.js';
import { go } from '../shared/router.js';
import { strings } from '../shared/flight_strings.js';

/** @param {Flight} flight @returns {string} when it was flown, or at least when it was uploaded */
export const dayOf = (flight) => takenDay(flight) || strings.flights.uploaded(formatDate(flight.created_at));

/**
 * Do two maps show common ground?
 * @param {Pick<Flight, 'bounds'>} a
 * @param {Pick<Flight, 'bounds'>} b
 * @returns {boolean}
 */
export function overlap(a, b) {
  if (!a.bounds || !b.bounds) return false;
  const [aw, as, ae, an] = a.bounds;
  const [bw, bs, be, bn] = b.bounds;
  // Across the antimeridian the numbers of one go on, and those of the other begin anew.
  const turn_deg = lonBeside((bw + be) / 2, (aw + ae) / 2) - (bw + be) / 2;
  return aw < be + turn_deg && bw + turn_deg < ae && as < bn && bs < an;
}

/**
 * @param {MapView} below
 * @param {MapView} above
 * @param {{left: Flight, right: Flight, on_close: () => void}} options
 * @returns {{element: HTMLElement, close: () => void}}
 */
export function compareView(below, above, options) {
  const words = strings.compare;
  /** @type {'swipe'|'fade'} */
  let mode = 'swipe';
  const line = h('div', { class: 'swipe-line', 'aria-hidden': 'true' });
  const slider = h('input', { type: 'range', id: 'compare-slider', min: 0, max: 100, step: 1, value: 50, 'aria-label': words.position });

  const draw = () => {
    const value = Number(slider.value);
    const style = above.container.style;
    if (mode === 'swipe') {
      style.setProperty('clip-path', `inset(0 0 0 ${value}%)`);
      style.removeProperty('opacity');
      line.style.setProperty('left', `${value}%`);
    } else {
      style.removeProperty('clip-path');
      style.setProperty('opacity', String(value / 100));
    }
    line.hidden = mode !== 'swipe';
    slider.setAttribute('aria-label', mode === 'swipe' ? words.position : words.strength);
  };
  slider.addEventListener('input', draw);

  const radio = (/** @type {'swipe'|'fade'} */ value, /** @type {string} */ label) => {
    const input = h('input', { type: 'radio', name: 'compare-mode', value, checked: value === mode, id: `compare-${value}` });
    input.addEventListener('change', () => {
      mode = value;
      draw();
    });
    return h('label', { class: 'check', for: input.id }, input, h('span', {}, label));
  };
  const side = (/** @type {string} */ which, /** @type {Flight} */ flight) =>
    h('div', { class: `side side-${which}` }, h('strong', {}, flight.name), h('span', { class: 'muted' }, dayOf(flight)));

  // Whichever map is moved, the other follows.
  let following = false;
  const follow = (/** @type {MapView} */ from, /** @type {MapView} */ to) => () => {
    if (following) return;
    following = true;
    to.map.jumpTo({ center: from.map.getCenter(), zoom: from.map.getZoom(), bearing: from.map.getBearing() });
    following = false;
  };
  const down = follow(below, above);
  const up = follow(above, below);
  below.map.on('move', down);
  above.map.on('move', up);
  down();

  // The divide can be dragged as well.
  line.addEventListener('pointerdown', (event) => {
    line.setPointerCapture(event.pointerId);
    event.preventDefault();
  });
  line.addEventListener('pointermove', (event) => {
    if (!line.hasPointerCapture(event.pointerId)) return;
    const box = below.container.getBoundingClientRect();
    slider.value = String(Math.round(((event.clientX - box.left) / box.width) * 100));
    draw();
  });

  const bar = h(
    'section',
    { class: 'compare-bar floating', id: 'compare-bar', 'aria-label': words.heading },
    side('left', options.left),
    h('div', { class: 'compare-middle' }, h('div', { class: 'row modes', role: 'radiogroup', 'aria-label': words.heading }, radio('swipe', words.swipe), radio('fade', words.fade)), slider),
    side('right', options.right),
    iconButton('close', words.close, options.on_close),
  );
  const element = h('div', { class: 'compare' }, line, bar);
  draw();
  return {
    element,
    close() {
      below.map.off('move', down);
      above.map.off('move', up);
      element.remove();
    },
  };
}

/**
 * Asks which flight to put beside this one.
 * @param {Flight[]} others
 * @param {(flight: Flight) => void} on_choose
 * @returns {HTMLElement}
 */
export function compareChooser(others, on_choose) {
  const list = h('ul', { class: 'chooser' });
  const close = () => {
    element.remove();
    document.getElementById('tool-compare')?.focus();
  };
  const element = h(
    'section',
    { class: 'layers-card floating', id: 'compare-chooser', 'aria-label': strings.compare.with },
    h('div', { class: 'row between' }, h('h2', { class: 'card-title' }, strings.compare.with), iconButton('close', strings.page.close, close)),
    others.length === 0 ? h('p', { class: 'muted' }, strings.compare.none) : list,
  );
  for (const other of others) {
    list.append(
      h('li', {}, h('button', { type: 'button', class: 'choice', on: { click: () => on_choose(other) } },
        h('strong', {}, other.name), h('span', { class: 'muted' }, dayOf(other)))),
    );
  }
  onEscape(element, close);
  return element;
}

/** The flight that is shown and another one: which, the map of that above the one that is there, and the end of both. */
export class Comparison {
  #turn = 0;
  /** @type {(() => void)|null} */
  #end = null;

  /** @param {HTMLElement} area of the maps */
  constructor(area) {
    this.area = area;
  }

  /** @param {Flight} flight @param {() => boolean} isShown whether it still is */
  async choose(flight, isShown) {
    document.getElementById('compare-chooser')?.remove();
    const others = (await listFlights()).filter((other) => other.id !== flight.id && overlap(flight, other));
    if (!isShown() || document.getElementById('compare-chooser')) return;
    const chooser = compareChooser(others, (other) => {
      chooser.remove();
      go({ view: 'compare', id: flight.id, other: other.id });
    });
    this.area.append(chooser);
    /** @type {HTMLElement|null} */ (chooser.querySelector('button'))?.focus();
  }

  /**
   * @param {MapView} below shows the left one
   * @param {Flight} left
   * @param {Flight} right
   * @param {(is_on: boolean) => void} on_change
   */
  async begin(below, left, right, on_change) {
    const right_bounds = right.bounds;
    if (!right.tilejson || !right_bounds) return;
    const turn = this.#turn;
    const [{ MapView }, tilejson] = await Promise.all([import('./map_view.js'), getTileJson(right.tilejson)]);
    if (turn !== this.#turn) return;  // ended before it began
    const container = h('div', { class: 'map map-above', id: 'map-above' });
    below.container.after(container);
    const above = new MapView(container, `${strings.compare.right}: ${right.name}`);
    const comparison = compareView(below, above, { left, right, on_close: () => go({ view: 'flight', id: left.id }) });
    this.area.append(comparison.element);
    this.area.classList.add('comparing');
    on_change(true);
    // Footprints belong to one of the two flights and would hide what differs.
    const shown = { footprints: below.shows_footprints, path: below.shows_path };
    below.setFootprints(false);
    below.setPath(false);
    this.#end = () => {
      below.setFootprints(shown.footprints);
      below.setPath(shown.path);
      comparison.close();
      below.goOnBeyond(isAcross(left.bounds ?? right_bounds));
      on_change(false);
      above.map.remove();
      container.remove();
      this.area.classList.remove('comparing');
    };
    await above.showMosaic(tilejson, right_bounds);
    const is_across = isAcross(right_bounds) || isAcross(left.bounds ?? right_bounds);
    if (turn !== this.#turn || !is_across) return;
    // Where one may go, the other follows.
    for (const view of [below, above]) view.goOnBeyond(true);
    above.map.jumpTo({ center: below.map.getCenter() });
  }

  end() {
    document.getElementById('compare-chooser')?.remove();
    this.#turn += 1;
    this.#end?.();
    this.#end = null;
  }
}
