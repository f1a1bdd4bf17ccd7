// The first script: asks for what an opened flight's map needs, and shows its poster, while everything else is still on
// its way. It may import nothing that is large or waits for words, and on the way home next to nothing.
import { parseRoute } from '../shared/router.js';
import { askEarly, readable, takeSharedToken } from '../shared/token.js';

/** The document's elements are there. @returns {Promise<void>} */
const parsed = () =>
  new Promise((resolve) => {
    if (document.readyState !== 'loading') resolve();
    else document.addEventListener('readystatechange', () => resolve(), { once: true });
  });

/**
 * The page's frame as main.js will have it: nothing moves when that comes.
 * @param {'home'|'flight'} view
 */
async function frame(view) {
  await parsed();
  const area = document.getElementById('map-area');
  const welcome = document.getElementById('welcome');
  document.body.dataset.view ??= view;
  if (welcome) welcome.hidden = view !== 'home';
  if (area) area.hidden = view === 'home';
  return area;
}

/** @param {string} id */
async function openEarly(id) {
  const path = `/api/v1/flights/${encodeURIComponent(id)}`;
  const asked = askEarly(path);
  // Together, so that none waits for another to be read.
  const parts = Promise.all([import('./poster.js'), import('./poster_place.js'), import('../map/view_address.js'), import('../map/tile_addresses.js')]);
  parts.catch(() => undefined);  // then there is no poster
  const area = await frame('flight');
  /** @type {import('../shared/types.js').Flight|null} */
  const flight = await asked;
  if (!area || !flight?.tilejson || !flight.bounds) return;
  const [{ dropPoster, fetchMapWorker, showPoster }, { kStagePadding }, { placeOfHash }] = await parts;
  const isOpen = () => {
    const route = parseRoute(location.hash);
    return route.view === 'flight' && route.id === id;
  };
  if (!isOpen()) return;
  addEventListener('hashchange', () => {
    if (!isOpen()) dropPoster();
  });
  const address = readable(`${path}/thumbnail.webp?size=1024&rev=${flight.revision}`);
  const shown = showPoster(area, { flight_id: id, address, bounds: flight.bounds, padding: kStagePadding, view: placeOfHash(location.hash) });
  void askEarly(flight.tilejson);
  const library = document.getElementById('map-parts');
  // Below the page's own styles, which have the last word.
  if (library instanceof HTMLTemplateElement) document.head.insertBefore(library.content.cloneNode(true), document.querySelector('link[rel="stylesheet"]'));
  await shown;
  await fetchMapWorker();
}

takeSharedToken();
const route = parseRoute(location.hash);
if (route.view === 'flight') openEarly(route.id).catch((error) => console.debug('no poster', error));
else void frame(route.view === 'home' ? 'home' : 'flight');
