// The address after '#' says what is open, so that a reload or a sent link shows the same.

/**
 * @typedef {{view: 'home'}
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
  return { view: 'home' };
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
  if (route.view === 'home') return '#/';
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
