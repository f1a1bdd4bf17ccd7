// Wires the page together: the address decides what is open, the list is kept fresh, files start uploads.
/** @import { Flight } from './shared/types.js' */
/** @import { Route } from './shared/router.js' */
/** @import { Selection } from './upload/drop_files.js' */
import { takeSharedToken } from './shared/access.js';
import { announce, showError, showNote } from './shared/announce.js';
import { createFlight, getFlight, getTrash, listFiles, listFlights, renameFlight } from './shared/api.js';
import { deleteWithUndo, removeForGood, restore } from './flight/deletions.js';
import { askName, askWhereTo } from './shared/dialogs.js';
import { byId, put } from './shared/dom.js';
import { dropZone } from './upload/drop_zone.js';
import { glanceAtPhoto, kHeadBytes } from './upload/exif_reader.js';
import { flightList, mayChange } from './flight/flight_list.js';
import { FlightView } from './flight/flight_view.js';
import { clipName } from './shared/format.js';
import { icon } from './shared/icons.js';
import { go, watchRoute } from './shared/router.js';
import { showShareDialog } from './flight/share_dialog.js';
import { mayUpload } from './shared/own_access.js';
import { bottomSheet } from './shared/sheet.js';
import { Stage } from './map/stage.js';
import { strings } from './shared/strings.js';
import { trashList } from './flight/trash_list.js';
import { isUploading, startUpload, uploadOf } from './upload/uploads.js';
import { welcomeView } from './upload/welcome.js';

takeSharedToken();
// A share link that is opened while the page is open: everything is loaded again, with its token.
addEventListener('hashchange', () => {
  if (takeSharedToken()) location.reload();
});
const stage = new Stage();
const panel_body = byId('panel-body');
const sheet = bottomSheet(() => stage.resize());
/** @type {FlightView|null} */
let open_view = null;

const pickers = dropZone((selection) => void takeFiles(selection));
const list = flightList({ rename, remove: (flight) => void remove(flight) });
const trash = trashList({
  restore: (flight) => void restore(flight, () => void refreshList()),
  remove: (flight) => void removeForGood(flight, () => void refreshList()),
});
list.element.append(trash.element);
byId('welcome').append(welcomeView(pickers));
put(byId('new-flight'), icon('plus'), strings.flights.new_flight);
byId('new-flight').addEventListener('click', pickers.choose_folder);

// A guest who only reads is offered nothing that the server would refuse.
void mayUpload().then((may) => document.body.toggleAttribute('data-reads-only', !may));

/** @param {Flight} flight */
async function rename(flight) {
  const name = await askName(flight.name);
  if (!name) return;
  try {
    const renamed = await renameFlight(flight.id, clipName(name));
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
  if (!(await deleteWithUndo(flight, () => void refreshList()))) return;
  focus_list = true;
  if (open_view?.id === flight.id) {
    go({ view: 'home' });
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

/** @param {Selection} selection */
async function takeFiles(selection) {
  try {
    if (!(await mayUpload())) {
      showNote(strings.access.reads_only, { is_error: true });
      return;
    }
    const open = open_view?.flight && mayChange(open_view.flight) ? open_view.flight : null;
    let id = open?.id ?? '';
    if (open && open.state !== 'empty' && !uploadOf(open.id) && !(await isRest(open, selection))) {
      const answer = await askWhereTo(selection.chosen.length, open.name);
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
 * Is this the rest of an upload that was broken off? Then no dialog is needed.
 * @param {Flight} flight
 * @param {Selection} selection
 */
async function isRest(flight, selection) {
  if (flight.state !== 'uploaded') return false;
  const stored = new Set((await listFiles(flight.id)).map(({ name }) => name));
  return selection.chosen.some(({ name }) => stored.has(name));
}

/** By the day its first photo was taken, as the camera's clock had it; else by that of the oldest file. @param {Selection} selection */
async function defaultName({ chosen }) {
  const first = chosen.find(({ name }) => /\.(jpe?g|tiff?|dng)$/i.test(name));
  const { taken_s } = first ? glanceAtPhoto(await first.file.slice(0, kHeadBytes).arrayBuffer()) : { taken_s: null };
  const taken_ms = taken_s === null ? Math.min(...chosen.map(({ file }) => file.lastModified)) : 1000 * taken_s;
  return strings.flights.default_name(new Date(taken_ms).toLocaleDateString(undefined, { dateStyle: 'medium', timeZone: taken_s === null ? undefined : 'UTC' }));
}

/** @param {Route} route */
function show(route) {
  const keeps_view = route.view !== 'home' && open_view?.id === route.id;
  document.body.dataset.view = route.view === 'home' ? 'home' : 'flight';
  byId('welcome').hidden = route.view !== 'home';
  if (!keeps_view) {
    open_view?.close();
    open_view = null;
  }
  if (route.view === 'home') {
    stage.hide();
    document.title = 'Skyquilt';
    put(panel_body, list.element);
    focusList();
    void refreshList();
    return;
  }
  stage.endCompare();
  void openFlight(route);
}

/** @param {Extract<Route, {id: string}>} route */
async function openFlight(route) {
  if (!open_view) {
    stage.prepare();
    const had_focus = document.activeElement !== document.body;
    open_view = new FlightView(route.id, stage, {
      rename,
      remove: (flight) => void remove(flight),
      share: showShareDialog,
      add_photos: pickers.choose_folder,
      show_map: sheet.close,
      on_flight: (flight) => {
        byId('panel').setAttribute('aria-label', flight.name);
      },
    });
    put(panel_body, open_view.element);
    panel_body.scrollTop = 0;
    const view = open_view;
    await view.refresh();
    if (open_view !== view) return;
    if (view.flight) announce(view.flight.name);
    if (had_focus) document.getElementById('flight-title')?.focus({ preventScroll: true });
  }
  if (route.view !== 'compare' || !open_view.flight) return;
  try {
    await stage.compare(open_view.flight, await getFlight(route.other));
  } catch (error) {
    showError(error);
    go({ view: 'flight', id: route.id });
  }
}

let list_timer = 0;
/** Loads the list, and again soon while something is happening to a flight. */
async function refreshList() {
  clearTimeout(list_timer);
  let delay_ms = 30_000;
  try {
    // The list does not wait for the trash, nor fail with it.
    void getTrash().then((kept) => trash.update(kept.flights), () => trash.update([]));
    const flights = await listFlights();
    list.update(flights);
    document.body.toggleAttribute('data-has-flights', flights.length > 0);
    if (flights.some(({ state, id }) => state === 'queued' || state === 'processing' || uploadOf(id))) delay_ms = 2000;
  } catch (error) {
    list.update(null, `${strings.errors.list} ${error instanceof Error ? error.message : ''}`);
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
