// Pages of elsewhere: each of window.clients draws the map with one library, as its documentation has it, into a square of
// 256 pixels that shows one tile of 256 pixels, or uploads. What they get: server (no slash at its end), flight, token (or
// ''), lon, lat and zoom (the tile's middle), bounds and zooms of the map, in tiles of 256 pixels. Each resolves when its
// library says that all is drawn; what is drawn is for the test to see.
import * as leaflet from 'leaflet';
import {addProtocol, Map as MapLibre} from 'maplibre-gl';
import OlMap from 'ol/Map.js';
import View from 'ol/View.js';
import WMTSCapabilities from 'ol/format/WMTSCapabilities.js';
import Tile from 'ol/layer/Tile.js';
import WebGLTile from 'ol/layer/WebGLTile.js';
import {fromLonLat} from 'ol/proj.js';
import GeoTIFF from 'ol/source/GeoTIFF.js';
import TileJSON from 'ol/source/TileJSON.js';
import WMTS, {optionsFromCapabilities} from 'ol/source/WMTS.js';
import XYZ from 'ol/source/XYZ.js';
import {Protocol} from 'pmtiles';
import {fromUrl} from 'geotiff';
import Uppy from '@uppy/core';
import Tus from '@uppy/tus';

const side_px = 256;
const tile_m = (zoom) => 40075016.685578488 / 2 ** zoom;
const square = () => document.getElementById('map');
const withToken = ({server, token}, path) => `${server}${path}${token === '' ? '' : `?token=${token}`}`;
const tiles = (map) => withToken(map, `/tiles/${map.flight}/${map.below}{z}/{x}/{y}`);

// A map is complete as soon as nothing is left to load, also while its source does not know its tiles yet.
async function isReady(source) {
  while (source.getState() === 'loading') await new Promise((resolve) => source.once('change', resolve));
  if (source.getState() !== 'ready') throw new Error(`OpenLayers' source is ${source.getState()}`);
}

async function drawnByOpenLayers(layer, {lon, lat, zoom}) {
  await isReady(layer.getSource());
  const map = new OlMap({
    target: square(), controls: [], layers: [layer], pixelRatio: 1,
    view: new View({center: fromLonLat([lon, lat]), resolution: tile_m(zoom) / side_px, constrainResolution: false}),
  });
  await new Promise((resolve, reject) => {
    layer.getSource().on('tileloaderror', () => reject(new Error('OpenLayers could not load a tile')));
    map.once('rendercomplete', resolve);
  });
}

async function drawnByMapLibre(source, {lon, lat, zoom}) {
  const map = new MapLibre({
    container: square(), center: [lon, lat], zoom: zoom - 1, maxZoom: 24, attributionControl: false, fadeDuration: 0,
    style: {version: 8, sources: {map: source}, layers: [{id: 'map', type: 'raster', source: 'map', paint: {'raster-fade-duration': 0}}]},
  });
  await new Promise((resolve, reject) => {
    map.on('error', (event) => reject(event.error));
    map.once('idle', resolve);
  });
}

window.clients = {
  async leaflet(map) {
    const view = leaflet.map(square(), {zoomControl: false, attributionControl: false, fadeAnimation: false, zoomAnimation: false, maxZoom: 24});
    view.setView([map.lat, map.lon], map.zoom);
    const layer = leaflet.tileLayer(tiles(map), {crossOrigin: 'anonymous', minZoom: map.min_zoom, maxZoom: map.zoom});
    await new Promise((resolve, reject) => {
      layer.on('tileerror', () => reject(new Error('Leaflet could not load a tile')));
      layer.once('load', resolve);
      layer.addTo(view);
    });
  },
  openlayers_xyz: (map) => drawnByOpenLayers(new Tile({source: new XYZ({
    url: tiles(map), crossOrigin: 'anonymous', minZoom: map.min_zoom, maxZoom: map.zoom, transition: 0})}), map),
  openlayers_tilejson: (map) => drawnByOpenLayers(new Tile({source: new TileJSON({
    url: withToken(map, `/tiles/${map.flight}${map.below === '' ? '' : '/256'}.json`), crossOrigin: 'anonymous', transition: 0})}), map),
  async openlayers_wmts(map) {
    const answer = await fetch(withToken(map, `/wmts/${map.flight}`));
    const options = optionsFromCapabilities(new WMTSCapabilities().read(await answer.text()), {layer: 'map'});
    await drawnByOpenLayers(new Tile({source: new WMTS({...options, crossOrigin: 'anonymous', transition: 0})}), map);
  },
  async openlayers_geotiff(map) {
    const url = withToken(map, `/api/v1/flights/${map.flight}/download.tif`);
    const source = new GeoTIFF({sources: [{url}], convertToRGB: 'auto', transition: 0});
    await source.getView();  // which is there once the file's head has been read
    await drawnByOpenLayers(new WebGLTile({source}), map);
  },
  maplibre_tilejson: (map) => drawnByMapLibre({
    type: 'raster', tileSize: 256, url: withToken(map, `/tiles/${map.flight}${map.below === '' ? '' : '/256'}.json`)}, map),
  maplibre_pmtiles(map) {
    addProtocol('pmtiles', new Protocol({metadata: true}).tile);
    const url = `pmtiles://${withToken(map, `/api/v1/flights/${map.flight}/download.pmtiles`)}`;
    return drawnByMapLibre({type: 'raster', tileSize: 256, url}, map);
  },
  async geotiff(map) {
    const tiff = await fromUrl(withToken(map, `/api/v1/flights/${map.flight}/download.tif`));
    const image = await tiff.getImage();
    const [left_m, top_m] = image.getOrigin();
    const [x_m, y_m] = fromLonLat([map.lon, map.lat]);
    const pixel_m = image.getResolution()[0];
    const left = Math.round((x_m - left_m) / pixel_m - side_px / 2);
    const top = Math.round((top_m - y_m) / pixel_m - side_px / 2);
    const rgb = await image.readRGB({window: [left, top, left + side_px, top + side_px], interleave: true});
    const canvas = Object.assign(document.createElement('canvas'), {width: side_px, height: side_px});
    const picture = new ImageData(side_px, side_px);
    const bands = rgb.length / side_px ** 2;
    for (let i = 0; i < side_px ** 2; ++i) {
      for (let band = 0; band < 3; ++band) picture.data[4 * i + band] = rgb[bands * i + band];
      picture.data[4 * i + 3] = 255;
    }
    canvas.getContext('2d').putImageData(picture, 0, 0);
    square().append(canvas);
  },
  async uppy({server, flight, token, file}) {
    const content = await (await fetch(`/file`)).blob();
    const uppy = new Uppy({autoProceed: false}).use(Tus, {
      endpoint: `${server}/api/v1/uploads`, chunkSize: 64 * 1024, retryDelays: null,
      allowedMetaFields: ['flight', 'filename'], headers: token === '' ? {} : {Authorization: `Bearer ${token}`},
    });
    uppy.addFile({name: file, type: 'image/jpeg', data: content, meta: {flight, filename: file}});
    const {successful, failed} = await uppy.upload();
    if (failed.length > 0) throw new Error(failed[0].error);
    return {sent: successful.map((one) => one.name), bytes: content.size};
  },
};
