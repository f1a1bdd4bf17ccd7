// The tags of the open flight, where they can be changed: one is added by a word and Enter, taken off by its cross. Where
// the server puts old flights into the trash, whether this one is to be kept.
/** @import { Flight } from '../shared/types.js' */
import { showError } from '../shared/announce.js';
import { changeFlight, ownAccess } from '../shared/api.js';
import { checkRow, h, onEscape } from '../shared/dom.js';
import { button, iconButton } from '../shared/icons.js';
import { strings } from '../shared/flight_strings.js';
import { mayChange } from './flight_words.js';

const kMaxTags = 20;
const kMaxLength = 40;

/**
 * What is typed as tags: words with commas between them.
 * @param {string} text
 * @returns {string[]} each once, none empty
 */
export const typedTags = (text) => [...new Set(text.split(/[,;\n]/).map((tag) => tag.trim().replace(/\s+/g, ' ')).filter(Boolean))];

/**
 * @param {() => Flight} current the flight as it is known when it is changed
 * @param {() => string[]} known tags of other flights, to be proposed
 * @param {(changed: Flight) => void} on_change
 * @returns {HTMLElement|null} null where there is nothing to see and nothing to change
 */
export function tagRow(current, known, on_change) {
  const words = strings.tags;
  const flight = current();
  const tags = flight.tags ?? [];
  const may_change = mayChange(flight);
  if (!may_change && tags.length === 0) return null;
  /** @param {{tags?: string[], keep?: boolean}} change @param {string} focus id of what takes the focus when it is done @returns {Promise<boolean>} whether it is saved */
  const save = async (change, focus) => {
    let is_saved = false;
    try {
      on_change(await changeFlight(flight.id, change));
      is_saved = true;
      await ownAccess();  // the switch is there again
    } catch (error) {
      showError(error);
    }
    document.getElementById(focus)?.focus();
    return is_saved;
  };
  const chip = (/** @type {string} */ tag) => {
    if (!may_change) return h('li', { class: 'tag' }, tag);
    const cross = iconButton('close', words.remove(tag), () => void save({ tags: (current().tags ?? []).filter((other) => other !== tag) }, 'tag-add'), '', 'tag-remove no-print');
    return h('li', { class: 'tag' }, h('span', { class: 'tag-word' }, tag), cross);
  };
  const list = h('ul', { class: 'tags', id: 'flight-tags', 'aria-label': words.heading }, ...tags.map(chip));
  const row = h('div', { class: 'flight-tags' }, list);
  if (may_change && tags.length < kMaxTags) {
    const addTo = async (/** @type {string[]} */ typed) => {
      const is_saved = await save({ tags: [...new Set([...(current().tags ?? []), ...typed])].slice(0, kMaxTags) }, 'tag-add');
      if (!is_saved && add.isConnected) askForTag(typed.join(', '));  // to be sent again
    };
    const askForTag = (refused = '') => askTag(flight, add, known().filter((tag) => !tags.includes(tag)), addTo, refused);
    /** @type {HTMLButtonElement} */
    const add = button(words.add, () => askForTag(), { picture: 'plus', class: 'tag tag-button no-print', id: 'tag-add' });
    row.append(add);
  }
  if (may_change) void ownAccess().then((access) => (access?.keep_days || flight.keep) && row.after(keepSwitch(current, access?.keep_days ?? 0, (keep) => save({ keep }, 'flight-keep'))));
  return row;
}

/**
 * A field in the button's place.
 * @param {Flight} flight
 * @param {HTMLButtonElement} add
 * @param {string[]} proposed
 * @param {(tags: string[]) => Promise<void>} on_tags
 * @param {string} refused what was typed, and could not be saved; '' at first
 */
function askTag(flight, add, proposed, on_tags, refused) {
  const words = strings.tags;
  const input = h('input', { type: 'text', class: 'field tag-input', id: 'tag-input', value: refused, maxlength: kMaxLength, 'aria-label': words.add_label(flight.name), placeholder: words.placeholder, list: 'tag-proposals', autocomplete: 'off', enterkeyhint: 'done' });
  const form = h('form', { class: 'tag-form no-print' }, input, h('datalist', { id: 'tag-proposals' }, ...proposed.map((value) => h('option', { value }))));
  let is_over = false;
  const end = (/** @type {boolean} */ takes) => {
    if (is_over) return;
    is_over = true;
    const typed = takes ? typedTags(input.value) : [];
    form.replaceWith(add);
    if (typed.length > 0) void on_tags(typed);
    else add.focus();
  };
  form.addEventListener('submit', (event) => {
    event.preventDefault();
    end(true);
  });
  onEscape(input, (event) => {
    event.stopPropagation();
    end(false);
  });
  // What was typed is not lost to a click elsewhere, nor refused anew with each.
  input.addEventListener('blur', () => (refused === '' || input.value !== refused) && end(true));
  add.replaceWith(form);
  input.focus();
}

/**
 * @param {() => Flight} current
 * @param {number} keep_days of the server
 * @param {(keep: boolean) => Promise<unknown>} on_keep
 */
function keepSwitch(current, keep_days, on_keep) {
  const words = strings.tags;
  const { input, row } = checkRow(words.keep, 'flight-keep', Boolean(current().keep), async (keep) => {
    await on_keep(keep);
    input.checked = Boolean(current().keep);  // as before where it could not be saved
  });
  input.setAttribute('aria-describedby', 'flight-keep-hint');
  return h(
    'div',
    { class: 'flight-keep no-print' },
    row,
    h('small', { class: 'muted', id: 'flight-keep-hint' }, keep_days ? words.keep_hint(keep_days) : words.keep_no_need),
  );
}
