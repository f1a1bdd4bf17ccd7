// The bare map for frames of other pages (embed_address.js). It changes nothing, keeps nothing in the browser and asks
// nobody for a token; first_embed.js has taken its own.
/** @import { TileJson } from '../shared/types.js' */
import { ApiError, getTileJson, messageOf } from '../shared/api.js';
import { byId, h, put } from '../shared/dom.js';
import { toolButton } from '../shared/icons.js';
import { embedded } from './embed_address.js';
import { MapView } from '../map/map_view.js';
import { dropPoster, uncoverMap } from '../first_view/poster.js';
import { kEmbedPadding } from '../first_view/poster_place.js';
import { placeOfHash } from '../map/view_address.js';
import { loadFlightStrings, strings } from '../shared/flight_strings.js';

const { id, token, wishes } = embedded();

/** @param {unknown} error */
function say(error) {
  const words = strings.embed;
  if (!(error instanceof ApiError)) console.error(error);
  const status = error instanceof ApiError ? error.status : -1;
  const text = status < 0 ? strings.map.failed : status === 401 ? words.no_access : status === 404 || status === 400 ? words.none : messageOf(error);
  dropPoster();
  tell(text);
}

/** @param {string} text */
function tell(text) {
  put(byId('note'), h('p', {}, text));
  byId('note').hidden = false;
}

/** @param {TileJson} tilejson */
function caption(tilejson) {
  const name = tilejson.name ?? '';
  const page = `../#/flights/${encodeURIComponent(id)}${token ? `?token=${encodeURIComponent(token)}` : ''}`;
  document.title = name;
  return h('a', { class: 'embed-caption', href: page, target: '_blank', rel: 'noopener', title: strings.embed.open }, h('span', { class: 'embed-name' }, name), h('span', { class: 'muted fine' }, 'Skyquilt'));
}

async function show() {
  const tilejson = await getTileJson(`/tiles/${encodeURIComponent(id)}.json`);
  const bounds = tilejson.across_bounds ?? tilejson.bounds;
  if (!bounds) throw new ApiError(404, strings.embed.none);
  const view = new MapView(byId('map'), tilejson.name);
  // Who scrolls the page around the frame does not mean the map.
  if (window.parent !== window) view.map.cooperativeGestures.enable();
  const fit = (/** @type {boolean} */ animated) => view.fit(kEmbedPadding, animated);
  byId('stage').append(
    caption(tilejson),
    h('div', { class: 'tools' }, h('div', { class: 'tool-group' }, toolButton('plus', strings.page.zoom_in, () => view.map.zoomIn()), toolButton('minus', strings.page.zoom_out, () => view.map.zoomOut()), toolButton('fit', strings.map.fit, () => fit(true)))),
  );
  Object.assign(window, { skyquilt: { map: view.map } });
  await view.showMosaic(tilejson, bounds);
  const place = placeOfHash(`#?${wishes}`);
  if (place) view.map.jumpTo({ center: [place.lon, place.lat], zoom: place.zoom, bearing: place.bearing });
  else fit(false);
  uncoverMap(view.map, view.first_source);
}

loadFlightStrings().then(
  () => show().catch(say),
  () => tell(strings.errors.unreachable),
);
