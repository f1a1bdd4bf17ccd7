// The poster: one picture of the whole map, laid where the map will lie, until the map itself has its first tiles. It needs
// nothing but itself, so that it is there a second before the library that draws maps. One at a time; who cannot see the
// screen is told nothing, since the map that follows says what it is.
/** @import { Bounds } from '../shared/types.js' */
/** @import { Padding, PosterPlace } from './poster_place.js' */
/** @import { ViewPlace } from '../map/view_address.js' */
import { fittedPlace, viewedPlace } from './poster_place.js';

const kTileFade_ms = 150;  // the library fades its tiles in
const kFade_ms = 250;      // as style.css has it
/** Beyond this, close up, a pixel of the picture is a blot. */
const kMaxEnlarged = 4;

/**
 * @typedef {object} Poster
 * @property {string} flight_id
 * @property {HTMLImageElement|null} picture null while it is on its way
 * @property {(view: ViewPlace|null) => void} lay null: as the whole map is fitted
 * @property {() => void} end
 */

/** @type {Poster|null} */
let poster = null;

/** @param {HTMLImageElement} picture @param {PosterPlace} place @param {{width: number, height: number}} container */
function layAt(picture, place, container) {
  const { style } = picture;
  style.left = `${place.left}px`;
  style.top = `${place.top}px`;
  style.width = `${place.width}px`;
  style.height = `${place.height}px`;
  style.transformOrigin = `${container.width / 2 - place.left}px ${container.height / 2 - place.top}px`;
  style.transform = place.bearing === 0 ? '' : `rotate(${-place.bearing}deg)`;
}

/**
 * @param {HTMLElement} area that the map fills
 * @param {{flight_id: string, address: string, bounds: Bounds, padding: Padding, view: ViewPlace|null}} shown
 * @returns {Promise<void>} when it is there, or is known not to come
 */
export function showPoster(area, { flight_id, address, bounds, padding, view }) {
  dropPoster();
  const picture = new Image();
  picture.alt = '';
  picture.className = 'poster';
  picture.fetchPriority = 'high';
  picture.draggable = false;
  picture.setAttribute('aria-hidden', 'true');
  let at = view;
  const lay = () => {
    const container = { width: area.clientWidth, height: area.clientHeight };
    const place = at ? viewedPlace(bounds, container, at) : fittedPlace(bounds, container, padding);
    picture.hidden = !place || (at !== null && place.width > kMaxEnlarged * picture.naturalWidth);
    if (place && !picture.hidden) layAt(picture, place, container);
  };
  const watch = new ResizeObserver(lay);
  /** @type {Poster} */
  const own = {
    flight_id,
    picture: null,
    lay(next) {
      at = next;
      if (own.picture) lay();
    },
    end() {
      watch.disconnect();
      picture.remove();
      picture.removeAttribute('src');  // one that is still coming is not waited for
    },
  };
  poster = own;
  picture.src = address;
  return picture.decode().then(
    () => {
      if (poster !== own) return;
      own.picture = picture;
      lay();
      const map = area.querySelector(':scope > .map');
      if (map) map.after(picture);
      else area.prepend(picture);
      watch.observe(area);
    },
    () => {
      if (poster === own) dropPoster();
    },
  );
}

/** What draws maps in the background the library asks for last of all: the browser has it then. */
export async function fetchMapWorker() {
  const response = await fetch(new URL('../../vendor/maplibre-gl-worker.mjs', import.meta.url), { priority: 'low' });
  await response.arrayBuffer();
}

/** @param {string} [but_of] the flight whose poster may stay; '' for none */
export function dropPoster(but_of = '') {
  if (!poster || poster.flight_id === but_of) return;
  poster.end();
  poster = null;
}

/**
 * The map is in its place and gets its tiles: the poster follows it until these are drawn, then fades.
 * @param {import('../map/map_view.js').MapView['map']} map
 * @param {string} source of the first tiles
 */
export function uncoverMap(map, source) {
  const own = poster;
  if (!own) return;
  const follow = () => {
    const { lng, lat } = map.getCenter();
    own.lay({ zoom: map.getZoom(), lat, lon: lng, bearing: map.getBearing() });
  };
  const fade = () => {
    map.off('move', follow);
    if (poster !== own) return;
    const is_seen = own.picture !== null && !matchMedia('(prefers-reduced-motion: reduce)').matches;
    own.picture?.classList.add('poster-over');
    setTimeout(() => {
      if (poster === own) dropPoster();
    }, is_seen ? kFade_ms : 0);
  };
  const look = () => {
    if (poster === own && map.getSource(source) && !map.isSourceLoaded(source)) return;
    map.off('render', look);
    map.off('idle', look);
    setTimeout(fade, kTileFade_ms);
  };
  follow();
  map.on('move', follow);
  map.on('render', look);
  map.on('idle', look);
}
