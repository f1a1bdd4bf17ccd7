// The open flight in the panel: its name, what is happening to it (upload, job, failure), and its report.
/** @import { Flight, Job, Report } from '../shared/types.js' */
/** @import { Stage } from '../map/stage.js' */
import { announce, showError } from '../shared/announce.js';
import { ApiError, getFlight, getReport, messageOf, serverWords, startControl, startJob, startPlacing } from '../shared/api.js';
import { controlSection } from '../control/control_section.js';
import { arrange, byId, h, loadStyle, put } from '../shared/dom.js';
import { flightFacts, isImported, mayChange, stateChip } from './flight_words.js';
import { confirmCoarse } from './coarse_map.js';
import { chosenOptions, forgetChosen, seeLastOptions } from './job_options.js';
import { askOptions, lastOptions, optionsButton } from './options_dialog.js';
import { flightActions } from './flight_actions.js';
import { tagRow } from './flight_tags.js';
import { followFlight } from './follow_flight.js';
import { button, icon, iconButton, onFirstClick } from '../shared/icons.js';
import { isOver, movesMap, watchJob } from './job_watch.js';
import { jobView } from './job_view.js';
import { linksView } from '../sharing/links_view.js';
import { reportView } from './report_view.js';
import { isGuessed } from './result_verdict.js';
import { strings } from '../shared/flight_strings.js';
import { inUnits, units_chosen } from '../shared/units.js';
import { forgetUpload } from '../upload/upload_memory.js';
import { held, stoppedUploadOf, uploadOf } from '../upload/drop_zone.js';
import { uploadView } from '../upload/upload_view.js';
import { waitingView } from './waiting_view.js';

/**
 * @typedef {object} FlightActions
 * @property {(flight: Flight) => void} rename
 * @property {(flight: Flight) => void} remove
 * @property {(flight: Flight) => void} share
 * @property {() => void} add_photos
 * @property {() => string} home address of the list, as it was left
 * @property {() => string[]} tags of all flights of the list, as far as they are known
 * @property {() => void} show_map it is going to be worked on
 */

export class FlightView {
  /** @type {Flight|null} */
  flight = null;
  element = h('div', { class: 'flight-view' });
  #title = h('h1', { class: 'flight-title', id: 'flight-title', tabindex: -1 });
  #acts = h('div', { class: 'head-actions no-print' });
  /** By what the buttons are: they stay while the flight changes, so that a click meanwhile counts. */
  #drawn_acts = '';
  #facts = h('p', { class: 'flight-facts' });
  #name = h('div', {});
  #tags = h('div', {});
  #ways = h('div', {});
  #head = h('div', { class: 'flight-head' }, this.#name, this.#tags, this.#ways);
  /** What is drawn of the tags. */
  #drawn_tags = '';
  #work = h('div', { class: 'work' });
  #result = h('div', { class: 'result' });
  #abort = new AbortController();
  /** @type {(() => void)[]} */
  #closers = [];
  #shown_revision = '';
  #turn = 0;
  /** @type {Report|null} of the revision that is shown */
  #report = null;
  /** @type {(() => void)|null} */
  #endFollowing = null;
  /** @type {{element: HTMLElement, close: () => void}|null} */
  #control = null;
  #is_control_open = false;
  /** @type {ReturnType<typeof import('../notes/notes_section.js').notesSection>|null} */
  #notes = null;
  #notes_place = h('div', {});

  /**
   * @param {string} id
   * @param {Stage} stage
   * @param {FlightActions} actions
   */
  constructor(id, stage, actions) {
    this.id = id;
    this.stage = stage;
    this.actions = actions;
    units_chosen.addEventListener('change', () => this.flight && this.drawHead(this.flight), { signal: this.#abort.signal });
    this.element.append(
      h('a', { class: 'back-link', href: actions.home() }, icon('back'), strings.flights.back),
      this.#head,
      this.#work,
      this.#result,
    );
  }

  close() {
    this.#abort.abort();
    this.#endWork();
    this.#endFollowing?.();
    this.#control?.close();
    this.#notes?.close();
  }

  // Until there is a map, its preview grows.
  #followUntilMap() {
    if (this.flight?.tilejson) {
      this.#endFollowing?.();
      this.#endFollowing = null;
      return;
    }
    this.#endFollowing ??= followFlight(this.id, {
      on_preview: (growth) => {
        const flight = this.flight;
        if (!flight || flight.tilejson) return;
        flight.preview = { ...growth, tilejson: flight.preview?.tilejson ?? `/tiles/${this.id}.json?rev=preview` };
        this.stage.grow(flight, growth.changed).catch(showError);
      },
      on_map: () => void this.refresh(),
    });
  }

  #endWork() {
    for (const close of this.#closers) close();
    this.#closers = [];
  }

  /** Reloads the flight and shows its state. */
  async refresh() {
    const turn = (this.#turn += 1);
    const isStale = () => this.#abort.signal.aborted || turn !== this.#turn;
    try {
      const flight = await getFlight(this.id, this.#abort.signal);
      if (isStale()) return;
      this.flight = flight;
      seeLastOptions(flight);
      this.drawHead(flight);
      this.#drawWork(flight);
      this.#followUntilMap();
      await this.#drawResult(flight);
    } catch (error) {
      if (isStale()) return;
      const gone = error instanceof ApiError && (error.status === 404 || error.status === 400);
      put(this.#work, h('div', { class: 'callout callout-error', role: 'alert' }, h('p', {}, gone ? strings.flights.gone : messageOf(error)),
        !gone && button(strings.errors.retry, () => this.refresh(), { picture: 'retry' })));
    }
  }

  /** @param {Flight} flight */
  drawHead(flight) {
    const words = strings.flights;
    const focused = this.#head.contains(document.activeElement) ? document.activeElement?.id : '';
    document.title = `${flight.name} · Skyquilt`;
    byId('panel').setAttribute('aria-label', flight.name);
    if (!this.#name.firstChild) put(this.#name, h('div', { class: 'row between top' }, this.#title, this.#acts), this.#facts);
    this.#title.textContent = flight.name;
    put(this.#facts, stateChip(flight), ' ', flightFacts(flight));
    const acts = JSON.stringify([flight.name, mayChange(flight), Boolean(flight.tilejson)]);
    if (acts !== this.#drawn_acts) {
      this.#drawn_acts = acts;
      put(
        this.#acts,
        ...(mayChange(flight)
          ? [
              !flight.tilejson && iconButton('share', strings.share.action, () => this.actions.share(flight), 'flight-share'),
              iconButton('upload', strings.drop.more, this.actions.add_photos, 'flight-add'),
              iconButton('pencil', words.rename, () => this.actions.rename(flight), 'flight-rename'),
              iconButton('trash', words.remove, onFirstClick(() => this.actions.remove(flight)), 'flight-delete'),
            ]
          : []),
      );
      put(this.#ways, flight.tilejson && flightActions(flight, this.actions.share, () => this.stage.outlines()));
    }
    this.#drawTags(flight);
    if (focused && document.activeElement?.id !== focused) document.getElementById(focused)?.focus();
  }

  // Whatever else of the flight is drawn anew: what is being typed stays, and the focus where it is.
  #drawTags(/** @type {Flight} */ flight) {
    const drawn = JSON.stringify([flight.tags, flight.keep, mayChange(flight)]);
    if (drawn === this.#drawn_tags || this.#tags.querySelector('.tag-form')) return;
    this.#drawn_tags = drawn;
    const current = () => this.flight ?? flight;
    put(this.#tags, tagRow(current, this.actions.tags, (changed) => {
      Object.assign(current(), { tags: changed.tags, keep: changed.keep });
      if (!this.#abort.signal.aborted) this.drawHead(current());
    }));
  }

  /** @param {Flight} flight */
  #drawChip(flight) {
    this.#head.querySelector('.chip')?.replaceWith(stateChip(flight));
  }

  /** @param {Flight} flight */
  #drawWork(flight) {
    this.#endWork();
    const upload = uploadOf(flight.id);
    if (upload) {
      const view = uploadView(upload);
      const done = () => void this.refresh();
      const drawChip = () => this.#drawChip(flight);
      upload.addEventListener('job', done);
      upload.addEventListener('change', drawChip);
      this.#closers.push(view.close, () => {
        upload.removeEventListener('job', done);
        upload.removeEventListener('change', drawChip);
      });
      put(this.#work, view.element);
      return;
    }
    const job = flight.job;
    if (job && !isOver(job)) {
      this.#followJob(flight, job);
      return;
    }
    // An older map stays when a later job fails: the state is 'ready' then, with an error.
    if (flight.state === 'failed' || flight.error) {
      this.#drawFailure(flight);
      return;
    }
    if (flight.state === 'empty' || flight.state === 'uploaded' || stoppedUploadOf(flight.id)) {
      this.#drawWaiting(flight);
      return;
    }
    put(this.#work);
  }

  /** @param {Flight} flight @param {Job} job */
  #followJob(flight, job) {
    const view = jobView(job.id, mayChange(flight), movesMap(job) ? strings.job.placing : undefined);
    const abort = new AbortController();
    this.#closers.push(() => abort.abort());
    view.update(job);
    put(this.#work, view.element);
    const listener = {
      on_job: (/** @type {Job} */ next) => {
        view.update(next);
        if (!isOver(next)) {
          Object.assign(flight, { job: next, state: next.state === 'accepted' ? 'queued' : 'processing' });
          this.#drawChip(flight);
          return;
        }
        announce(next.state === 'successful' ? strings.job.ready(flight.name) : next.state === 'failed' ? failedWords(next) : strings.job.cancelled);
        void this.refresh();
      },
      on_lost: () => view.lost(),
      on_gone: () => void this.refresh(),
    };
    watchJob(job.id, listener, abort.signal).catch(showError);
  }

  /** @param {Flight} flight */
  #drawFailure(flight) {
    const error = flight.error ?? flight.job?.error ?? null;
    const text = () => (typeof error === 'string' ? error : error ? serverWords(error.code, error.message, error.reason) : '');
    put(
      this.#work,
      h(
        'div',
        { class: 'callout callout-error', role: 'alert', id: 'failure' },
        h('p', { class: 'callout-title' }, icon('warning'), failedWords(flight.job)),
        text() && inUnits(() => h('p', {}, text())),
        mayChange(flight) && h('div', { class: 'row' }, ...this.#waysOn(flight)),
      ),
    );
  }

  /** What can be done after a failure. @param {Flight} flight */
  #waysOn(flight) {
    if (isImported(flight) && flight.file_count === 0) return [];
    // A map of others is taken over as it is.
    if (flight.job?.options?.import_file) return [this.#startButton(flight, strings.job.again)];
    if (!movesMap(flight.job)) return [this.#startButton(flight, strings.job.again), optionsButton(flight.id, () => this.stage.outlines()), this.#addButton()];
    const change = button(strings.place.change, () => {
      if (this.#report) this.#place(flight, this.#report, change);
    }, { class: 'button small primary', id: 'place-again' });
    return [change];
  }

  /**
   * Opens the tool that moves the map.
   * @param {Flight} flight
   * @param {Report} report
   * @param {HTMLElement} opener
   */
  #place(flight, report, opener) {
    if (!flight.bounds) return;
    this.actions.show_map();
    void this.stage.placeMap({
      key: `${flight.id} ${flight.revision}`,
      bounds: flight.bounds,
      is_placed: report.is_placed !== false,
      is_guessed: isGuessed(report),
      submit: (pairs) => this.#followMoving(startPlacing(flight.id, pairs)),
      on_leave: () => (opener.isConnected ? opener : document.getElementById('flight-title'))?.focus({ preventScroll: true }),
    });
  }

  /** @param {Promise<Job>} begun moves the map */
  async #followMoving(begun) {
    await begun;
    this.stage.fitNext();
    await this.refresh();
  }

  /** Makes the map anew; the one that is there stays until then. @param {Flight} flight */
  #again(flight) {
    askOptions({
      flight_id: flight.id,
      title: strings.options.again_title,
      hint: strings.options.again_hint,
      submit: strings.upload.start,
      options: lastOptions(flight),
      outlines: this.stage.outlines(),
      on_submit: async (options) => {
        await startJob(flight.id, options);
        forgetChosen(flight.id, options);
        await this.refresh();
      },
    });
  }

  /** @param {Flight} flight @param {Report} report @param {import('../shared/types.js').PhotoCollection} photos */
  #controlOf(flight, report, photos) {
    const may_change = mayChange(flight) && !isImported(flight);
    if (!may_change && !report.alignment?.ground_control?.length) return null;
    const apply = () => this.#followMoving(startControl(flight.id));
    return controlSection({ flight, report, photos, stage: this.stage, may_change, apply }, {
      is_open: this.#is_control_open,
      on_toggle: (is_open) => (this.#is_control_open = is_open),
    });
  }

  /** @param {Flight} flight */
  #drawWaiting(flight) {
    const view = waitingView(flight, {
      start: (label, kind) => this.#startButton(flight, label, kind),
      add: () => this.#addButton(),
      options: () => optionsButton(flight.id, () => this.stage.outlines()),
      on_resume: () => void this.refresh(),
      signal: this.#abort.signal,
    });
    this.#closers.push(view.close);
    put(this.#work, view.element);
  }

  #addButton() {
    return button(strings.drop.more, this.actions.add_photos, { picture: 'folder' });
  }

  /** @param {Flight} flight @param {string} label @param {'primary'|''} [kind] */
  #startButton(flight, label, kind = 'primary') {
    const start = button(label, async () => {
      start.disabled = true;
      try {
        const before = flight.job?.options;
        const meant = before?.import_file ? before : await confirmCoarse(flight.id, chosenOptions(flight.id));
        if (meant) {
          await startJob(flight.id, meant);
          if (!before?.import_file) forgetChosen(flight.id, meant);
          forgetUpload(flight.id);
          held.delete(flight.id);
        }
      } catch (error) {
        showError(error);
      }
      await this.refresh();
    }, { picture: 'play', class: `button small ${kind}`, id: 'start-job' });
    return start;
  }

  /** @param {Flight} flight */
  async #drawResult(flight) {
    const revision = String(flight.revision);
    const is_new = Boolean(flight.tilejson) && revision !== this.#shown_revision;
    // The report does not wait for the map: a slow graphics card must not hide the figures.
    const report = is_new ? getReport(flight.id, this.#abort.signal).catch((error) => error) : null;
    const shown = await this.stage.show(flight);
    if (this.#abort.signal.aborted || flight !== this.flight) return;  // what a later answer drew stays
    if (!flight.tilejson) put(this.#result);
    if (!shown || !report) return;
    this.#shown_revision = revision;
    const found = await report;
    if (this.#abort.signal.aborted || revision !== this.#shown_revision) return;
    if (found instanceof Error) showError(found);
    this.#report = found instanceof Error ? null : found;
    this.#control?.close();
    this.#control = this.#report && shown.photos ? this.#controlOf(flight, this.#report, shown.photos) : null;
    const place = (/** @type {HTMLElement} */ opener) => this.#place(flight, found, opener);
    const again = () => this.#again(flight);
    const may_remake = mayChange(flight) && !isImported(flight);
    const retry = () => {
      this.#shown_revision = '';
      return this.refresh();
    };
    // The place of the notes stays, with the focus of who writes one.
    arrange(this.#result, [
      found instanceof Error ? h('p', { class: 'muted' }, strings.report.missing, ' ', found instanceof ApiError && found.is_passing && button(strings.errors.retry, retry, { class: 'text-button', id: 'report-retry' })) : reportView(flight, found, shown.photos, may_remake ? { place, again } : null),
      ...(this.#control ? [this.#control.element] : []),
      this.#notes_place,
      linksView(flight, shown.tilejson),
    ]);
    await shown.drawn;
    await this.#drawNotes(flight);
  }

  /** Once the map is there: nothing of it waits for them. @param {Flight} flight */
  async #drawNotes(flight) {
    const [{ notesSection }] = await Promise.all([import('../notes/notes_section.js'), (notes_style ??= loadStyle('styles/notes.css'))]);
    if (this.#abort.signal.aborted || this.#notes?.is_writing) return;  // what is being written stays
    this.#notes?.close();
    this.#notes = notesSection(flight, this.stage, mayChange(flight));
    put(this.#notes_place, this.#notes.element);
  }
}

/** @type {Promise<void>|null} */
let notes_style = null;

/** @param {Job|null|undefined} job that has failed */
const failedWords = (job) => (movesMap(job) ? strings.job.placing_failed : strings.job.failed);
