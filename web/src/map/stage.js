// The large part of the window: the map of the open flight with everything that floats over it. The map library is
// loaded when the first map is wanted, so that the first view is light.
/** @import { Bounds, Flight, PhotoCollection, TileJson } from '../shared/types.js' */
/** @import { MapView } from './map_view.js' */
/** @import { PlaceSubject } from './place_tool.js' */
import { showError, showNote } from '../shared/announce.js';
import { ApiError, getPhotos, getSightings, getTileJson, photoPath } from '../shared/api.js';
import { byId, h, loadStyle, put, styleLoaded } from '../shared/dom.js';
import { byClockOf } from '../shared/format.js';
import { parseRoute } from '../shared/router.js';
import { controlMark } from './control_mark.js';
import { wrapLongitude } from './coordinates.js';
import { Comparison } from './compare_view.js';
import { mapTools } from './map_tools.js';
import { measureTool } from './measure_tool.js';
import { noteLabels } from '../notes/note_labels.js';
import { drawnNote } from '../notes/note_shape.js';
import { outlinesOfNotes } from './outlines.js';
import { placeTool } from './place_tool.js';
import { kStagePadding } from '../first_view/poster_place.js';
import { dropPoster, uncoverMap } from '../first_view/poster.js';
import { showDownloads } from '../flight/flight_actions.js';
import { isScaleKnown } from '../flight/flight_words.js';
import { photoCard } from '../flight/photo_card.js';
import { byQuality } from './sighting_order.js';
import { strings } from '../shared/flight_strings.js';
import { hashWithPlace, placeOfHash } from './view_address.js';
import { uploadOf } from '../upload/drop_zone.js';

const kPreview = 'preview';
const kBelowNote_px = 8;  // between the note of a preview and the map

export class Stage {
  /** @type {MapView|null} */
  #view = null;
  /** @type {{id: string, revision: string}|null} */
  #shown = null;
  /** @type {{fit: (animated: boolean) => void, card: ReturnType<typeof photoCard>, measure: ReturnType<typeof measureTool>, place: ReturnType<typeof placeTool>, tools: ReturnType<typeof mapTools>}|null} */
  #parts = null;
  /** @type {Flight|null} */
  #flight = null;
  /** The map that is there next lies elsewhere. */
  #fits_next = false;
  #turn = 0;
  #place_turn = 0;
  /** @type {Comparison} */
  #comparison;
  /** @type {{remove: () => void}[]} */
  #control = [];
  /** @type {import('../notes/note_shape.js').Note[]} */
  #notes = [];
  /** @type {{remove: () => void}|null} */
  #note_labels = null;
  /** @type {((place: [number, number]) => void)|null} */
  #taker = null;

  /** A card over the map wants all of the screen: on a phone the panel lies over the map. */
  makeRoom = () => {};

  constructor() {
    this.area = byId('map-area');
    this.#comparison = new Comparison(this.area);
    this.note = h('div', { class: 'stage-note', hidden: true });
    this.preview_note = h('p', { class: 'preview-note', id: 'preview-note', hidden: true });
    this.area.append(this.note, this.preview_note);
  }

  /** Fetches what draws maps while the server is still being asked for a flight. */
  prepare() {
    loadMapView().catch(() => undefined);  // #map() tells of it
  }

  /** @returns {Promise<MapView|null>} null when this browser cannot draw maps */
  async #map() {
    if (this.#view) return this.#view;
    const container = h('div', { class: 'map', id: 'map' });
    try {
      const { MapView } = await loadMapView();
      if (this.#view) return this.#view;  // two callers waited for the import
      this.area.prepend(container);
      this.#view = new MapView(container);
      this.#view.basemapFailed = () => void showNote(strings.map.basemap_failed, { is_error: true });
    } catch (error) {
      console.error(error);
      container.remove();
      dropPoster();
      this.say(strings.map.failed);
      return null;
    }
    const view = this.#view;
    this.#addParts(view);
    Object.assign(window, { skyquilt: { map: view.map } });
    return view;
  }

  /** @param {MapView} view */
  #addParts(view) {
    const fit = (/** @type {boolean} */ animated) => {
      const below_note_px = this.preview_note.offsetTop + this.preview_note.offsetHeight + kBelowNote_px;
      view.fit({ ...kStagePadding, top: Math.max(kStagePadding.top, below_note_px) }, animated);
    };
    const card = photoCard({
      on_show: (record) => {
        view.select(record?.name ?? '');
        if (record) this.makeRoom();
      },
      hide: (element) => view.hideCard(element),
    });
    const measure = measureTool(view, {
      outlines: () => this.outlines(),
      on_change: (kind) => {
        tools.showMeasuring(kind);
        if (kind) {
          this.makeRoom();
          place.end();
          this.#closeCard();
        }
      },
    });
    const place = placeTool(view, {
      on_change: (is_open) => {
        tools.keepLevel(is_open);
        if (!is_open) return;
        measure.end();
        tools.closeLayers();
        this.#closeCard();
      },
    });
    const tools = mapTools(view, {
      fit: () => fit(true),
      measure: (kind) => {
        tools.closeLayers();
        measure.start(kind);
      },
      compare: () => void this.#chooseCompare().catch(showError),
      layers: () => this.makeRoom(),
      download: (wish) => {
        if (this.#flight) showDownloads(this.#flight, this.outlines(), { wish });
      },
    });
    this.#parts = { fit, card, measure, place, tools };
    this.area.append(measure.cross, place.cross, tools.column, tools.layers, card.element, place.element, tools.coordinates);
    // Beside the map, on a phone below it: a card over it covers what is measured.
    byId('panel-head').after(measure.element);

    /** To the tool that is at work. @param {[number, number]} at @returns {boolean} whether one is */
    const give = (at) => {
      if (measure.kind) measure.add(at);
      else if (place.is_open) place.click(at);
      else return false;
      return true;
    };
    view.map.on('click', (event) => {
      const at = event.lngLat.toArray();
      if (give(at)) return;
      if (this.#taker) this.#taker(at);
      else if (view.mark.isAt(event.point)) fit(true);
      else void this.#showPlace(view, event.lngLat, event.point);
    });
    view.map.on('moveend', () => {
      if (!view.is_moved || !this.#shown || parseRoute(location.hash).view !== 'flight') return;
      const { lng, lat } = view.map.getCenter();
      const shown = { zoom: view.map.getZoom(), lat, lon: wrapLongitude(lng), bearing: view.map.getBearing() };
      history.replaceState(null, '', hashWithPlace(location.hash, shown));
    });
    view.map.getCanvas().addEventListener('keydown', (event) => {
      if (event.key === 'Escape') {
        measure.end();
        this.#closeCard();
      }
      if (event.key !== 'Enter') return;
      const centre = view.map.getCenter();
      if (give(centre.toArray())) return;
      void this.#showPlace(view, centre).then((count) => {
        if (count === 0) showNote(strings.photo.none, { duration_ms: 3000 });
      });
    });
  }

  /**
   * Shows the card of the photos that see a place.
   * @param {MapView} view
   * @param {{lng: number, lat: number}} place
   * @param {import('../../vendor/maplibre-gl.mjs').Point} [point] of the pointer: a camera there comes first
   * @returns {Promise<number|null>} how many photos see it; null where that is wanted no more
   */
  async #showPlace(view, place, point) {
    const flight = this.#flight;
    const turn = (this.#place_turn += 1);
    if (!flight) return null;
    // The server knows lens and ground; without its answer the footprints tell which photos, but not where in them.
    const sightings = await getSightings(flight.id, wrapLongitude(place.lng), place.lat).catch(() => null);
    if (turn !== this.#place_turn || flight.id !== this.#flight?.id || flight.revision !== this.#flight?.revision) return null;
    const seen = new Map((sightings ?? []).sort(byQuality).map((sighting) => [sighting.name, sighting]));
    const records = sightings ? view.recordsOf([...seen.keys()]) : view.photosAt(place);
    const camera = point ? view.cameraAt(point) : null;
    const ordered = camera ? [camera, ...records.filter((record) => record !== camera)] : records;
    const no_scale = isScaleKnown(flight.quality) ? {} : { camera_height_above_ground_m: null };
    this.#parts?.card.show(
      ordered.map((record) => {
        const sighting = seen.get(record.name);
        const captured_at = record.captured_at && byClockOf(record.captured_at, flight.captured?.first);
        return { record: { ...record, ...no_scale, captured_at }, url: photoPath(flight.id, record.name), pixel: sighting ? { x: sighting.x, y: sighting.y } : null, off_vertical_deg: sighting?.off_nadir_deg ?? null };
      }),
    );
    return ordered.length;
  }

  /** Nor does one come that was asked for. */
  #closeCard() {
    this.#place_turn += 1;
    this.#parts?.card.close();
  }

  /** Areas that are drawn on the map, noted or laid over it; the first one is drawn if any is. @returns {import('./outlines.js').Outline[]} */
  outlines() {
    const drawn = this.#parts?.measure.outline ?? null;
    return [...(drawn ? [drawn] : []), ...outlinesOfNotes(this.#notes), ...(this.#view?.own_outlines.values() ?? [])];
  }

  /**
   * @param {string} text shown in place of a map; '' shows the map
   * @param {boolean} [is_coming] a map is on its way
   */
  say(text, is_coming = false) {
    put(this.note, h('div', { class: is_coming ? 'quilt quilt-coming' : 'quilt', 'aria-hidden': 'true' }, ...Array.from({ length: 9 }, () => h('span'))), h('p', {}, text));
    this.note.hidden = text === '';
  }

  /**
   * Shows the map of a flight, when it has one.
   * @param {Flight} flight
   * @returns {Promise<{tilejson: TileJson, photos: PhotoCollection|null, drawn: Promise<void>}|null>} null when
   *   there is no map to show; `drawn` when the map holds it
   */
  async show(flight) {
    const turn = (this.#turn += 1);
    this.#flight = flight;
    this.area.hidden = false;
    dropPoster(flight.tilejson ? flight.id : '');
    this.#notePreview(flight);
    if (!flight.tilejson && flight.preview) {
      this.say('');
      const view = await this.#map();
      // A server that was started anew begins its previews anew: for a moment there is none.
      const tilejson = await getTileJson(flight.preview.tilejson).catch((error) => {
        if (error instanceof ApiError && error.status === 404) return null;
        throw error;
      });
      if (view && tilejson && turn === this.#turn) await this.#draw(view, flight, tilejson, null);
      return null;
    }
    if (!flight.tilejson || !flight.bounds) {
      if (flight.state === 'failed') this.say(strings.stage.failed);
      else this.say(strings.stage.coming, flight.state !== 'empty' || uploadOf(flight.id) !== undefined);
      await this.clear();
      return null;
    }
    this.say('');
    const map = this.#map();
    const photos = getPhotos(flight.id).catch((error) => {
      showNote(error.message, { is_error: true });  // the map is worth showing without its photos
      return null;
    });
    const tilejson = await getTileJson(flight.tilejson);
    if (turn !== this.#turn) return null;
    const drawn = map.then((view) => (view && turn === this.#turn ? this.#draw(view, flight, tilejson, photos) : undefined));
    drawn.catch(() => undefined);  // whoever waits for it tells of it
    const found = await photos;
    return turn === this.#turn ? { tilejson, photos: found, drawn } : null;
  }

  /**
   * The preview of the flight that is shown has changed.
   * @param {Flight} flight
   * @param {Bounds} changed where
   */
  async grow(flight, changed) {
    if (this.#flight?.id !== flight.id || !flight.preview) return;
    if (this.#shown?.id !== flight.id || this.#shown.revision !== kPreview || !this.#view) {
      await this.show(flight);
      return;
    }
    this.#notePreview(flight);
    this.#view.growMosaic(flight.preview.bounds, changed);
    if (!this.#view.is_moved) this.#parts?.fit(true);
  }

  /** @param {Flight} flight */
  #notePreview(flight) {
    const preview = flight.tilejson ? null : flight.preview;
    this.preview_note.hidden = !preview;
    this.preview_note.textContent = preview ? strings.stage.preview(preview.photos) : '';
  }

  /**
   * @param {MapView} view
   * @param {Flight} flight
   * @param {TileJson} tilejson
   * @param {Promise<PhotoCollection|null>|null} photos
   */
  async #draw(view, flight, tilejson, photos) {
    const revision = flight.tilejson ? String(flight.revision ?? '') : kPreview;
    // The preview may have given way to the map since the flight was asked for: then this is the map's document.
    const is_preview = !flight.tilejson && tilejson.version?.startsWith('0.') === true;
    const bounds = is_preview ? flight.preview?.bounds : (flight.bounds ?? tilejson.across_bounds ?? tilejson.bounds);
    const is_new = this.#shown?.id !== flight.id;
    if (!bounds || (!is_new && this.#shown?.revision === revision)) return;
    const was_preview = !is_new && this.#shown?.revision === kPreview;
    this.#shown = { id: flight.id, revision };
    this.endCompare();
    this.#closeCard();
    this.#parts?.place.end();  // its points are on another map
    if (is_new) this.#parts?.measure.end();
    if (is_new) view.is_moved = false;
    this.#parts?.measure.ofFlight(is_preview ? null : flight);
    const fits = this.#fits_next;
    this.#fits_next = false;
    const before = is_new ? null : view.bounds;
    await view.showMosaic(tilejson, bounds, is_preview, flight.id);
    if (this.#shown?.id !== flight.id) return;  // the address names another by now
    view.map.resize();
    const place = is_new && !fits ? placeOfHash(location.hash) : null;
    if (place) {
      view.map.jumpTo({ center: [place.lon, place.lat], zoom: place.zoom, bearing: place.bearing });
      view.is_moved = true;
    } else if (is_new) this.#parts?.fit(false);
    // The last photos may have come to the map without having been in the preview.
    else if ((was_preview || String(before) !== String(bounds)) && !view.is_moved) this.#parts?.fit(true);
    // Whoever had it moved, here, elsewhere or before a reload: nobody looks at where the map no longer is.
    if (fits || !view.sees(bounds)) {
      history.replaceState(null, '', location.hash.split('?')[0]);
      view.is_moved = false;
      this.#parts?.fit(false);
    }
    uncoverMap(view.map, view.first_source);
    const found = await photos;
    if (this.#shown?.id !== flight.id || this.#shown.revision !== revision) return;
    if (found) await view.showPhotos(found);
    this.#parts?.tools.drawLayers(is_new || was_preview);
  }

  async clear() {
    this.endCompare();
    this.#closeCard();
    this.#parts?.measure.end();
    this.#parts?.place.end();
    this.#fits_next = false;
    this.#shown = null;
    dropPoster();
    if (this.#view) await this.#view.clear();
  }

  hide() {
    this.#turn += 1;
    this.#flight = null;
    this.area.hidden = true;
    this.preview_note.hidden = true;
    void this.clear();
  }

  /** The panel or the window changed its size. */
  resize() {
    this.#view?.map.resize();
  }

  /**
   * Opens the tool that places the map.
   * @param {PlaceSubject} subject
   */
  async placeMap(subject) {
    this.endCompare();
    const view = await this.#map();
    if (!view || !this.#parts) return;
    this.#parts.place.start(subject);
    if (view.is_moved) return;
    // Room for the card, which grows with the points.
    const { width, height } = view.container.getBoundingClientRect();
    const card = this.#parts.place.element.getBoundingClientRect();
    const room = card.width > width / 2 ? { top: height * 0.45 } : { left: card.width + 28 };
    view.fit({ ...kStagePadding, ...room }, true);
  }

  /**
   * The control points that are open in the panel, with their names.
   * @param {{name: string, place: [number, number], label: string, is_marked: boolean}[]} points
   * @param {(name: string) => void} on_choose
   */
  showControl(points, on_choose) {
    for (const mark of this.#control) mark.remove();
    const view = this.#view;
    this.#control = view ? points.map((point) => controlMark(view, point, on_choose)) : [];
  }

  /**
   * What is noted on the map.
   * @param {import('../notes/note_shape.js').Note[]} notes
   * @param {(id: string) => void} on_choose
   */
  showNotes(notes, on_choose) {
    this.#note_labels?.remove();
    this.#notes = notes;
    const view = this.#view;
    if (!view) return;
    void view.showNotes({ type: 'FeatureCollection', features: notes.map(drawnNote) });
    this.#note_labels = noteLabels(view, notes, on_choose);
  }

  /** Who gets the clicks on the map; null: it itself. @param {((place: [number, number]) => void)|null} taker */
  takeClicks(taker) {
    if (taker) this.#parts?.measure.end();
    if (taker) this.#parts?.place.end();
    this.#taker = taker;
    if (this.#view) this.#view.map.getCanvas().style.cursor = taker ? 'crosshair' : '';
  }

  /** Who keeps what was measured; null: nobody. @param {import('./measure_tool.js').Keeper|null} keeper */
  keepMeasured(keeper) {
    this.#parts?.measure.keepBy(keeper);
  }

  /** @param {Bounds} bounds */
  showBounds(bounds) {
    this.makeRoom();
    const reduced = matchMedia('(prefers-reduced-motion: reduce)').matches;
    this.#view?.map.fitBounds(bounds, { padding: 90, maxZoom: 21, animate: !reduced, duration: 500 });
  }

  /** Null while no map was shown. */
  get map_view() {
    return this.#view;
  }

  /** The map that comes next lies elsewhere: it is shown whole. */
  fitNext() {
    this.#fits_next = true;
  }

  async #chooseCompare() {
    const flight = this.#flight;
    if (!flight) return;
    this.#parts?.tools.closeLayers();
    this.#parts?.place.end();
    await this.#comparison.choose(flight, () => flight === this.#flight);
  }

  /**
   * @param {Flight} left shown already
   * @param {Flight} right
   */
  async compare(left, right) {
    this.endCompare();
    if (!this.#view) return;
    await this.#comparison.begin(this.#view, left, right, (is_on) => {
      if (is_on) {
        this.#closeCard();
        this.#parts?.place.end();
      }
      this.#parts?.tools.keepLevel(is_on);
    });
  }

  endCompare() {
    this.#comparison.end();
  }
}

const kMapStyle = 'vendor/maplibre-gl.css';
/** @type {Promise<void>|null} */
let map_style = null;

/** The library that draws maps, and its style, which lies below the page's own. */
function loadMapView() {
  map_style ??= styleLoaded(kMapStyle) ?? loadStyle(kMapStyle, document.querySelector('link[rel="stylesheet"]'));
  return Promise.all([import('./map_view.js'), map_style]).then(([module]) => module);
}
