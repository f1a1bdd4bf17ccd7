// The part of the layers card where a user lays own GeoJSON or KML over the map, and takes it away again.
/** @import { MapView } from './map_view.js' */
import { announce, showNote } from '../shared/announce.js';
import { h } from '../shared/dom.js';
import { button, iconButton } from '../shared/icons.js';
import { strings } from '../shared/flight_strings.js';
import { boundsOfData, ownDataFault, readOwnFile } from './own_data.js';
import { isAcross } from './tile_addresses.js';

const kColours = ['#e6007e', '#00a5e5', '#ffb000', '#7a3ff2', '#00b06b'];
const kMargin_px = 70;

/**
 * @param {MapView} view
 * @returns {HTMLElement}
 */
export function ownDataView(view) {
  const words = strings.own_data;
  const list = h('ul', { class: 'own-data' });
  const input = h('input', { type: 'file', accept: '.geojson,.json,.kml', multiple: true, hidden: true, id: 'own-data-input' });
  let count = 0;

  /** @param {File} file */
  const add = async (file) => {
    const data = await readOwnFile(file);
    const bounds = boundsOfData(data);
    const colour = kColours[count % kColours.length];
    const id = `own-${(count += 1)}`;
    if (isAcross(bounds)) view.goOnBeyond(true);
    view.addOwnData(id, file.name, data, colour);
    const swatch = h('span', { class: 'dot' });
    swatch.style.background = colour;
    const show = () => view.map.fitBounds(bounds, { padding: kMargin_px, maxZoom: 21, animate: false });
    const row = h(
      'li',
      {},
      swatch,
      button(file.name, show, { class: 'text-button', title: words.show(file.name) }),
      iconButton('close', words.remove(file.name), () => {
        view.removeOwnData(id);
        row.remove();
        add_button.focus();
      }),
    );
    list.append(row);
    announce(words.added(file.name));
    if (!view.sees(bounds)) showNote(words.elsewhere(file.name), { action: { label: words.go, run: show } });
  };
  input.addEventListener('change', async () => {
    const files = [...(input.files ?? [])];
    input.value = '';
    for (const file of files) {
      try {
        await add(file);
      } catch (error) {
        showNote(ownDataFault(file, error), { is_error: true, duration_ms: 15_000 });
      }
    }
  });
  const add_button = button(words.add, () => input.click(), { picture: 'plus', id: 'own-data-add' });
  return h('div', { class: 'own-data-part' }, h('span', { class: 'small-label' }, words.heading), list, add_button, input);
}
