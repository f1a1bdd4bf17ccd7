// OpenLayers reads a WMTS: node openlayers_wmts.mjs CAPABILITIES_URL LAYER ENCODING LON LAT ZOOM. Says where OpenLayers would
// fetch the tile of that place, as a JSON object {url, column, row, resolution_m}.
import {JSDOM} from 'jsdom';

globalThis.DOMParser = new JSDOM().window.DOMParser;
globalThis.Node = new JSDOM().window.Node;
const {default: WMTSCapabilities} = await import('ol/format/WMTSCapabilities.js');
const {default: WMTS, optionsFromCapabilities} = await import('ol/source/WMTS.js');
const {fromLonLat, get: getProjection} = await import('ol/proj.js');

const [url, layer, requestEncoding, lon, lat, zoom] = process.argv.slice(2);
const answer = await fetch(url);
if (!answer.ok) throw new Error(`${url}: ${answer.status}`);
const options = optionsFromCapabilities(new WMTSCapabilities().read(await answer.text()), {layer, requestEncoding});
if (options === null) throw new Error('OpenLayers finds no such layer');
const source = new WMTS(options);
const grid = source.getTileGrid();
const level = grid.getMatrixIds().indexOf(zoom);
const tile = grid.getTileCoordForCoordAndZ(fromLonLat([Number(lon), Number(lat)]), level);
const [, column, row] = tile;
console.log(JSON.stringify({
  url: source.getTileUrlFunction()(tile, 1, getProjection('EPSG:3857')),
  column, row, resolution_m: grid.getResolution(level),
}));
