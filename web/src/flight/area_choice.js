// Which area something is cut to: none, one that is on the map, or one of a file.
/** @import { Outline } from '../map/outlines.js' */
import { OwnDataError, ownDataFault, readOwnFile } from '../map/own_data.js';
import { outlineOf } from '../map/outlines.js';
import { h, put } from '../shared/dom.js';
import { button } from '../shared/icons.js';
import { strings } from '../shared/flight_strings.js';

/**
 * @param {string} id of the field; those of the others begin with it
 * @param {Outline[]} outlines that are on the map
 * @param {(why: string) => void} refuse '' when a file is tried
 * @param {number} [cut_to] which of them is chosen; -1: none
 */
export function areaChoice(id, outlines, refuse, cut_to = -1) {
  const words = strings.exports;
  const known = [...outlines];
  const field = h('select', { id, class: 'field' });
  const file = h('input', { type: 'file', accept: '.geojson,.json,.kml', hidden: true, id: `${id}-file` });
  const browse = button(words.browse, () => file.click(), { id: `${id}-browse` });
  const draw = (/** @type {number} */ chosen) => {
    put(field, h('option', { value: '' }, words.whole), ...known.map(({ name }, i) => h('option', { value: String(i) }, name)));
    field.value = chosen < 0 ? '' : String(chosen);
  };
  /** @param {Outline|null} outline */
  const choose = (outline) => draw(outline ? known.push(outline) - 1 : -1);
  file.addEventListener('change', async () => {
    const [chosen] = file.files ?? [];
    file.value = '';
    if (!chosen) return;
    refuse('');
    try {
      const outline = outlineOf(chosen.name, await readOwnFile(chosen));
      if (!outline) throw new OwnDataError(words.no_area);
      choose(outline);
    } catch (error) {
      refuse(ownDataFault(chosen, error));
    }
  });
  draw(cut_to);
  return { field, browse, file, choose, chosen: () => (field.value === '' ? null : known[Number(field.value)]) };
}
