// The page's address: what is after '#' says what is open, so that a reload or a sent link shows the same; its path, where
// on its host this server lies: at the root, or below a path that a proxy gives it ("/skyquilt").

/**
 * @typedef {{view: 'home', tags?: string[]}
 *   | {view: 'flight', id: string}
 *   | {view: 'compare', id: string, other: string}} Route
 */

/**
 * @param {string} hash
 * @returns {Route}
 */
export function parseRoute(hash) {
  const parts = hash.split('?')[0].replace(/^#\/?/, '').split('/').map(decode);
  if (parts[0] === 'flights' && parts[1]) {
    if (parts[2] === 'compare' && parts[3]) return { view: 'compare', id: parts[1], other: parts[3] };
    return { view: 'flight', id: parts[1] };
  }
  return { view: 'home', tags: new URLSearchParams(hash.split('?')[1] ?? '').getAll('tag') };
}

/** @param {string} part @returns {string} */
function decode(part) {
  try {
    return decodeURIComponent(part);
  } catch {
    return '';  // a broken escape names no flight
  }
}

/**
 * @param {Route} route
 * @returns {string}
 */
export function routeHash(route) {
  if (route.view === 'home') return route.tags?.length ? `#/?${new URLSearchParams(route.tags.map((tag) => ['tag', tag]))}` : '#/';
  const flight = `#/flights/${encodeURIComponent(route.id)}`;
  return route.view === 'compare' ? `${flight}/compare/${encodeURIComponent(route.other)}` : flight;
}

/** @param {Route} route */
export function go(route) {
  location.hash = routeHash(route);
}

/** @param {(route: Route) => void} show called now and at each change */
export function watchRoute(show) {
  addEventListener('hashchange', () => show(parseRoute(location.hash)));
  show(parseRoute(location.hash));
}

/**
 * @param {string} pathname of the page: "/skyquilt/" or, of the bare map, "/skyquilt/embed/FLIGHT"
 * @returns {string} "/skyquilt", or '' at the root
 */
export const baseOf = (pathname) => pathname.replace(/\/(embed\/)?[^/]*$/, '');

const kBase = baseOf(globalThis.location?.pathname ?? '/');

/**
 * @param {string} path from the server's root; what is below the base already, or no path at all, stays as it is
 * @param {string} [base]
 * @returns {string} from the host's root
 */
export const at = (path, base = kBase) => (path.startsWith('/') && !path.startsWith(`${base}/`) ? base + path : path);

/** The server's address, without a slash at its end. */
export const serverAddress = () => location.origin + kBase;
