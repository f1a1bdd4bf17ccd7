// The control points of an open flight, closed until somebody wants them: what they need is fetched when they are opened.
/** @import { Flight, PhotoCollection, Report } from '../shared/types.js' */
/** @import { Stage } from '../map/stage.js' */
import { showError } from '../shared/announce.js';
import { h, put } from '../shared/dom.js';
import { strings } from '../shared/flight_strings.js';

/**
 * @typedef {object} ControlSubject
 * @property {Flight} flight
 * @property {Report} report
 * @property {PhotoCollection} photos
 * @property {Stage} stage
 * @property {boolean} may_change
 * @property {() => Promise<void>} apply begins the job that brings the map to the points
 */

/**
 * @param {ControlSubject} subject
 * @param {{is_open: boolean, on_toggle: (is_open: boolean) => void}} memory whether it was open on the map before
 * @returns {{element: HTMLElement, close: () => void}}
 */
export function controlSection(subject, memory) {
  const words = strings.control;
  const body = h('div', { class: 'control-body' });
  const used = subject.report.alignment?.ground_control?.length ?? 0;
  const element = h('details', { class: 'block control', id: 'control' }, h('summary', {}, words.heading, used > 0 && h('span', { class: 'muted' }, ` ${words.in_map(used)}`)), body);
  /** @type {{element: HTMLElement, close: () => void}|null} */
  let panel = null;
  let is_closed = false;
  const open = async () => {
    if (panel || is_closed) return;
    const { controlPanel } = await import('./control_panel.js');
    if (panel || is_closed || !element.open) return;
    panel = controlPanel(subject);
    put(body, panel.element);
  };
  const shut = () => {
    panel?.close();
    panel = null;
    put(body);
  };
  element.addEventListener('toggle', () => {
    if (is_closed) return;
    memory.on_toggle(element.open);
    if (element.open) open().catch(showError);
    else shut();
  });
  if (memory.is_open) element.open = true;
  return {
    element,
    close() {
      is_closed = true;
      shut();
    },
  };
}
