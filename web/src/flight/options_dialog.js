// Asks how a map is to be made: a preset, or each option with what it does. Says beside a field what the server would
// refuse, before anything is sent.
/** @import { Flight } from '../shared/types.js' */
/** @import { Outline } from '../map/outlines.js' */
/** @import { Choice, JobOptions, OptionsForm, TypedField } from './job_options.js' */
import { kLayers, messageOf } from '../shared/api.js';
import { ask, closeButton, refusalBox, titledDialog } from '../shared/dialogs.js';
import { checkRow, h, put } from '../shared/dom.js';
import { dotted, parseNumber } from '../shared/format.js';
import { number } from '../shared/language.js';
import { strings } from '../shared/flight_strings.js';
import { button } from '../shared/icons.js';
import { areaChoice } from './area_choice.js';
import { confirmCoarse } from './coarse_map.js';
import { movesMap } from './job_watch.js';
import { chosenIn, chooseOptions, chosenOptions, formOf, jobArea, kChoiceNames, kChoices, keepPreset, keptPresets, kLimits, kPresets, optionsOf } from './job_options.js';

const kOwn = 'own:';  // before the names of the user's presets, which may be called as ours are

/**
 * @param {{flight_id: string, title: string, hint?: string, submit: string, options: JobOptions, outlines?: Outline[], on_submit: (options: JobOptions) => Promise<void>|void}} question
 *   outlines: on the map now; on_submit: what it throws is shown, and the dialog stays
 */
export function askOptions({ flight_id, title, hint = '', submit, options, outlines = [], on_submit }) {
  const words = strings.options;
  // The keys for numbers have no minus on iPhones.
  const isSigned = (/** @type {TypedField} */ name) => name === 'origin' || kLimits[name].least < 0;
  const text = (/** @type {TypedField} */ name, /** @type {string} */ placeholder) =>
    h('input', { id: `option-${name}`, class: 'field', type: 'text', inputmode: isSigned(name) ? 'text' : 'decimal', placeholder, autocomplete: 'off', 'aria-describedby': `option-${name}-hint option-${name}-fault` });
  const choice = (/** @type {Choice} */ name) =>
    h('select', { id: `option-${name}`, class: 'field', 'aria-describedby': `option-${name}-hint` }, ...kChoices[name].map((value) => h('option', { value }, choiceWords(name, value))));

  const typed = {
    resolution_cm: text('resolution_cm', words.as_photos),
    max_look_deg: text('max_look_deg', String(kLimits.max_look_deg.usual)),
    readout_ms: text('readout_ms', words.automatic),
    quality: text('quality', String(kLimits.quality.usual)),
    origin: text('origin', words.none),
    takeoff_height_m: text('takeoff_height_m', words.as_recorded),
  };
  const fields = /** @type {TypedField[]} */ (Object.keys(typed));
  const choices = /** @type {Record<Choice, HTMLSelectElement>} */ (Object.fromEntries(kChoiceNames.map((name) => [name, choice(name)])));
  const not_finer = checkRow(words.not_finer, 'option-not_finer');
  const layers = kLayers.map((name) => ({ name, ...checkRow(/** @type {Record<string, string>} */ (strings.map.overlays)[name], `option-layer-${name}`) }));
  /** @type {Record<string, HTMLElement>} */
  const faults = Object.fromEntries(fields.map((name) => [name, h('small', { class: 'bad', id: `option-${name}-fault`, role: 'alert' })]));

  const row = (/** @type {string} */ name, /** @type {HTMLElement} */ field, /** @type {HTMLElement|null} */ more = null) => {
    const hint = /** @type {Record<string, string|((least: number, most: number) => string)>} */ (words.hints)[name];
    const { least, most } = kLimits[/** @type {keyof typeof kLimits} */ (name)] ?? {};
    return h(
      'div',
      { class: 'export-row' },
      h('label', { for: field.id }, /** @type {Record<string, string>} */ (words.names)[name]),
      h('div', { class: 'option-field' }, field, h('small', { class: 'muted', id: `${field.id}-hint` }, typeof hint === 'string' ? hint : hint(least, most)), faults[name] ?? null, more),
    );
  };

  const { element: refusal, refuse } = refusalBox('options-refusal');
  const area = areaChoice('option-boundary', outlines, refuse);
  area.field.setAttribute('aria-describedby', 'option-boundary-hint');

  /** @returns {OptionsForm} */
  const read = () => ({
    .../** @type {Record<TypedField|Choice, string>} */ (Object.fromEntries(Object.entries({ ...typed, ...choices }).map(([name, { value }]) => [name, value]))),
    not_finer: not_finer.input.checked,
    layers: layers.filter(({ input }) => input.checked).map(({ name }) => name),
    boundary: area.chosen()?.geometry ?? null,
  });
  /** @param {OptionsForm} form */
  const fill = (form) => {
    for (const name of fields) typed[name].value = form[name];
    for (const name of kChoiceNames) choices[name].value = form[name];
    not_finer.input.checked = form.not_finer;
    for (const { name, input } of layers) input.checked = form.layers.includes(name);
    area.choose(form.boundary && { name: words.chosen_area, geometry: form.boundary });
    check();
  };
  /** Says what is wrong. @returns {JobOptions|null} null: something is */
  const check = () => {
    const found = optionsOf(read());
    for (const name of fields) {
      const is_wrong = found.faults.includes(name);
      typed[name].setAttribute('aria-invalid', String(is_wrong));
      faults[name].textContent = !is_wrong ? '' : name === 'origin' ? words.bad_place : words.bad_number(kLimits[name].least, kLimits[name].most);
    }
    not_finer.row.hidden = typed.resolution_cm.value.trim() === '';
    return found.faults.length > 0 ? null : found.options;
  };

  const preset = h('select', { id: 'option-preset', class: 'field' });
  const forget = button(words.forget, () => {
    keepPreset(preset.value.slice(kOwn.length), null);
    drawPresets('');
  }, { id: 'preset-forget' });
  const drawPresets = (/** @type {string} */ shown) => {
    const own = Object.keys(keptPresets()).sort();
    put(
      preset,
      h('option', { value: '' }, words.own_choice),
      ...Object.keys(kPresets).map((name) => h('option', { value: name }, words.presets[/** @type {keyof typeof kPresets} */ (name)])),
      ...own.map((name) => h('option', { value: kOwn + name }, name)),
    );
    preset.value = shown;
    forget.hidden = !preset.value.startsWith(kOwn);
  };
  preset.addEventListener('change', () => {
    const name = preset.value;
    const form = name.startsWith(kOwn) ? keptPresets()[name.slice(kOwn.length)] : kPresets[/** @type {keyof typeof kPresets} */ (name)];
    const { origin, takeoff_height_m } = read();
    const shown_area = area.field.value;
    if (form) fill({ ...form, origin, takeoff_height_m, boundary: null });
    area.field.value = shown_area;
    forget.hidden = !name.startsWith(kOwn);
  });
  const name_of_preset = h('input', { id: 'preset-name', class: 'field', type: 'text', maxlength: 60, placeholder: words.preset_name, 'aria-label': words.preset_name });
  const keep = button(strings.flights.save, () => {
    const name = name_of_preset.value.trim();
    if (name === '' || !check()) return name_of_preset.focus();
    if (keepPreset(name, read())) {
      drawPresets(kOwn + name);
      name_of_preset.value = '';
    } else refuse(words.not_kept);
  }, { id: 'preset-keep' });

  const send = h('button', { type: 'submit', class: 'button primary', id: 'options-submit' }, submit);
  const form = h(
    'form',
    { class: 'export-form', id: 'options-form', novalidate: true },
    h('div', { class: 'export-row' }, h('label', { for: preset.id }, words.preset), h('div', { class: 'export-fields' }, preset, forget)),
    row('resolution_cm', typed.resolution_cm, not_finer.row),
    row('method', choices.method),
    row('surface', choices.surface),
    row('heights', choices.heights),
    row('boundary', area.field, h('div', { class: 'row' }, area.browse, area.file)),
    h('fieldset', { class: 'option-layers' }, h('legend', {}, words.names.layers), ...layers.map(({ row: line }) => line), h('small', { class: 'muted' }, words.hints.layers)),
    h(
      'details',
      { class: 'option-more' },
      h('summary', {}, words.more),
      row('max_look_deg', typed.max_look_deg),
      row('readout_ms', typed.readout_ms),
      row('format', choices.format),
      row('quality', typed.quality),
      row('origin', typed.origin),
      row('takeoff_height_m', typed.takeoff_height_m),
    ),
    h('div', { class: 'export-row' }, h('label', { for: name_of_preset.id }, words.keep_as), h('div', { class: 'export-fields' }, name_of_preset, keep)),
    refusal,
    h('div', { class: 'dialog-actions' }, closeButton(), send),
  );
  form.addEventListener('input', (event) => {
    if (event.target !== preset && event.target !== name_of_preset) drawPresets('');
    check();
  });
  const closed = new AbortController();
  form.addEventListener('submit', async (event) => {
    event.preventDefault();
    refuse('');
    const asked = check();
    if (!asked) {
      const wrong = fields.find((name) => typed[name].getAttribute('aria-invalid') === 'true') ?? 'resolution_cm';
      typed[wrong].closest('details')?.setAttribute('open', '');
      typed[wrong].focus();
      return;
    }
    const cut = asked.boundary && jobArea(asked.boundary);
    if (cut === null) return refuse(words.large_area);
    send.disabled = true;
    try {
      const meant = await confirmCoarse(flight_id, cut ? { ...asked, boundary: cut } : asked, { signal: closed.signal });
      if (!dialog.open) return;  // cancelled meanwhile
      if (meant) {
        await on_submit(meant);
        dialog.close();
      } else typed.resolution_cm.focus();
    } catch (error) {
      refuse(messageOf(error));
    }
    send.disabled = false;
  });
  const dialog = titledDialog('options-dialog', title, hint && h('p', { class: 'muted' }, hint), form);
  drawPresets('');
  fill(formOf(options));
  void ask(dialog).then(() => closed.abort());
}

/** @param {Choice} name @param {string} value */
const choiceWords = (name, value) => /** @type {Record<string, string>} */ (strings.options.choices[name])[value];

/** @param {JobOptions} options @returns {string} what differs from the usual, in words; '' for nothing */
export function optionWords(options) {
  const words = strings.options;
  const form = formOf(options);
  const said = (/** @type {string} */ figure) => number(parseNumber(figure), { maximumFractionDigits: 6, useGrouping: false });
  const chosen = Object.fromEntries(chosenIn(form).map(([name, value]) => [name, choiceWords(name, value)]));
  return dotted(
    form.resolution_cm && `${said(form.resolution_cm)} cm`,
    chosen.method,
    chosen.surface,
    chosen.heights,
    form.max_look_deg && `${words.names.max_look_deg} ${said(form.max_look_deg)}°`,
    form.readout_ms && `${words.names.readout_ms} ${said(form.readout_ms)} ms`,
    chosen.format,
    form.quality && `${words.names.quality} ${form.quality}`,
    form.origin && `${words.names.origin} ${form.origin}`,
    form.takeoff_height_m && `${words.names.takeoff_height_m} ${said(form.takeoff_height_m)} m`,
    form.boundary && strings.exports.cut,
  );
}

/** What was asked for last, to be asked for again. @param {Flight} flight @returns {JobOptions} */
export const lastOptions = ({ id, job }) => (job?.options && !movesMap(job) ? job.options : chosenOptions(id));

/**
 * What a finished map was made with, in words. The server knows the last job's options alone: where that made no map, as it failed
 * or moved one, or came with its map, those of the map are not known.
 * @param {Flight} flight
 * @returns {string|null} null: not known
 */
export function madeWith({ job }) {
  if (!job?.options || job.state !== 'successful' || movesMap(job) || job.options.import_file) return null;
  return optionWords(job.options) || strings.options.standard;
}

/**
 * For a map that is still to be made: what is chosen stands beside the button and counts when the job is begun.
 * @param {string} flight_id
 * @param {() => Outline[]} outlines on the map
 * @returns {HTMLElement}
 */
export function optionsButton(flight_id, outlines = () => []) {
  const words = strings.options;
  const chosen = h('small', { class: 'muted', id: 'options-chosen' });
  const draw = () => {
    const text = optionWords(chosenOptions(flight_id));
    chosen.textContent = text && words.chosen(text);
  };
  const open = () =>
    askOptions({
      flight_id,
      title: words.title,
      submit: words.use,
      options: chosenOptions(flight_id),
      outlines: outlines(),
      on_submit: (options) => {
        chooseOptions(flight_id, options);
        draw();
      },
    });
  draw();
  return h('span', { class: 'option-choice' }, button(words.action, open, { picture: 'sliders', id: 'options-open' }), chosen);
}
