// Placing a map: step by step something that the map shows is clicked, then where it really is is typed, pasted or
// clicked on the basemap. What was entered stays until the map has moved, so that a slip can be mended.
/** @import { Bounds } from '../shared/types.js' */
/** @import { LonLat } from './geodesy.js' */
/** @import { MapView } from './map_view.js' */
/** @import { PlacePair } from './place_pairs.js' */
/** @import { PlacePoint } from './place_point.js' */
import { announce } from '../shared/announce.js';
import { messageOf } from '../shared/api.js';
import { basemapWithPlaces, chosenBasemap } from './basemap.js';
import { wrapLongitude } from './coordinates.js';
import { h, put } from '../shared/dom.js';
import { button, iconButton } from '../shared/icons.js';
import { lieNear, movement } from './place_pairs.js';
import { placePoint } from './place_point.js';
import { number } from '../shared/language.js';
import { strings } from '../shared/flight_strings.js';
import { chosenUnits, lengthIn } from '../shared/units.js';

const kSeeThrough = 0.35;
const kNearZoom = 17;

/**
 * @typedef {object} PlaceSubject the map that is placed
 * @property {string} key of the flight and its revision
 * @property {Bounds} bounds
 * @property {boolean} is_placed it has a place on Earth
 * @property {boolean} is_guessed its size or north is a guess: one point is too few
 * @property {(pairs: PlacePair[]) => Promise<void>} submit begins the job; what it throws is shown
 * @property {() => void} on_leave the keyboard's focus goes where it came from
 */

/**
 * @param {MapView} view
 * @param {{on_change: (is_open: boolean) => void}} listener
 */
export function placeTool(view, listener) {
  const words = strings.place;
  /** @type {PlaceSubject|null} */
  let subject = null;
  let kept_key = '';
  /** @type {PlacePoint[]} */
  let points = [];
  /** To find true places on: the one that is chosen, else the server's. @type {import('./basemap.js').BasemapKind|null} */
  let findable = null;
  /** Set while a true place is clicked on the basemap. @type {(() => void)|null} */
  let endPicking = null;

  const title = h('h2', { class: 'card-title', id: 'place-title' });
  const step = h('p', { class: 'place-step', id: 'place-step' });
  const list = h('ol', { class: 'place-points', 'aria-label': words.points });
  const hint = h('p', { class: 'place-hint amber', hidden: true, id: 'place-hint' });
  const effect = h('p', { class: 'muted', id: 'place-effect' });
  const failure = h('p', { class: 'place-fault', role: 'alert', id: 'place-failure' });
  const centre = button(words.centre, () => click(view.map.getCenter().toArray()), { id: 'place-centre' });
  const basemap = button(words.basemap, () => (endPicking ? endPicking() : pick()), { id: 'place-basemap' });
  const go = button(words.go, () => void submit(), { class: 'button small primary', id: 'place-go' });
  const element = h(
    'section',
    { class: 'place-card floating', id: 'place-card', 'aria-labelledby': 'place-title', hidden: true },
    h(
      'div',
      { class: 'row between card-head' },
      title,
      iconButton('close', words.close, () => leave()),
    ),
    step,
    h('div', { class: 'place-scroll' }, list, hint, effect, failure),
    h('div', { class: 'row' }, centre, basemap, go),
  );
  const cross = h('div', { class: 'centre-cross', 'aria-hidden': 'true', hidden: true });
  const onEscape = (/** @type {KeyboardEvent} */ event) => {
    if (event.key !== 'Escape' || !subject) return;
    if (endPicking) endPicking();
    else leave();
  };
  element.addEventListener('keydown', onEscape);
  view.map.getCanvasContainer().addEventListener('keydown', onEscape);

  /** The point whose true place is not known yet, and its number. */
  const pending = () => {
    const index = points.findIndex(({ is }) => !is);
    return index < 0 ? null : { point: points[index], number: index + 1 };
  };
  const pairs = () => /** @type {PlacePair[]} */ (points.filter(({ is }) => is).map(({ shown, is }) => ({ shown, is })));
  const near = () => pairs()[0]?.is ?? null;

  const stepText = () => {
    const open = pending();
    if (open && endPicking) return words.on_basemap(open.number);
    if (open) return canPick() ? words.is_or_basemap(open.number) : words.is(open.number);
    if (points.length === 0) return words.shown;
    if (points.length > 1) return words.enough;
    return subject?.is_guessed ? words.one_more : words.enough_one;
  };
  const canPick = () => findable !== null && (subject?.is_placed === true || near() !== null);

  const draw = () => {
    if (!subject) return;
    points.forEach((point, i) => point.setNumber(i + 1));
    const text = stepText();
    if (step.textContent !== text) {
      step.textContent = text;
      announce(text);
    }
    const known = pairs();
    const is_near = lieNear(points.map(({ shown }) => shown), subject.bounds);
    if (is_near && hint.hidden) announce(words.near);
    hint.hidden = !is_near;
    hint.textContent = is_near ? words.near : '';
    effect.textContent = known.length > 0 ? effectText(known) : '';
    basemap.hidden = !pending() || !canPick();
    basemap.textContent = endPicking ? words.back : words.basemap;
    go.disabled = Boolean(pending()) || points.length < (subject.is_guessed ? 2 : 1);
    // What comes next is what stands out.
    go.classList.toggle('primary', !go.disabled);
  };

  /** @param {PlacePair[]} known */
  const effectText = (known) => {
    const move = movement(known);
    if (!move) return words.same;
    if (known.length === 1) return words.moves(lengthIn(move.shift_m, chosenUnits()));
    const text = words.turns(lengthIn(move.shift_m, chosenUnits()), move.turn_deg, number(move.scale, { minimumSignificantDigits: move.scale < 1 ? 3 : 4, maximumSignificantDigits: move.scale < 1 ? 3 : 4 }));
    return known.length > 2 ? `${text} ${words.miss(lengthIn(move.miss_m, chosenUnits()))}` : text;
  };

  const changed = () => {
    failure.textContent = '';
    draw();
  };

  /** @param {LonLat} place on the map */
  const click = ([lon, lat]) => {
    /** @type {LonLat} */
    const place = [wrapLongitude(lon), lat];
    const open = pending();
    if (open && endPicking) {
      open.point.setTrue(place);
      endPicking();
      return;
    }
    if (open) open.point.setShown(place);
    else add(place);
    changed();
    pending()?.point.input.focus();
  };

  /** @param {LonLat} place */
  const add = (place) => {
    const point = placePoint(view, place, {
      on_change: changed,
      on_remove: () => {
        endPicking?.();
        point.remove();
        points = points.filter((other) => other !== point);
        changed();
        view.focus();
      },
      on_enter: () => {
        endPicking?.();
        if (points.length > 1 && !go.disabled) go.focus();
        else view.focus();
      },
    });
    points.push(point);
    list.append(point.row);
    point.setNumber(points.length);
  };

  /** The next click is on the basemap, under the map or, for a map that lies nowhere, near the points before. */
  const pick = () => {
    const { opacity } = view;
    const camera = { center: view.map.getCenter(), zoom: view.map.getZoom(), bearing: view.map.getBearing() };
    const there = subject?.is_placed ? null : near();
    endPicking = () => {
      endPicking = null;
      view.setOpacity(opacity);
      if (chosenBasemap() !== findable) void view.setBasemap(chosenBasemap());
      if (there) view.map.jumpTo(camera);
      changed();
    };
    view.setOpacity(kSeeThrough);
    if (findable && chosenBasemap() !== findable) void view.setBasemap(findable);
    if (there) view.map.jumpTo({ center: there, zoom: Math.min(kNearZoom, camera.zoom), bearing: 0 });
    draw();
    view.focus();
  };

  const submit = async () => {
    const own = subject;
    if (!own) return;
    go.disabled = true;
    failure.textContent = '';
    try {
      await own.submit(pairs());
      if (subject === own) leave();
    } catch (error) {
      failure.textContent = messageOf(error);
      draw();
    }
  };

  const end = () => {
    if (!subject) return;
    endPicking?.();
    for (const point of points) point.setVisible(false);
    subject = null;
    element.hidden = true;
    cross.hidden = true;
    view.map.getCanvas().style.removeProperty('cursor');
    view.map.doubleClickZoom.enable();
    listener.on_change(false);
  };
  const leave = () => {
    const left = subject;
    end();
    left?.on_leave();
  };

  return {
    element,
    cross,
    click,
    end,
    get is_open() {
      return subject !== null;
    },
    /** @param {PlaceSubject} next */
    start(next) {
      end();
      if (next.key !== kept_key) {
        for (const point of points) point.remove();
        points = [];
        put(list);
      }
      kept_key = next.key;
      subject = next;
      for (const point of points) point.setVisible(true);
      title.textContent = next.is_placed ? words.move : words.place;
      failure.textContent = '';
      step.textContent = '';
      element.hidden = false;
      cross.hidden = false;
      view.map.getCanvas().style.cursor = 'crosshair';
      view.map.doubleClickZoom.disable();
      listener.on_change(true);
      draw();
      view.focus();
      void basemapWithPlaces().then((kind) => {
        findable = kind;
        draw();
      });
    },
  };
}
