// The flights that were deleted and can still be taken back, folded away below the list of flights.
/** @import { TrashedFlight } from '../shared/types.js' */
import { arrange, h, keptElements, put } from '../shared/dom.js';
import { button, onFirstClick } from '../shared/icons.js';
import { dotted, formatBytes, formatDate } from '../shared/format.js';
import { number } from '../shared/language.js';
import { strings } from '../shared/strings.js';

/**
 * @param {{restore: (flight: TrashedFlight) => void, remove: (flight: TrashedFlight) => void}} actions
 * @returns {{element: HTMLElement, update: (flights: TrashedFlight[]) => void}}
 */
export function trashList(actions) {
  const element = h('div', { class: 'trash', hidden: true });
  const list = h('ul', { class: 'trash-flights', id: 'trash' });
  const summary = h('summary', {}, strings.trash.heading);
  const folded = h('details', { id: 'trash-fold' }, summary, list);
  let shown = '';

  /** @param {TrashedFlight} flight */
  const row = (flight) =>
    h(
      'li',
      {},
      h('span', { class: 'flight-name' }, flight.name),
      h('span', { class: 'flight-facts' }, dotted(strings.trash.deleted(formatDate(flight.deleted_at)), strings.flights.files(flight.file_count),
        flight.bytes > 0 && formatBytes(flight.bytes), strings.trash.left(flight.days_left))),
      h(
        'span',
        { class: 'row' },
        button(strings.trash.restore, onFirstClick(() => actions.restore(flight)), { 'aria-label': `${strings.trash.restore}: ${flight.name}` }),
        button(strings.trash.remove, () => actions.remove(flight), { 'aria-label': `${strings.trash.remove}: ${flight.name}` }),
      ),
    );

  const rowsOf = keptElements((/** @type {TrashedFlight} */ flight) => flight.id, JSON.stringify, row);

  return {
    element,
    update(flights) {
      const picture = JSON.stringify(flights);
      if (picture === shown) return;
      shown = picture;
      const had_focus = element.contains(document.activeElement);
      summary.textContent = `${strings.trash.heading} (${number(flights.length)})`;
      arrange(list, rowsOf(flights));
      element.hidden = flights.length === 0;
      if (flights.length === 0) {
        put(element);
        folded.open = false;
      } else if (!folded.isConnected) put(element, folded);
      // What had the keyboard's focus went away with its row.
      if (had_focus && !element.contains(document.activeElement)) (flights.length > 0 ? summary : document.getElementById('flights-heading'))?.focus();
    },
  };
}
