// The two forms of the control points: a list to be imported, and one point typed by hand. What the server refuses is said
// in the form, and nothing is changed.
/** @import { ControlDocument } from './control_document.js' */
/** @import { ControlPoint } from './control_lists.js' */
import { messageOf } from '../shared/api.js';
import { ask, closeButton } from '../shared/dialogs.js';
import { h, put } from '../shared/dom.js';
import { typedNumber, typedText } from '../shared/format.js';
import { strings } from '../shared/flight_strings.js';
import { listText, nameOfSeveral, parseControlList, withPoints } from './control_lists.js';

const kMaxListBytes = 4 << 20;
const kUsualSystem = 'EPSG:4326';

/** @param {string} id @param {string} label @param {HTMLElement} field @param {string} [hint] */
const labelled = (id, label, field, hint = '') => {
  field.id = id;
  return h('div', { class: 'control-field' }, h('label', { for: id }, label), field, hint && h('small', { class: 'muted' }, hint));
};

/**
 * @param {string} id
 * @param {string} title
 * @param {HTMLElement[]} fields
 * @param {string} go
 * @param {() => Promise<string>} submit answers what is wrong, else ''
 */
function openForm(id, title, fields, go, submit) {
  const fault = h('p', { class: 'place-fault', role: 'alert', id: `${id}-fault` });
  const button = h('button', { type: 'submit', class: 'button primary', id: `${id}-go` }, go);
  const actions = h('div', { class: 'dialog-actions' }, closeButton(), button);
  const form = h('form', { class: 'control-form', novalidate: true }, h('h2', { class: 'dialog-title', id: `${id}-title` }, title), ...fields, fault, actions);
  const dialog = h('dialog', { class: 'dialog control-dialog', id, 'aria-labelledby': `${id}-title` }, form);
  form.addEventListener('submit', async (event) => {
    event.preventDefault();
    button.disabled = true;
    const text = await submit().catch(messageOf);
    button.disabled = false;
    put(fault, text);
    if (text === '') dialog.close();
  });
  void ask(dialog);
}

/**
 * @param {ControlDocument} control
 * @param {{reference_system: string, points: ControlPoint[]}} next
 */
async function keep(control, next) {
  control.change(next);
  try {
    await control.flush();
  } catch (error) {
    if (control.state === 'failed') {
      control.undo();
      throw error;
    }
    // A server that is away, or a flight that is being stitched: it is sent later, and the panel says so.
  }
}

/**
 * @param {ControlDocument} control
 * @param {string[]} photos of the flight
 */
export function openImport(control, photos) {
  const words = strings.control;
  const text = h('textarea', { class: 'field control-text', rows: 8, spellcheck: 'false', placeholder: words.import_example });
  const file = h('input', { type: 'file', accept: '.txt,.csv,.tsv,text/plain,text/csv', class: 'field' });
  const system = h('input', { type: 'text', class: 'field', maxlength: 300, value: control.points.length > 0 ? control.reference_system : '', placeholder: kUsualSystem });
  const found = h('p', { class: 'muted', id: 'control-found', role: 'status' });
  let list = parseControlList('');
  const read = () => {
    list = parseControlList(text.value, system.value.trim());
    if (list.reference_system !== '') system.value = list.reference_system;
    const marks = list.points.reduce((sum, point) => sum + point.marks.length, 0);
    const is_other = control.points.length > 0 && system.value.trim() !== control.reference_system;
    put(found, text.value.trim() === '' ? '' : [
      words.found(list.points.length, marks),
      list.bad_lines.length > 0 ? words.bad_lines(list.bad_lines.length, list.bad_lines[0]) : '',
      is_other && list.points.length > 0 ? words.replaces(control.points.length) : '',
    ].filter(Boolean).join(' '));
  };
  text.addEventListener('input', read);
  system.addEventListener('input', read);
  // The same one that was edited since is a change, too.
  file.addEventListener('click', () => (file.value = ''));
  file.addEventListener('change', async () => {
    const chosen = file.files?.[0];
    if (!chosen) return;
    text.value = chosen.size > kMaxListBytes ? '' : listText(new Uint8Array(await chosen.arrayBuffer()));
    read();
    if (chosen.size > kMaxListBytes) put(found, words.too_large);
  });
  openForm('control-import', words.import_title, [
    labelled('control-file', words.file, file),
    labelled('control-text', words.text, text, words.import_hint),
    labelled('control-system', words.system, system, words.system_hint),
    found,
  ], words.import_go, async () => {
    read();
    if (list.points.length === 0) return words.no_points_found;
    const reference_system = system.value.trim();
    if (reference_system === '') return words.no_system;
    const name = nameOfSeveral(list.points);
    if (name !== '') return words.named_twice(name);
    if (list.is_height_unit_unknown) return words.heights_in_feet(reference_system);
    const kept = reference_system === control.reference_system ? control.points : [];
    await keep(control, { reference_system, points: withPoints(kept, list.points, photos) });
    return '';
  });
}

/**
 * @param {ControlDocument} control
 * @param {ControlPoint|null} point null: a new one
 */
export function openPointForm(control, point) {
  const words = strings.control;
  const value = (/** @type {number|null|undefined} */ number) => (typeof number === 'number' ? typedText(number) : '');
  // All keys: those for numbers have no minus on iPhones.
  const field = (/** @type {string} */ text) => h('input', { type: 'text', class: 'field', maxlength: 100, value: text });
  const name = field(point?.name ?? '');
  const [x, y, height] = [point?.x, point?.y, point?.height].map((number) => field(value(number)));
  const system = field(control.points.length > 0 ? control.reference_system : kUsualSystem);
  system.readOnly = control.points.length > (point ? 1 : 0);
  openForm('control-point', point ? words.change(point.name) : words.add_title, [
    labelled('control-name', words.name, name),
    labelled('control-system', words.system, system, system.readOnly ? '' : words.system_hint),
    h('div', { class: 'control-numbers' }, labelled('control-x', words.x, x), labelled('control-y', words.y, y), labelled('control-height', words.height, height)),
  ], strings.flights.save, async () => {
    const own = name.value.trim();
    const [east, north, up] = [x, y, height].map((input) => typedNumber(input.value));
    if (own === '') return words.no_name;
    if (control.points.some((other) => other.name === own && other !== control.point(point?.name ?? ''))) return words.name_taken(own);
    if (!Number.isFinite(east) || !Number.isFinite(north) || (height.value.trim() !== '' && !Number.isFinite(up))) return words.no_number;
    const next = { name: own, x: east, y: north, height: Number.isFinite(up) ? up : null };
    const points = point
      ? control.points.map((other) => (other.name === point.name ? { ...next, marks: other.marks } : other))
      : [...control.points, { ...next, marks: [] }];
    await keep(control, { reference_system: system.value.trim(), points });
    return '';
  });
}
