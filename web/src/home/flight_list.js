// The list of flights in the panel: open, rename, delete, search and tags; states that change are redrawn in place. A flight's picture is
// fetched when its row comes into sight.
/** @import { Flight } from '../shared/types.js' */
import { arrange, h, put, whenSeen } from '../shared/dom.js';
import { formatCaptureDay } from '../shared/format.js';
import { mayChange, shortFacts, stateChip } from '../flight/flight_words.js';
import { thumbnailPath } from '../shared/api.js';
import { icon, iconButton, onFirstClick } from '../shared/icons.js';
import { routeHash } from '../shared/router.js';
import { keepChoice, keptChoice, nameOrder, number } from '../shared/language.js';
import { strings } from '../shared/strings.js';

// Letters that are no letter with a mark to Unicode, as one types them without.
/** @type {Record<string, string>} */
const kPlain = { ß: 'ss', æ: 'ae', œ: 'oe', ø: 'o', ł: 'l', đ: 'd', ð: 'd', þ: 'th', ı: 'i' };

/**
 * @param {string} text
 * @returns {string} without accents and capitals
 */
export const plain = (text) => text.normalize('NFKD').replace(/\p{M}/gu, '').toLowerCase().replace(/[ßæœøłđðþı]/g, (letter) => kPlain[letter]);

/**
 * @param {Flight} flight
 * @param {string} query words that must all be in its name, its tags or its date
 */
export function matches(flight, query) {
  const text = plain(`${[flight.name, ...(flight.tags ?? [])].join(' ')} ${flight.captured ? `${formatCaptureDay(flight.captured)} ${flight.captured.first.slice(0, 10)}` : ''}`);
  return plain(query).split(/\s+/).every((word) => text.includes(word));
}

/** Its time among others: of the photos, else of the upload. @param {Flight} flight */
const timeOf = (flight) => Date.parse(flight.captured?.first ?? '') || Date.parse(flight.created_at) || 0;

/** Of the box around it: the list knows no better. @param {Flight} flight */
function areaOf({ bounds }) {
  if (!bounds) return 0;
  const [west, south, east, north] = bounds;
  return (east - west) * (north - south) * Math.cos((((south + north) / 2) * Math.PI) / 180);
}

/** @type {Record<'taken'|'newest'|'name'|'area', (a: Flight, b: Flight) => number>} */
export const orders = {
  taken: (a, b) => timeOf(b) - timeOf(a),
  newest: (a, b) => (a.created_at < b.created_at ? 1 : a.created_at > b.created_at ? -1 : 0),
  name: (a, b) => nameOrder().compare(a.name, b.name),
  area: (a, b) => areaOf(b) - areaOf(a),
};

const kOrder = 'skyquilt.order';
const kFilteredFrom = 6;

/**
 * @param {{rename: (flight: Flight) => void, remove: (flight: Flight) => void, on_shown: (flights: Flight[]) => void,
 *          on_point: (flight: Flight|null) => void, on_tags: (tags: string[]) => void}} actions on_shown: those that the
 *   search leaves; on_point: the pointer or the focus is on one; on_tags: these tags are chosen now
 * @returns {{element: HTMLElement, update: (flights: Flight[]|null, error?: string) => void, point: (id: string) => void,
 *            tags: () => string[], known_tags: () => string[], choose: (tags: string[]) => void}}
 */
export function flightList(actions) {
  // The link of a row stays, and its buttons: a click that begins before a change and ends after it counts.
  /** @type {Map<string, {row: HTMLLIElement, link: HTMLAnchorElement, acts: HTMLElement, acts_on: string, shown: string, picture: HTMLElement, drawn: string}>} */
  const rows = new Map();
  const list = h('ul', { class: 'flights', id: 'flights' });
  const message = h('p', { class: 'muted', id: 'flights-message' });
  const search = h('input', { type: 'search', class: 'field', id: 'flight-search', placeholder: strings.flights.search, 'aria-label': strings.flights.search, on: { input: () => redraw() } });
  const order = h(
    'select',
    {
      class: 'field', id: 'flight-order', 'aria-label': strings.flights.order,
      on: {
        change: () => {
          keepChoice(kOrder, order.value);
          redraw();
        },
      },
    },
    ...Object.entries(strings.flights.orders).map(([value, label]) => h('option', { value }, label)),
  );
  const kept = keptChoice(kOrder) ?? '';
  if (kept in orders) order.value = kept;
  const filters = h('div', { class: 'filters' }, search, order);
  const tag_filter = tagFilter((tags) => {
    choose(tags);
    actions.on_tags(tags);
  });
  const in_sight = whenSeen(showPicture);
  const element = h(
    'section',
    { class: 'flight-list', 'aria-labelledby': 'flights-heading' },
    h('h1', { class: 'list-heading', id: 'flights-heading', tabindex: -1 }, strings.flights.heading),
    filters,
    tag_filter.element,
    list,
    message,
  );
  /** @type {Flight[]|null} */
  let flights = null;
  let failure = '';

  const choose = (/** @type {string[]} */ tags) => {
    tag_filter.choose(tags);
    redraw();
  };

  const redraw = () => {
    const chosen = tag_filter.chosen();
    tag_filter.update(flights ?? []);
    const shown = (flights ?? []).filter((flight) => hasTags(flight, chosen) && matches(flight, search.value.trim())).sort(orders[/** @type {keyof typeof orders} */ (order.value)]);
    const kept_ids = new Set(shown.map(({ id }) => id));
    filters.hidden = (flights?.length ?? 0) < kFilteredFrom;
    actions.on_shown(shown);
    for (const id of rows.keys()) if (!kept_ids.has(id)) rows.delete(id);
    arrange(list, shown.map(rowOf));
    message.textContent =
      failure || (flights === null ? '' : flights.length === 0 ? strings.flights.none : shown.length ? '' : strings.flights.no_match);
    message.hidden = message.textContent === '';
  };

  /** @param {Flight} flight @returns {HTMLLIElement} */
  const rowOf = (flight) => {
    const chip = stateChip(flight);
    const picture = JSON.stringify([flight.name, flight.tags, mayChange(flight), shortFacts(flight), chip.className, chip.textContent]);
    let entry = rows.get(flight.id);
    if (!entry) {
      const [point, leave] = [() => actions.on_point(flight), () => actions.on_point(null)];
      const row = h('li', { on: { pointerenter: point, focusin: point, pointerleave: leave, focusout: leave } });
      const link = h('a', { class: 'flight-link', href: routeHash({ view: 'flight', id: flight.id }) });
      entry = { row, link, acts: h('span'), acts_on: '', shown: '', picture: h('span', { class: 'thumb', 'aria-hidden': 'true' }, icon('photo')), drawn: '' };
      rows.set(flight.id, entry);
    }
    if (entry.shown !== picture) {
      entry.shown = picture;
      const had_focus = entry.row.contains(document.activeElement);
      put(entry.link, entry.picture,
        h('span', { class: 'flight-text' }, h('span', { class: 'flight-name' }, flight.name),
          ...shortFacts(flight).map((line) => h('span', { class: 'flight-facts' }, line)), chip, rowTags(flight)));
      const acts_on = JSON.stringify([flight.name, mayChange(flight)]);
      if (entry.acts_on !== acts_on) {
        entry.acts_on = acts_on;
        entry.acts = h(
          'span',
          { class: 'row-actions' },
          mayChange(flight) && iconButton('pencil', `${strings.flights.rename}: ${flight.name}`, () => actions.rename(flight)),
          mayChange(flight) && iconButton('trash', `${strings.flights.remove}: ${flight.name}`, onFirstClick(() => actions.remove(flight))),
        );
      }
      arrange(entry.row, [entry.link, entry.acts]);
      if (had_focus && !entry.row.contains(document.activeElement)) entry.link.focus();
    }
    const address = flight.tilejson ? thumbnailPath(flight) : '';
    if (entry.drawn !== address) {
      entry.drawn = address;
      entry.picture.dataset.address = address;
      if (address) in_sight.observe(entry.picture);
      else put(entry.picture, icon('photo'));
    }
    return entry.row;
  };

  return {
    element,
    update(next, error = '') {
      flights = next ?? flights;
      failure = error;
      redraw();
    },
    tags: tag_filter.chosen,
    known_tags: () => tagCounts(flights ?? [], []).map(([tag]) => tag),
    choose,
    point(id) {
      for (const [own, { row }] of rows) row.classList.toggle('pointed', own === id);
    },
  };
}

/** @param {HTMLElement} place with the address of its picture */
function showPicture(place) {
  const image = h('img', { class: 'thumb-image', alt: '', decoding: 'async', fetchpriority: 'low', draggable: 'false', src: place.dataset.address });
  // A missing picture is no loss the user must hear of.
  image.addEventListener('error', () => put(place, icon('photo')));
  put(place, image);
}

const kRowTags = 4;  // of a flight's tags in its row

/** @param {Flight} flight @param {string[]} chosen @returns {boolean} whether it has all of them */
export const hasTags = (flight, chosen) => chosen.every((tag) => flight.tags?.includes(tag));

/**
 * @param {Flight[]} flights
 * @param {string[]} chosen counted as well where no flight has them: they can be taken back
 * @returns {[string, number][]} each tag with how many flights have it, the most used first
 */
export function tagCounts(flights, chosen) {
  /** @type {Map<string, number>} */
  const counts = new Map(chosen.map((tag) => [tag, 0]));
  for (const tag of flights.flatMap(({ tags }) => tags ?? [])) counts.set(tag, (counts.get(tag) ?? 0) + 1);
  return [...counts].sort(([a, count_a], [b, count_b]) => count_b - count_a || nameOrder().compare(a, b));
}

/** The tags of one flight in its row. @param {Flight} flight @returns {HTMLElement|null} */
function rowTags({ tags = [] }) {
  if (tags.length === 0) return null;
  const rest = tags.length - kRowTags;
  return h('span', { class: 'tags' }, ...tags.slice(0, kRowTags).map((tag) => h('span', { class: 'tag' }, tag)), rest > 0 && h('span', { class: 'tag tag-more' }, `+${number(rest)}`));
}

/**
 * @param {(chosen: string[]) => void} on_change
 * @returns {{element: HTMLElement, chosen: () => string[], choose: (tags: string[]) => void, update: (flights: Flight[]) => void}}
 */
function tagFilter(on_change) {
  const element = h('div', { class: 'tag-filter', id: 'tag-filter', role: 'group', 'aria-label': strings.flights.tags_filter, hidden: true });
  /** @type {string[]} */
  let chosen = [];
  let drawn = '';
  return {
    element,
    chosen: () => chosen,
    choose(tags) {
      chosen = tags;
    },
    update(flights) {
      const counts = tagCounts(flights, chosen);
      const picture = JSON.stringify([counts, chosen]);
      if (picture === drawn) return;
      drawn = picture;
      const focused = element.contains(document.activeElement) ? document.activeElement?.getAttribute('data-tag') : null;
      element.hidden = counts.length === 0;
      put(
        element,
        ...counts.map(([tag, count]) => {
          const is_chosen = chosen.includes(tag);
          const toggle = () => on_change(is_chosen ? chosen.filter((other) => other !== tag) : [...chosen, tag]);
          return h(
            'button',
            { type: 'button', class: 'tag tag-button', 'data-tag': tag, 'aria-pressed': String(is_chosen), on: { click: toggle } },
            h('span', { class: 'tag-word' }, tag), ' ', h('span', { class: 'tag-count' }, number(count)),
          );
        }),
      );
      if (focused !== null) /** @type {HTMLElement|undefined} */ ([...element.children].find((button) => button.getAttribute('data-tag') === focused))?.focus();
    },
  };
}
