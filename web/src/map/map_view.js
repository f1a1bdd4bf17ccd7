// MapView: one MapLibre map with a flight's mosaic and photos on a plain ground. Knows nothing of panels.
// The container's data-map-state says 'empty', 'loading' or 'idle' (everything drawn).
/** @import { Bounds, LayerLegends, MapIndex, MapLayer, PhotoCollection, PhotoRecord, Surface, TileJson } from '../shared/types.js' */
/** @import { LayerSpecification } from '@maplibre/maplibre-gl-style-spec' */
/** @import { LayerKind } from './map_layers.js' */
/** @import { ColourBy } from './map_style.js' */
import * as maplibre from '../../vendor/maplibre-gl.mjs';
import { authorization } from '../shared/token.js';
import { asMarkup, basemapParts, chosenBasemap } from './basemap.js';
import { lonBeside, wrapLongitude } from './coordinates.js';
import { isInside } from './geodesy.js';
import { kOverlay, overlayOpacity, overlayParts } from './map_layers.js';
import { cameraPoints, emptyStyle, errorsOf, flightPath, groundColour, height_layers, lineOpacity, ownDataLayers, path_layers, photo_layers, photoColour, photoLayers } from './map_style.js';
import { outlineOf } from './outlines.js';
import { placeMark } from './place_mark.js';
import { kMaxZoom } from '../first_view/poster_place.js';
import { strings } from '../shared/flight_strings.js';
import { isAcross, ownHost, sourceBounds, tilesIn, zoomOfFew } from './tile_addresses.js';
import { chosenUnits } from '../shared/units.js';

maplibre.setWorkerUrl(new URL('../../vendor/maplibre-gl-worker.mjs', import.meta.url).href);

const kIndex = 'index';
const kNotes = 'notes';
const kNoteColour = '#ffd11a';

export class MapView {
  /** @type {PhotoCollection|null} */
  photos = null;
  /** @type {Bounds|null} */
  bounds = null;
  /** @type {MapLayer[]} that the map has beside it */
  layers = [];
  /** @type {LayerKind|''} which of them is shown */
  overlay = '';
  /** @type {string[]} that expressions can name */
  bands = [];
  has_bands = false;  // of a camera with several: beside the map's colours
  /** @type {MapIndex[]} that can be made of the map */
  indices = [];
  /** @type {Surface[]} whose heights the map has */
  heights = [];
  /** Address of their tiles' TileJSON. */
  terrain = '';
  tile_template = '';
  flight_id = '';
  /** Emits 'change' when another map, or none, is shown: what was laid over the one before goes. */
  shown = new EventTarget();
  /** @type {ColourBy} */
  colour_by = 'placement';
  /** @type {Map<string, import('./outlines.js').Outline>} of the user's own data that lies over the map */
  own_outlines = new Map();
  opacity = 1;
  shows_footprints = false;  // the map first
  shows_path = false;
  #selected = '';
  #mosaic = '';
  #mosaics = 0;
  #basemap_turn = 0;
  /** @type {[number, number]} of the mosaic */
  #zooms = [0, 0];
  /** @type {Bounds|null} where indices have tiles */
  #index_bounds = null;
  #drawn_from_zoom = 0;
  #tile_size = 256;
  is_moved = false;  // by the user, since the flight was opened
  /** The archive of the one that was to be shown cannot be read; coastlines are shown. */
  basemapFailed = () => {};
  /** @type {maplibre.ScaleControl} */
  #scale;

  /**
   * @param {HTMLElement} container
   * @param {string} [label] what screen readers call the map
   */
  constructor(container, label = strings.map.label) {
    this.container = container;
    this.map = new maplibre.Map({
      container,
      style: emptyStyle(),
      attributionControl: false,
      // Makers of public tiles ask to be told which site shows them; nothing else is told to anybody.
      transformRequest: (url) => (new URL(url, location.href).origin === location.origin ? { url, headers: authorization() } : { url, referrerPolicy: 'origin' }),
      maxZoom: kMaxZoom,
      maxPitch: 0,  // until heights stand up (heights/relief.js)
      renderWorldCopies: false,
      fadeDuration: 120,
      locale: { ...strings.map.library, 'Map.Title': label },
    });
    this.#scale = new maplibre.ScaleControl({ maxWidth: container.clientWidth < 500 ? 80 : 130, unit: chosenUnits() });
    this.map.addControl(this.#scale, 'bottom-left');
    // Shows whom the sources in sight name: the makers of the basemap.
    this.map.addControl(new maplibre.AttributionControl({ compact: false, customAttribution: [] }), 'bottom-left');
    container.dataset.mapState = 'empty';
    this.map.on('movestart', (event) => {
      if (event.originalEvent) this.is_moved = true;
    });
    this.map.on('dataloading', () => this.#setState('loading'));
    this.map.on('movestart', () => this.#setState('loading'));
    this.map.on('idle', () => this.#setState('idle'));
    // A missing tile is a hole, not a fault; anything else should be seen by whoever looks for it.
    this.map.on('error', (event) => console.debug('map:', event.error?.message));
    const dark = matchMedia('(prefers-color-scheme: dark)');
    const repaint = () => {
      this.map.setPaintProperty('ground', 'background-color', groundColour());
      void this.setBasemap(chosenBasemap());
    };
    dark.addEventListener('change', repaint);
    this.map.once('remove', () => dark.removeEventListener('change', repaint));
    this.mark = placeMark(this.map);
    this.ready = new Promise((resolve) => this.map.once('load', () => resolve(undefined)));
    void this.ready.then(() => this.setBasemap(chosenBasemap()));
  }

  /** @param {'loading'|'idle'} state */
  #setState(state) {
    const shown = this.bounds ? state : 'empty';
    if (this.container.dataset.mapState !== shown) this.container.dataset.mapState = shown;
  }

  /**
   * Shows a mosaic, replacing the one before.
   * @param {TileJson} tilejson
   * @param {Bounds} bounds
   * @param {boolean} [grows] it will reach further than it does now
   * @param {string} [flight_id] whose map it is
   */
  async showMosaic(tilejson, bounds, grows = false, flight_id = '') {
    this.bounds = bounds;  // before the wait: a preview may grow meanwhile
    await this.ready;
    // The new map is drawn over the old one, which goes when the new one is complete: no flicker.
    const old = this.#mosaic;
    this.#mosaic = `mosaic-${(this.#mosaics += 1)}`;
    this.#index_bounds = tilejson.bands_bounds ?? bounds;
    this.flight_id = flight_id;
    this.#offer(grows ? { layers: tilejson.layers, indices: tilejson.indices } : tilejson);
    this.tile_template = ownHost(tilejson.tiles[0]);
    this.#tile_size = tilejson.tileSize ?? 256;
    /** @type {any} */
    const source = {
      type: 'raster',
      tiles: tilejson.tiles.map(ownHost),
      // Half the size on fine screens: one tile pixel then fills one screen pixel there as well.
      tileSize: (tilejson.tileSize ?? 256) / (devicePixelRatio > 1.5 ? 2 : 1),
      minzoom: tilejson.minzoom ?? 0,
      maxzoom: tilejson.maxzoom ?? 22,
      attribution: asMarkup(tilejson.attribution ?? ''),
      ...(grows ? {} : sourceBounds(bounds)),
    };
    this.goOnBeyond(isAcross(bounds));
    this.#drawn_from_zoom = (tilejson.minzoom ?? 0) - Math.log2(512 / (tilejson.tileSize ?? 256));
    this.#zooms = [tilejson.minzoom ?? 0, tilejson.maxzoom ?? 22];
    const above = this.map.getStyle().layers.find(({ id }) => id !== 'ground' && id !== old && !id.startsWith('basemap-'))?.id;
    const add = (/** @type {string} */ id, /** @type {any} */ parts) => {
      this.map.addSource(id, parts);
      this.map.addLayer({ id, type: 'raster', source: id, paint: { 'raster-opacity': this.opacity, 'raster-fade-duration': 120 } }, above);
    };
    if (!old && !grows) {
      // The whole map in at most four small tiles comes first; over a slow line the others take their time.
      const coarse = `${this.#mosaic}-coarse`;
      add(coarse, { ...source, maxzoom: Math.max(source.minzoom, Math.min(source.maxzoom, zoomOfFew(bounds))) });
      this.map.once('idle', () => this.remove(coarse, [coarse]));
    }
    add(this.#mosaic, source);
    this.mark.show(this.bounds, this.#drawn_from_zoom);
    this.#setState('loading');
    if (old) this.map.once('idle', () => this.remove(old, [old]));
  }

  /**
   * The mosaic shown has grown: what changed is loaded again, behind what is seen until it is there.
   * @param {Bounds} bounds
   * @param {Bounds} changed
   */
  growMosaic(bounds, changed) {
    this.bounds = bounds;
    this.goOnBeyond(isAcross(bounds));
    if (this.#mosaic) this.mark.show(bounds, this.#drawn_from_zoom);
    if (this.#mosaic) this.map.refreshTiles(this.#mosaic, tilesIn(changed, ...this.#zooms));
  }

  /** Whether the world goes on beyond the antimeridian, as a map across that needs it. @param {boolean} goes_on */
  goOnBeyond(goes_on) {
    if (this.map.getRenderWorldCopies() !== goes_on) this.map.setRenderWorldCopies(goes_on);
  }

  /**
   * Lays one of the map's layers over it.
   * @param {LayerKind} kind
   * @param {TileJson} tilejson
   * @param {LayerLegends} legends
   */
  showOverlay(kind, tilejson, legends) {
    this.hideOverlay();
    this.overlay = kind;
    const { source, layer } = overlayParts(kind, tilejson, legends, this.opacity);
    this.map.addSource(kOverlay, source);
    this.addBelowPhotos(layer, height_layers);
  }

  /** What can be laid over the map that is shown from now on; what lay over the one before goes. @param {Partial<TileJson>} map */
  #offer({ layers = [], bands = [], bands_bounds, indices = [], heights = [], terrain = '' }) {
    this.hideOverlay();
    this.hideIndex();
    Object.assign(this, { layers, bands, has_bands: bands_bounds !== undefined, indices, heights, terrain });
    this.shown.dispatchEvent(new Event('change'));
  }

  /**
   * Adds a layer over the map, below its photos and what is drawn by hand.
   * @param {LayerSpecification} layer
   * @param {string[]} [others] layers that it lies below as well
   */
  addBelowPhotos(layer, others = []) {
    const over = [...others, ...photo_layers, ...path_layers, `${kNotes}-fill`, 'measure-fill'];
    this.map.addLayer(layer, this.map.getStyle().layers.find(({ id }) => over.includes(id))?.id);
  }

  /**
   * Lays an index of the map over it, or changes the colours of the one that is there.
   * @param {string} template addresses of its tiles
   */
  showIndex(template) {
    const source = /** @type {maplibre.RasterTileSource|undefined} */ (this.map.getSource(kIndex));
    if (source) {
      source.setTiles([template]);
      return;
    }
    if (!this.#index_bounds) return;
    this.map.addSource(kIndex, { type: 'raster', tiles: [template], tileSize: this.#tile_size, minzoom: this.#zooms[0], maxzoom: this.#zooms[1], ...sourceBounds(this.#index_bounds) });
    this.addBelowPhotos({ id: kIndex, type: 'raster', source: kIndex, paint: { 'raster-opacity': this.opacity, 'raster-resampling': 'nearest', 'raster-fade-duration': 0 } }, [kOverlay, ...height_layers]);
  }

  hideIndex() {
    this.remove(kIndex, [kIndex]);
  }

  /** The source whose few tiles show all of the map before the others. */
  get first_source() {
    return `${this.#mosaic}-coarse`;
  }

  get has_index() {
    return this.map.getLayer(kIndex) !== undefined;
  }

  hideOverlay() {
    this.remove(kOverlay, [kOverlay]);
    this.overlay = '';
  }

  /** @param {import('./basemap.js').BasemapKind} kind what lies below everything else */
  async setBasemap(kind) {
    const turn = (this.#basemap_turn += 1);
    const parts = await basemapParts(kind).catch((error) => {
      console.debug('basemap:', error);
      if (turn === this.#basemap_turn) this.basemapFailed();
      return basemapParts('land');
    });
    await this.ready;
    if (turn !== this.#basemap_turn) return;
    this.remove('basemap', this.map.getStyle().layers.filter(({ id }) => id.startsWith('basemap-')).map(({ id }) => id));
    if (!parts) return;
    this.map.addSource('basemap', parts.source);
    const above = this.map.getStyle().layers.find(({ id }) => id !== 'ground')?.id;
    for (const layer of parts.layers) this.map.addLayer(layer, above);
  }

  /** @param {PhotoCollection} photos */
  async showPhotos(photos) {
    await this.ready;
    this.#removePhotos();
    this.photos = photos;
    this.map.addSource('photos', { type: 'geojson', data: /** @type {any} */ (photos), promoteId: 'name' });
    this.map.addSource('cameras', { type: 'geojson', data: cameraPoints(photos), promoteId: 'name' });
    this.map.addSource('flight-path', { type: 'geojson', data: flightPath(photos) });
    for (const layer of photoLayers(photoColour(this.colour_by, this.errors.worst_m))) this.map.addLayer(layer);
    this.setFootprints(this.shows_footprints);
    this.setPath(this.shows_path);
  }

  /** @param {GeoJSON.FeatureCollection} notes points, lines and areas that somebody wrote on the map */
  async showNotes(notes) {
    await this.ready;
    const source = /** @type {maplibre.GeoJSONSource|undefined} */ (this.map.getSource(kNotes));
    if (source) {
      source.setData(notes);
      return;
    }
    if (notes.features.length === 0) return;
    this.map.addSource(kNotes, { type: 'geojson', data: notes });
    this.#addBelowMeasured(ownDataLayers(kNotes, kNoteColour));
  }

  /** Removes everything of the flight. */
  async clear() {
    this.bounds = null;  // before the wait: the next map may be asked for meanwhile
    await this.ready;
    this.remove(this.#mosaic, [this.#mosaic]);
    this.remove(`${this.#mosaic}-coarse`, [`${this.#mosaic}-coarse`]);
    this.mark.hide();
    this.#mosaic = '';
    this.#offer({});
    this.#removePhotos();
    this.remove(kNotes, ownDataLayers(kNotes, '').map((layer) => layer.id));
    this.photos = null;
    this.is_moved = false;
    this.container.dataset.mapState = 'empty';
  }

  #removePhotos() {
    this.remove('photos', ['photos-fill', 'photos-line']);
    this.remove('cameras', ['cameras']);
    this.remove('flight-path', path_layers);
    this.#selected = '';
  }

  /** Takes away what of a source and its layers is there. @param {string} source @param {string[]} layers */
  remove(source, layers) {
    for (const layer of layers) if (this.map.getLayer(layer)) this.map.removeLayer(layer);
    if (this.map.getSource(source)) this.map.removeSource(source);
  }

  focus() {
    this.map.getCanvas().focus({ preventScroll: true });
  }

  /** Hides what stands over or beside it; the keyboard's focus that was in there comes to the map. @param {HTMLElement} card */
  hideCard(card) {
    const had_focus = card.contains(document.activeElement);
    card.hidden = true;
    if (had_focus) this.focus();
  }

  /** How far off its photos may lie. */
  get errors() {
    return errorsOf(this.photos);
  }

  /**
   * Moves so that the whole mosaic is seen.
   * @param {{top: number, right: number, bottom: number, left: number}} padding px covered by other things
   * @param {boolean} animated
   */
  fit(padding, animated) {
    if (!this.bounds) return;
    const reduced = matchMedia('(prefers-reduced-motion: reduce)').matches;
    this.map.fitBounds(this.bounds, { padding, animate: animated && !reduced, duration: 500, bearing: 0, maxZoom: kMaxZoom });
  }

  /** @param {Bounds} bounds @returns {boolean} whether any of it may be seen */
  sees([west, south, east, north]) {
    const seen = this.map.getBounds();
    const turn_deg = lonBeside((west + east) / 2, seen.getCenter().lng) - (west + east) / 2;
    return west + turn_deg < seen.getEast() && east + turn_deg > seen.getWest() && south < seen.getNorth() && north > seen.getSouth();
  }

  /** @param {number} opacity 0..1 */
  setOpacity(opacity) {
    this.opacity = opacity;
    if (this.#mosaic) this.map.setPaintProperty(this.#mosaic, 'raster-opacity', opacity);
    if (this.has_index) this.map.setPaintProperty(kIndex, 'raster-opacity', opacity);
    if (this.overlay) this.map.setPaintProperty(kOverlay, overlayOpacity(this.overlay), opacity);
  }

  /** @param {boolean} visible */
  setFootprints(visible) {
    this.shows_footprints = visible;
    // The one that is chosen is outlined all the same.
    if (this.map.getLayer('photos-line')) this.map.setPaintProperty('photos-line', 'line-opacity', lineOpacity(visible));
    this.#setVisible(['cameras'], visible);
  }

  /** @param {boolean} visible */
  setPath(visible) {
    this.shows_path = visible;
    this.#setVisible(path_layers, visible);
  }

  /** @param {string[]} layers @param {boolean} visible */
  #setVisible(layers, visible) {
    for (const layer of layers) {
      if (this.map.getLayer(layer)) this.map.setLayoutProperty(layer, 'visibility', visible ? 'visible' : 'none');
    }
  }

  /** @param {ColourBy} by */
  setColourBy(by) {
    this.colour_by = by;
    if (!this.map.getLayer('cameras')) return;
    const colour = photoColour(by, this.errors.worst_m);
    this.map.setPaintProperty('photos-fill', 'fill-color', colour);
    this.map.setPaintProperty('photos-line', 'line-color', colour);
    this.map.setPaintProperty('cameras', 'circle-color', colour);
  }

  /**
   * A mark, which can be dragged where that is listened to. A click on one that is a button is none on the map.
   * @param {HTMLElement} element
   * @param {[number, number]} place
   * @param {number} above_px that the element stands above it; negative: hangs below it; 0: lies on it
   * @param {((place: [number, number]) => void)|null} on_drag null: it stays
   */
  addMark(element, place, above_px, on_drag) {
    const anchor = above_px === 0 ? 'center' : above_px < 0 ? 'top' : 'bottom';
    const mark = new maplibre.Marker({ element, draggable: on_drag !== null, anchor, offset: [0, -above_px] }).setLngLat(place).addTo(this.map);
    mark.on('drag', () => on_drag?.(mark.getLngLat().toArray()));
    if (element instanceof HTMLButtonElement) element.addEventListener('click', (event) => event.stopPropagation());
    return mark;
  }

  /**
   * Lays a user's own data over the map and its photos.
   * @param {string} id
   * @param {string} name of its file
   * @param {GeoJSON.FeatureCollection} data
   * @param {string} colour
   */
  addOwnData(id, name, data, colour) {
    const outline = outlineOf(name, data);
    if (outline) this.own_outlines.set(id, outline);
    this.map.addSource(id, { type: 'geojson', data });
    this.#addBelowMeasured(ownDataLayers(id, colour));
  }

  /** @param {LayerSpecification[]} layers */
  #addBelowMeasured(layers) {
    for (const layer of layers) this.map.addLayer(layer, this.map.getLayer('measure-fill') ? 'measure-fill' : undefined);
  }

  /** @param {string} id */
  removeOwnData(id) {
    this.own_outlines.delete(id);
    this.remove(id, ownDataLayers(id, '').map((layer) => layer.id));
  }

  /** @param {import('../shared/units.js').Units} units of the scale bar */
  setUnits(units) {
    this.#scale.setUnit(units);
  }

  /** @param {string} name of a photo; '' for none */
  select(name) {
    if (!this.map.getSource('photos')) return;
    for (const source of ['photos', 'cameras']) {
      if (this.#selected) this.map.setFeatureState({ source, id: this.#selected }, { selected: false });
      if (name) this.map.setFeatureState({ source, id: name }, { selected: true });
    }
    this.#selected = name;
  }

  /**
   * The photos whose footprint holds a place, the nearest to being straight above first.
   * @param {{lng: number, lat: number}} place
   * @returns {PhotoRecord[]}
   */
  photosAt(place) {
    const squeeze = Math.cos((place.lat * Math.PI) / 180);
    const distance = (/** @type {PhotoRecord} */ r) => Math.hypot(wrapLongitude(r.camera_lon - place.lng) * squeeze, r.camera_lat - place.lat);
    return (this.photos?.features ?? [])
      .filter(({ geometry }) => geometry && isInside([lonBeside(place.lng, geometry.coordinates[0][0][0]), place.lat], geometry.coordinates[0]))
      .map(({ properties }) => properties)
      .sort((a, b) => distance(a) - distance(b));
  }

  /** @param {string[]} names @returns {PhotoRecord[]} in the order of the names */
  recordsOf(names) {
    const by_name = new Map((this.photos?.features ?? []).map(({ properties }) => [properties.name, properties]));
    return names.flatMap((name) => by_name.get(name) ?? []);
  }

  /** @param {maplibre.Point} point of the pointer @returns {PhotoRecord|null} the camera drawn there */
  cameraAt(point) {
    if (!this.map.getLayer('cameras') || !this.shows_footprints) return null;
    const box = /** @type {[[number, number], [number, number]]} */ ([
      [point.x - 6, point.y - 6],
      [point.x + 6, point.y + 6],
    ]);
    const hit = this.map.queryRenderedFeatures(box, { layers: ['cameras'] })[0]?.properties.name;
    return this.recordsOf(hit ? [hit] : [])[0] ?? null;
  }
}
