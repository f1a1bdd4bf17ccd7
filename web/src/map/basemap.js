// What lies below the maps: nothing, the outlines of the land that came with the page, the basemap that the server's
// operator chose, or, where none was, a public one. The choice stays in this browser; nobody else is asked before it.
/** @import { TileJson } from '../shared/types.js' */
/** @import { LayerSpecification, SourceSpecification } from '@maplibre/maplibre-gl-style-spec' */
import { authorization } from '../shared/token.js';
import { at } from '../shared/router.js';
import { keepChoice, keptChoice } from '../shared/language.js';

/** @typedef {'none'|'land'|'server'|`public:${string}`} BasemapKind */
/** @typedef {{name: string, title: string, tiles: string[], attribution: string, maxzoom: number}} PublicBasemap */
/** @typedef {TileJson & {pmtiles?: string, attribution?: string, maxzoom?: number}} BasemapTiles */

const kKey = 'skyquilt.basemap';
// Close up the coarse outline would be wrong by kilometres.
const kLandUpTo = 10;
// So that the map stands out.
const kMuted = { 'raster-saturation': -0.5, 'raster-contrast': -0.15 };

/** @type {Promise<{server: BasemapTiles|null, public: PublicBasemap[]}>|null} */
let offered = null;

/** What the server's operator chose, null for nothing, and what is left to this browser. Asked until there is an answer. */
export function offeredBasemaps() {
  offered ??= fetch(at('/basemap.json'), { headers: authorization() })
    .then(async (response) => {
      const { public: left = [], ...tilejson } = response.ok ? await response.json() : { tiles: [] };
      return { server: tilejson.pmtiles || tilejson.tiles.length > 0 ? tilejson : null, public: left };
    })
    .catch(() => {
      offered = null;  // without an answer there is none to offer; the next who asks tries again
      return { server: null, public: [] };
    });
  return offered;
}

/** @returns {BasemapKind} */
export function chosenBasemap() {
  const kept = keptChoice(kKey) ?? '';
  return kept === 'none' || kept === 'server' || kept.startsWith('public:') ? /** @type {BasemapKind} */ (kept) : 'land';
}

/**
 * What was chosen as far as it is offered still.
 * @param {BasemapKind} kind
 * @returns {Promise<{kind: BasemapKind, tiles: BasemapTiles|null}>} tiles: null without a basemap of tiles
 */
async function offeredAs(kind) {
  if (kind === 'none' || kind === 'land') return { kind, tiles: null };
  const { server, public: left } = await offeredBasemaps();
  const tiles = kind === 'server' ? server : /** @type {BasemapTiles|undefined} */ (left.find(({ name }) => kind === `public:${name}`));
  return tiles ? { kind, tiles } : { kind: 'land', tiles: null };
}

/** The choice that is kept, or the coastlines where it is offered no more. */
export const shownBasemap = async () => (await offeredAs(chosenBasemap())).kind;

/** On which true places can be found: the one that is shown, else the server's; null: none. @returns {Promise<BasemapKind|null>} */
export async function basemapWithPlaces() {
  const { kind, tiles } = await offeredAs(chosenBasemap());
  if (tiles) return kind;
  return (await offeredBasemaps()).server ? 'server' : null;
}

/**
 * What operators and makers of maps wrote is text; the map's attribution control reads markup.
 * @param {string} text
 */
export function asMarkup(text) {
  const element = document.createElement('span');
  element.textContent = text;
  return element.innerHTML;
}

/** @param {BasemapKind} kind */
export const keepBasemap = (kind) => keepChoice(kKey, kind);

/**
 * @param {BasemapKind} wanted
 * @returns {Promise<{source: SourceSpecification, layers: LayerSpecification[]}|null>}
 */
export async function basemapParts(wanted) {
  const { kind, tiles: tilejson } = await offeredAs(wanted);
  if (kind === 'none') return null;
  if (kind === 'land') {
    const style = getComputedStyle(document.documentElement);
    const colour = (/** @type {string} */ name) => style.getPropertyValue(name).trim();
    const fading = (/** @type {number} */ full) => /** @type {any} */ (['interpolate', ['linear'], ['zoom'], kLandUpTo - 2, full, kLandUpTo, 0]);
    return {
      source: { type: 'geojson', data: new URL('../../vendor/land.geojson', import.meta.url).href, attribution: 'Natural Earth' },
      layers: [
        { id: 'basemap-land', type: 'fill', source: 'basemap', maxzoom: kLandUpTo, paint: { 'fill-color': colour('--land'), 'fill-opacity': fading(1) } },
        { id: 'basemap-coast', type: 'line', source: 'basemap', maxzoom: kLandUpTo, paint: { 'line-color': colour('--line-strong'), 'line-opacity': fading(0.7) } },
      ],
    };
  }
  if (!tilejson) return null;
  /** @type {any} */
  const source = { type: 'raster', tileSize: 256, attribution: asMarkup(tilejson.attribution ?? '') };
  if (tilejson.pmtiles) {
    // Neither library may come with the first view: this module does.
    const [{ PMTiles, Protocol }, { addProtocol }] = await Promise.all([import('../../vendor/pmtiles.mjs'), import('../../vendor/maplibre-gl.mjs')]);
    const protocol = new Protocol();
    const archive = new PMTiles(new URL(at(tilejson.pmtiles), location.href).href);
    protocol.add(archive);
    addProtocol('pmtiles', protocol.tile);
    const { minZoom, maxZoom } = await archive.getHeader();
    Object.assign(source, { url: `pmtiles://${archive.source.getKey()}`, minzoom: minZoom, maxzoom: maxZoom });
  } else {
    source.tiles = tilejson.tiles;
    if (tilejson.maxzoom) source.maxzoom = tilejson.maxzoom;  // closer up its last tiles are enlarged
  }
  return { source, layers: [{ id: 'basemap-tiles', type: 'raster', source: 'basemap', paint: kMuted }] };
}
