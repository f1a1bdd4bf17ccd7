// What index.html leaves out, because it has words: links and buttons around the panel, and the choice of the language.
import { holdsUploads } from '../upload/running_uploads.js';
import { showNote } from './announce.js';
import { byId, h } from './dom.js';
import { icon } from './icons.js';
import { keepLanguage, kLanguages, language } from './language.js';
import { strings } from './strings.js';

/** @typedef {import('./language.js').Language} Language */

function languageChoice() {
  const label = strings.page.language;
  const names = /** @type {[Language, string][]} */ (Object.entries(kLanguages));
  const choice = h('select', { class: 'language', id: 'language', 'aria-label': label, title: label }, ...names.map(([tag, name]) => h('option', { value: tag, lang: tag, selected: tag === language }, name)));
  choice.addEventListener('change', () => {
    keepLanguage(/** @type {Language} */ (choice.value));
    // Every word is on the page already. An upload would have to be given its files again.
    if (holdsUploads()) showNote(strings.page.language_later);
    else location.reload();
  });
  return choice;
}

/** Once, before anything else is shown. */
export function fillFrame() {
  const words = strings.page;
  document.body.prepend(h('a', { class: 'skip', href: '#panel-body' }, words.skip));
  const panel = byId('panel');
  panel.setAttribute('aria-label', words.panel);
  panel.prepend(
    h('button', { class: 'sheet-handle', id: 'sheet-handle', type: 'button', 'aria-expanded': 'true', 'aria-controls': 'panel-body' }, h('span', { class: 'visually-hidden', id: 'sheet-handle-text' }, strings.sheet.close)),
  );
  byId('home-link').setAttribute('aria-label', words.home);
  byId('panel-head').append(languageChoice(), h('button', { type: 'button', class: 'button small', id: 'new-flight' }, icon('plus'), strings.flights.new_flight));
}
