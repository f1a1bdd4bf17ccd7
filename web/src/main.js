// Wires the page together: the address decides what is open, the list is kept fresh, files start uploads. What an open
// flight needs is loaded when one is opened.
/** @import { Flight } from './shared/types.js' */
/** @import { FlightView } from './flight/flight_view.js' */
/** @import { Route } from './shared/router.js' */
/** @import { Selection } from './upload/drop_files.js' */
/** @import { Wish } from './upload/drop_zone.js' */
import { reloadWithToken, takeSharedToken, token_kept } from './shared/token.js';
import { announce, showError, showNote } from './shared/announce.js';
import { changeFlight, createFlight, getFlight, getTrash, listFiles, listFlights, mayUpload, messageOf } from './shared/api.js';
import { byId, h, linkSettled, loadStyle, put } from './shared/dom.js';
import { mayChange } from './flight/flight_words.js';
import { flightList } from './home/flight_list.js';
import { overviewMap, placeOf } from './home/overview_map.js';
import { clipName, formatDate } from './shared/format.js';
import { button, icon } from './shared/icons.js';
import { keepLanguage, kLanguages, language } from './shared/language.js';
import { go, routeHash, watchRoute } from './shared/router.js';
import { strings } from './shared/strings.js';
import { dropZone, holdsUploads, isUploading, stoppedUploadOf, uploadOf } from './upload/drop_zone.js';

takeSharedToken();
// A share link that is opened while the page is open: everything is loaded again, with its token.
addEventListener('hashchange', () => {
  if (takeSharedToken()) reloadWithToken();
});
// An upload goes on with the next token: a page that is loaded anew would have to be given its files again.
token_kept.addEventListener('change', (event) => {
  if (!holdsUploads()) return;
  event.preventDefault();
  void refreshList();
  void open_view?.refresh();
});
function languageChoice() {
  const label = strings.page.language;
  const names = /** @type {[keyof typeof kLanguages, string][]} */ (Object.entries(kLanguages));
  const choice = h('select', { class: 'language', id: 'language', 'aria-label': label, title: label, autocomplete: 'off' }, ...names.map(([tag, name]) => h('option', { value: tag, lang: tag, selected: tag === language }, name)));
  choice.addEventListener('change', () => {
    keepLanguage(/** @type {keyof typeof kLanguages} */ (choice.value));
    // Every word is on the page already. An upload would have to be given its files again.
    if (holdsUploads()) showNote(strings.page.language_later);
    else reloadWithToken();
  });
  return choice;
}

/** What index.html leaves out, because it has words: links and buttons around the panel. */
function fillFrame() {
  const words = strings.page;
  // The address names what is open: it is no place to jump to.
  const skip = (/** @type {Event} */ event) => {
    event.preventDefault();
    panel_body.focus();
  };
  document.body.prepend(h('a', { class: 'skip', href: '#panel-body', on: { click: skip } }, words.skip));
  byId('panel').prepend(
    h('button', { class: 'sheet-handle', id: 'sheet-handle', type: 'button', 'aria-expanded': 'true', 'aria-controls': 'panel-body' }, h('span', { class: 'visually-hidden', id: 'sheet-handle-text' }, strings.sheet.close)),
  );
  byId('home-link').setAttribute('aria-label', words.home);
  byId('panel-head').append(languageChoice(), button(strings.flights.new_flight, null, { picture: 'plus', id: 'new-flight' }));
}

fillFrame();
const panel_body = byId('panel-body');
const welcome = byId('welcome');
/** @type {FlightView|null} */
let open_view = null;

const pickers = dropZone((selection, wish) => void takeFiles(selection, wish));
const list = flightList({
  rename,
  remove: (flight) => void remove(flight).catch(showError),
  on_shown: (flights) => overview.show(flights),
  on_point: (flight) => overview.point(flight?.id ?? ''),
  // In place of the address that is there: a step back leaves the list rather than one choice.
  on_tags: (tags) => history.replaceState(null, '', routeHash({ view: 'home', tags })),
});
const overview = overviewMap({ on_point: list.point });
const drop_bar = h(
  'p',
  { class: 'drop-bar', id: 'drop-bar', hidden: true },
  icon('upload'),
  h('span', { class: 'drop-bar-hint' }, strings.drop.anywhere),
  button(strings.drop.folder, pickers.choose_folder, { class: 'text-button', id: 'bar-folder' }),
  button(strings.drop.files, pickers.choose_files, { class: 'text-button', id: 'bar-files' }),
);
const list_end = h('div', { class: 'list-end' });
list.element.prepend(drop_bar, h('p', { class: 'reads-only muted', id: 'reads-only' }, strings.welcome.guest_lead));
list.element.append(list_end);
byId('new-flight').addEventListener('click', pickers.new_flight);

/** @typedef {Awaited<ReturnType<typeof loadParts>>} Parts */
/** @type {Promise<Parts>|null} */
let asked_parts = null;
/** @type {Parts|null} */
let parts = null;

/** What an open flight needs, with its styles. */
async function loadParts() {
  const files = /** @type {DocumentFragment} */ (/** @type {HTMLTemplateElement} */ (byId('open-parts')).content.cloneNode(true));
  const styles = [...files.querySelectorAll('link[rel="stylesheet"]:not([media])')].map(linkSettled);
  document.head.append(files);
  const words = import('./shared/flight_strings.js').then(({ loadFlightStrings }) => loadFlightStrings());
  const [module] = await Promise.all([import('./open_parts.js'), words, ...styles]);
  const stage = new module.Stage();
  const sheet = module.bottomSheet(() => stage.resize());
  stage.makeRoom = sheet.close;
  return { ...module, stage, sheet };
}

/** @returns {Promise<Parts>} */
async function needParts() {
  try {
    parts = await (asked_parts ??= loadParts());
    return parts;
  } catch (error) {
    asked_parts = null;  // the next click tries again
    console.debug(error);
    throw new Error(strings.errors.unreachable);
  }
}
// Who points at a flight is about to open it.
list.element.addEventListener('pointerenter', () => void needParts().catch(() => undefined), { once: true });

/** The large part of the home view: where the flights are, or how to make the first. @param {Flight[]} flights */
function showLargePart(flights) {
  if (!flights.some(placeOf)) void showWelcome().catch(showError);
  else if (!overview.element.isConnected) put(welcome, overview.element);
}

async function showWelcome() {
  if (welcome.querySelector('.welcome-inner')) return;
  const [{ welcomeView }] = await Promise.all([import('./home/welcome.js'), loadStyle('styles/welcome.css')]);
  put(welcome, welcomeView(pickers));
}

// A guest who only reads is offered nothing that the server would refuse.
void mayUpload().then((may) => document.body.toggleAttribute('data-reads-only', !may));

/** @param {Flight} flight */
async function rename(flight) {
  try {
    const { askName } = await needParts();
    const name = await askName(flight.name);
    if (!name) return;
    const renamed = await changeFlight(flight.id, { name: clipName(name) });
    if (open_view?.id === flight.id && open_view.flight) {
      open_view.flight.name = renamed.name;
      open_view.drawHead(open_view.flight);
    }
  } catch (error) {
    showError(error);
  }
  await refreshList();
}

/** @param {Flight} flight */
async function remove(flight) {
  const { deleteWithUndo } = await needParts();
  if (!(await deleteWithUndo(flight, () => void refreshList()))) return;
  focus_list = true;
  if (open_view?.id === flight.id) {
    go({ view: 'home', tags: list.tags() });
    return;
  }
  await refreshList();
  focusList();
}

// What had the keyboard's focus went away with a deleted flight: the list's heading takes it.
let focus_list = false;
function focusList() {
  if (focus_list) document.getElementById('flights-heading')?.focus();
  focus_list = false;
}

/** @param {Selection} selection @param {Wish} wish */
async function takeFiles(selection, wish) {
  try {
    if (!(await mayUpload())) {
      showNote(strings.access.reads_only, { is_error: true });
      return;
    }
    const { askWhereTo, startUpload } = await needParts();
    const open = wish !== 'new' && open_view?.flight && mayChange(open_view.flight) ? open_view.flight : null;
    let id = open?.id ?? '';
    if (open && (await mayBeOfAnother(open, selection, wish))) {
      const answer = await askWhereTo(selection.chosen.length, open.name, Boolean(open.tilejson));
      if (answer === '') return;
      if (answer === 'new') id = '';
    }
    if (!id) id = (await createFlight(clipName(selection.folder || (await defaultName(selection))))).id;
    const session = startUpload(id, selection);
    session.addEventListener('job', () => void refreshList());
    if (open_view?.id === id) await open_view.refresh();
    else go({ view: 'flight', id });
  } catch (error) {
    showError(error);
  }
}

/**
 * Two flights in one make a map of neither: whoever has not said where files go is asked, but for the first of a flight
 * and for the rest of an upload, of which some are there already. Cards number their photos alike: a file is known by
 * its size too.
 * @param {Flight} flight that is open
 * @param {Selection} selection
 * @param {Wish} wish
 */
async function mayBeOfAnother(flight, { chosen }, wish) {
  const upload = uploadOf(flight.id) ?? stoppedUploadOf(flight.id);
  if (flight.state !== 'empty' && flight.state !== 'uploaded') return !(upload && wish === 'add');
  if (wish === 'add' || (flight.state === 'empty' && !upload)) return false;
  const isOther = (/** @type {{name: string, bytes: number}[]} */ files) => {
    const known = new Map(files.map(({ name, bytes }) => [name, bytes]));
    const again = chosen.filter(({ name }) => known.has(name));
    return again.length === 0 ? null : again.some(({ name, file }) => known.get(name) !== file.size);
  };
  // What is being sent is known here; the server would be asked behind it.
  return isOther(upload?.queue.items ?? []) ?? isOther(await listFiles(flight.id)) ?? true;
}

/** By the day and the place its first photo was taken, as the camera had them; else by the day of the oldest file. @param {Selection} selection */
async function defaultName({ chosen }) {
  const { glanceAtPhoto, headOf, kHeadBytes, nearestPlace } = await needParts();
  const first = chosen.find(({ name }) => /\.(jpe?g|tiff?|dng)$/i.test(name));
  const { taken_s, lat_deg, lon_deg } = first ? glanceAtPhoto(await headOf(first.file, kHeadBytes)) : { taken_s: null, lat_deg: null, lon_deg: null };
  const taken_ms = taken_s === null ? Math.min(...chosen.map(({ file }) => file.lastModified)) : 1000 * taken_s;
  const date = formatDate(new Date(taken_ms).toISOString(), { time_zone: taken_s === null ? undefined : 'UTC' });
  const place = lat_deg === null || lon_deg === null ? '' : await nearestPlace(lat_deg, lon_deg);
  return place ? strings.flights.name_of_place(place, date) : strings.flights.default_name(date);
}

const homeHash = () => routeHash({ view: 'home', tags: list.tags() });

/** @param {Route} route */
function show(route) {
  // A dialog belongs to what was open. On a phone a step back is the way out of one.
  for (const dialog of document.querySelectorAll('dialog')) dialog.close();
  const keeps_view = route.view !== 'home' && open_view?.id === route.id;
  document.body.dataset.view = route.view === 'home' ? 'home' : 'flight';
  welcome.hidden = route.view !== 'home';
  // From a flight the way back leads to the list as it was.
  byId('home-link').setAttribute('href', route.view === 'home' ? '#/' : homeHash());
  if (!keeps_view) {
    open_view?.close();
    open_view = null;
    byId('panel').setAttribute('aria-label', strings.page.panel);
  }
  if (route.view === 'home') {
    open_turn += 1;
    if (parts) parts.stage.hide();
    else byId('map-area').hidden = true;
    document.title = 'Skyquilt';
    list.choose(route.tags ?? []);
    put(panel_body, list.element);
    focusList();
    void refreshList();
    return;
  }
  parts?.stage.endCompare();
  const opening = openFlight(route);
  const turn = open_turn;
  opening.catch((error) => {
    if (open_view || turn !== open_turn) showError(error);
    // The address is this flight's already: to choose it again in the list would be no change.
    else put(panel_body, h('div', { class: 'callout callout-error', role: 'alert' }, h('p', {}, messageOf(error)), button(strings.errors.retry, reloadWithToken, { picture: 'retry', id: 'open-retry' })));
  });
}

let open_turn = 0;
/** @param {Extract<Route, {id: string}>} route */
async function openFlight(route) {
  const turn = (open_turn += 1);
  const { FlightView, showShareDialog, sheet, stage } = await needParts();
  if (turn !== open_turn) return;
  if (!open_view) {
    stage.prepare();
    const focused = document.activeElement;
    open_view = new FlightView(route.id, stage, {
      rename,
      remove: (flight) => void remove(flight).catch(showError),
      share: showShareDialog,
      add_photos: pickers.add_photos,
      home: homeHash,
      tags: list.known_tags,
      show_map: sheet.close,
    });
    put(panel_body, open_view.element);
    panel_body.scrollTop = 0;
    const view = open_view;
    await view.refresh();
    if (open_view !== view) return;
    if (view.flight) announce(view.flight.name);
    // Who went on meanwhile is left there.
    if (focused !== document.body && [document.body, focused].includes(document.activeElement)) document.getElementById('flight-title')?.focus({ preventScroll: true });
  }
  const left = open_view.flight;
  if (route.view !== 'compare' || !left || turn !== open_turn) return;
  try {
    const right = await getFlight(route.other);
    if (turn !== open_turn) return;  // somebody has gone on
    await stage.compare(left, right);
  } catch (error) {
    if (turn !== open_turn) return;
    showError(error);
    go({ view: 'flight', id: route.id });
  }
}

/** @type {ReturnType<typeof import('./home/trash_list.js').trashList>|null} */
let trash = null;
let trash_turn = 0;
/** The trash lies below the list: asked for when one gets there. It fails alone. */
async function refreshTrash() {
  const turn = (trash_turn += 1);
  try {
    const { flights } = await getTrash();
    if (!trash) {
      const { trashList } = await import('./home/trash_list.js');
      trash ??= trashList({
        restore: (flight) => void needParts().then(({ restore }) => restore(flight, () => void refreshList())).catch(showError),
        remove: (flight) => void needParts().then(({ removeForGood }) => removeForGood(flight, () => void refreshList())).catch(showError),
      });
      list_end.append(trash.element);
    }
    if (turn === trash_turn) trash.update(flights);
  } catch (error) {
    console.debug('no trash', error);
    if (turn === trash_turn) trash?.update([]);
  }
}
const isAtEnd = () => list_end.isConnected && list_end.getBoundingClientRect().top < innerHeight;
addEventListener('scroll', () => {
  if (trash_turn === 0 && has_list && isAtEnd()) void refreshTrash();  // after that with the list
}, { capture: true, passive: true });

let has_list = false;
let list_timer = 0;
let list_turn = 0;
/** Loads the list, and again soon while something is happening to a flight. */
async function refreshList() {
  clearTimeout(list_timer);
  const turn = (list_turn += 1);
  let delay_ms = 30_000;
  try {
    const flights = await listFlights();
    if (turn !== list_turn) return;  // what was asked for later tells what is so now
    drop_bar.hidden = flights.length === 0;
    list.update(flights);
    showLargePart(flights);
    document.body.toggleAttribute('data-has-flights', flights.length > 0);
    has_list = true;
    if (trash || isAtEnd()) void refreshTrash();
    if (flights.some(({ state, id }) => state === 'queued' || state === 'processing' || uploadOf(id))) delay_ms = 2000;
  } catch (error) {
    if (turn !== list_turn) return;
    list.update(null, `${strings.errors.list} ${messageOf(error)}`);
    delay_ms = 5000;
  }
  clearTimeout(list_timer);
  if (document.body.dataset.view === 'home') list_timer = window.setTimeout(() => void refreshList(), delay_ms);
}

document.addEventListener('visibilitychange', () => {
  if (!document.hidden && document.body.dataset.view === 'home') void refreshList();
});
addEventListener('beforeunload', (event) => {
  if (isUploading()) event.preventDefault();
});
// On paper nothing is folded away.
addEventListener('beforeprint', () => {
  for (const fold of document.querySelectorAll('#report details')) fold.setAttribute('open', '');
});
watchRoute(show);
