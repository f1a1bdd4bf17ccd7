// The notes and measurements of an open flight: on the map for whoever opens it, listed in the panel, written and deleted
// by who may. Loaded once the map is there.
/** @import { Flight } from '../shared/types.js' */
/** @import { Stage } from '../map/stage.js' */
/** @import { Note } from './note_shape.js' */
import { isScaleKnown } from '../flight/flight_words.js';
import { announce, showNote } from '../shared/announce.js';
import { messageOf } from '../shared/api.js';
import { arrange, h, keptElements, put } from '../shared/dom.js';
import { button, icon, iconButton, onFirstClick } from '../shared/icons.js';
import { savingRow } from '../map/measurement_files.js';
import { strings } from '../shared/flight_strings.js';
import { areaIn, chosenUnits, lengthIn, units_chosen } from '../shared/units.js';
import { NoteDocument } from './note_document.js';
import { noteForm } from './note_form.js';
import { boundsOfNote, geometryOf, measurementOfNote, noteOf } from './note_shape.js';

const kStale_ms = 20_000;
const kIcons = /** @type {const} */ ({ Point: 'pencil', LineString: 'ruler', Polygon: 'area' });

/** What is being written, by flight: who comes back to one goes on. @type {Map<string, {note: Note|null, draft: Note}>} */
const drafts = new Map();
addEventListener('beforeunload', (event) => {
  if (drafts.size > 0) event.preventDefault();
});

/** What was measured, in words; '' of a point. @param {Note} note @param {boolean} is_scale_known */
function figure(note, is_scale_known) {
  if (note.geometry.type === 'Point') return '';
  if (!is_scale_known) return strings.photo.unknown;
  const { length_m, area_m2 } = measurementOfNote(note);
  return area_m2 === null ? lengthIn(length_m, chosenUnits()) : areaIn(area_m2, chosenUnits());
}

/**
 * @param {Flight} flight
 * @param {Stage} stage
 * @param {boolean} may_change
 * @returns {{element: HTMLElement, is_writing: boolean, close: () => void}} is_writing: a form is open
 */
export function notesSection(flight, stage, may_change) {
  const words = strings.notes;
  const notes = new NoteDocument(flight.id, may_change);
  const counted = h('span', { class: 'muted' });
  const state = h('p', { class: 'muted fine', id: 'notes-state', role: 'status' });
  const form_place = h('div', {});
  const list = h('ul', { class: 'note-list', id: 'note-list' });
  const add_button = button(words.add, () => openForm(null), { picture: 'plus', id: 'note-add' });
  const saving = savingRow('notes', () => ({ file: words.file_name, measurements: notes.notes.map(measurementOfNote) }));
  const element = h(
    'details',
    { class: 'block notes no-print', id: 'notes', open: true, hidden: true },
    h('summary', {}, words.heading, ' ', counted),
    h('div', { class: 'notes-body' }, may_change && add_button, form_place, list, state, saving),
  );
  /** @type {ReturnType<typeof noteForm>|null} */
  let form = null;
  let is_closed = false;
  let read_ms = 0;

  const keepDraft = () => {
    const draft = form?.draft;
    if (form && draft) drafts.set(flight.id, { note: form.note, draft });
    else drafts.delete(flight.id);
  };
  const closeForm = () => {
    form?.close();
    form = null;
    put(form_place);
    keepDraft();
  };
  /** @param {Note|null} note null: a new one @param {Note} [draft] what of it was written already */
  const openForm = (note, draft) => {
    closeForm();
    const opener = note ? `[data-note="${note.id}"] .note-edit` : '#note-add';
    const end = () => {
      closeForm();
      /** @type {HTMLElement|null} */ (element.querySelector(opener))?.focus();
    };
    form = noteForm(stage, note, {
      on_end: end,
      on_save: (made) => {
        notes.set(made);
        end();
      },
    }, draft ?? note);
    put(form_place, form.element);
    form.element.addEventListener('input', keepDraft);
    keepDraft();
    if (!draft) form.element.querySelector('input')?.focus();
  };
  /** @param {Note} note */
  const remove = (note) => {
    if (form?.note?.id === note.id) closeForm();  // what is being written of another stays
    notes.remove(note.id);
    showNote(words.removed(note.properties.name), { action: { label: strings.flights.undo, run: () => notes.set(note) } });
    (/** @type {HTMLElement|null} */ (list.querySelector('button')) ?? add_button).focus();
  };
  /** @param {Note} note */
  const row = (note) => {
    const { name, text } = note.properties;
    return h(
      'li',
      { 'data-note': note.id },
      icon(kIcons[note.geometry.type]),
      button(name, () => stage.showBounds(boundsOfNote(note)), { class: 'text-button note-show', title: words.show(name) }),
      h('span', { class: 'muted note-figure' }, figure(note, isScaleKnown(flight.quality))),
      may_change && iconButton('pencil', words.edit(name), () => openForm(note), '', 'icon-button note-edit'),
      may_change && iconButton('trash', words.remove(name), onFirstClick(() => remove(note)), '', 'icon-button note-remove'),
      text && h('p', { class: 'note-words' }, text),
    );
  };
  // By what it says: the server may write the same note in another order.
  const contentOf = (/** @type {Note} */ { id, geometry, properties: { name, text } }) => JSON.stringify([id, name, text ?? '', geometry.type, geometry.coordinates]);
  const rowsOf = keptElements((/** @type {Note} */ note) => note.id, (note) => contentOf(note) + chosenUnits(), row);
  /** @type {string|null} */
  let on_map = null;
  /** @param {string} id chosen on the map */
  const choose = (id) => {
    element.open = true;
    const chosen = list.querySelector(`[data-note="${id}"]`);
    chosen?.scrollIntoView({ block: 'nearest' });
    /** @type {HTMLElement|null} */ (chosen?.querySelector('.note-show'))?.focus({ preventScroll: true });
  };
  const draw = () => {
    const now = notes.notes;
    const focused = list.contains(document.activeElement) ? document.activeElement : null;
    const focused_id = focused?.closest('li')?.getAttribute('data-note');
    const focused_class = focused?.className.split(' ').pop();
    counted.textContent = now.length > 0 ? words.count(now.length) : '';
    arrange(list, rowsOf(now));
    if (focused_id && !list.contains(document.activeElement)) /** @type {HTMLElement|null} */ (list.querySelector(`[data-note="${focused_id}"] .${focused_class}`))?.focus({ preventScroll: true });
    saving.hidden = now.length === 0;
    element.hidden = now.length === 0 && !may_change;
    const content = now.map(contentOf).join();
    if (content !== on_map) stage.showNotes(now, choose);
    on_map = content;
    tell();
  };
  const tell = () => {
    const text = notes.state === 'waiting' ? words.waiting(notes.failure) : notes.state === 'failed' ? words.failed(notes.failure) : notes.state === 'saving' ? words.saving : notes.notes.length === 0 ? words.none : words.saved;
    state.dataset.state = notes.state;
    state.classList.toggle('amber', notes.state === 'waiting' || notes.state === 'failed');
    if (state.firstChild?.textContent === text) return;
    put(state, text, notes.state === 'failed' && button(strings.errors.retry, () => void notes.flush(), { class: 'text-button', id: 'notes-retry' }));
  };
  notes.addEventListener('change', draw);
  notes.addEventListener('saved', tell);
  notes.addEventListener('merged', () => showNote(words.merged, { duration_ms: 15_000 }));
  units_chosen.addEventListener('change', draw);
  const look = () => {
    if (document.hidden || is_closed || performance.now() - read_ms < kStale_ms) return;
    read_ms = performance.now();
    notes.refresh().catch((error) => console.debug('notes', error));  // what is shown stays
  };
  document.addEventListener('visibilitychange', look);

  const read = async () => {
    try {
      read_ms = performance.now();
      await notes.load();
      if (is_closed || !may_change) return;
      stage.keepMeasured((places, kind, name) => {
        const note = noteOf(name, '', geometryOf(places, kind));
        notes.set(note);
        announce(words.kept(name));
        choose(note.id);
      });
      const left = drafts.get(flight.id);
      if (left) openForm(left.note, left.draft);
    } catch (error) {
      if (is_closed) return;
      element.hidden = false;
      const again = () => {
        put(state);
        void read();
      };
      put(state, words.unread(messageOf(error)), ' ', button(strings.errors.retry, again, { class: 'text-button' }));
      add_button.hidden = true;
      saving.hidden = true;
      return;
    }
    add_button.hidden = false;
  };
  void read();

  return {
    element,
    get is_writing() {
      return form !== null;
    },
    close() {
      is_closed = true;
      if (form) keepDraft();  // its place may have moved since
      form?.close();
      stage.keepMeasured(null);
      stage.showNotes([], () => undefined);
      notes.removeEventListener('change', draw);
      notes.close();
      units_chosen.removeEventListener('change', draw);
      document.removeEventListener('visibilitychange', look);
    },
  };
}
