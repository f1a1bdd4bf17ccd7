// Marking a surveyed point in photos, over the whole window: where the map expects it is circled; a click puts the mark,
// which can be dragged. The arrow keys move a cross (Shift: ten pixels, Ctrl: a tenth), which becomes the mark by Enter
// and until then is saved nowhere. A loupe shows what is marked, or below the cross.
// Page Up and Page Down step through the photos, Delete removes the mark, Ctrl+Z undoes, Escape closes.
/** @import { SeenPhoto } from '../flight/photo_card.js' */
/** @import { Spot } from '../flight/photo_plane.js' */
/** @import { ControlDocument } from './control_document.js' */
import { announce } from '../shared/announce.js';
import { ask } from '../shared/dialogs.js';
import { h } from '../shared/dom.js';
import { dotted } from '../shared/format.js';
import { iconButton } from '../shared/icons.js';
import { fixed } from '../shared/language.js';
import { strings } from '../shared/flight_strings.js';
import { kArrows } from '../shared/follow_pointer.js';
import { filmstrip } from '../flight/filmstrip.js';
import { kZoomStep, photoPlane } from '../flight/photo_plane.js';
import { photoKey } from './control_lists.js';
import { loupe } from './loupe.js';

const kExpected_px = 44;
const kMark_px = 32;
const kCross_px = 40;
const kNear = 1;  // pixels of the screen for one of the photo, where it is marked

/**
 * @param {ControlDocument} control
 * @param {string} name of the point
 * @param {SeenPhoto[]} photos that may show it, the best first; pixel: where it is expected
 * @param {{residual_of: (photo: string) => string, on_close: () => void}} listener
 */
export function openMarking(control, name, photos, listener) {
  const words = strings.control;
  const expected = h('div', { class: 'viewer-mark marking-expected', hidden: true, 'aria-hidden': 'true' });
  const mark = h('button', { type: 'button', class: 'marking-mark', id: 'marking-mark', hidden: true, 'aria-label': words.mark_label, tabindex: -1 });
  const cross = h('div', { class: 'marking-cross', id: 'marking-cross', hidden: true, 'aria-hidden': 'true' });
  const view = h('div', { class: 'viewer-view marking-view', tabindex: 0, role: 'application', 'aria-label': words.marking_hint, id: 'marking-view' }, expected, mark, cross);
  const title = h('h2', { class: 'card-title' }, words.marking_title(name));
  const facts = h('p', { class: 'viewer-facts', id: 'marking-facts' });
  const undo = iconButton('undo', strings.flights.undo, () => control.undo(), 'marking-undo');
  const remove = iconButton('trash', words.remove_mark, () => put(null), 'marking-remove');
  const strip = filmstrip(photos, (index) => show(index));
  const tools = h(
    'div',
    { class: 'viewer-tools' },
    iconButton('back', strings.photo.previous, () => show(shown - 1), 'marking-previous'),
    iconButton('next', strings.photo.next, () => show(shown + 1), 'marking-next'),
    undo,
    remove,
    iconButton('plus', strings.page.zoom_in, () => plane.zoom(kZoomStep), 'marking-zoom-in'),
    iconButton('minus', strings.page.zoom_out, () => plane.zoom(1 / kZoomStep), 'marking-zoom-out'),
    iconButton('fit', strings.photo.whole, () => plane.showWhole(), 'marking-whole'),
    iconButton('close', strings.page.close, () => dialog.close(), 'marking-close'),
  );
  const head = h('div', { class: 'viewer-head' }, h('div', { class: 'viewer-title' }, title, facts), tools);
  const dialog = h('dialog', { class: 'dialog viewer', id: 'marking', 'aria-label': words.marking_title(name) }, head, view, strip.element);

  let shown = 0;
  let is_loaded = false;
  /** @type {Spot|null} where the keys have moved to */
  let aim = null;
  /** @type {Spot|null} where the mark is being dragged to: it is put there when it is let go */
  let dragged = null;
  const photo = () => photos[shown].record.name;
  const markIn = (/** @type {string} */ of) => control.point(name)?.marks.find((one) => photoKey(one.photo) === photoKey(of)) ?? null;
  const shownMark = () => dragged ?? markIn(photo());
  const plane = photoPlane(view, {
    on_draw: () => {
      place(expected, photos[shown].pixel, kExpected_px);
      place(mark, shownMark(), kMark_px);
      place(cross, aim, kCross_px);
    },
    on_load: () => {
      is_loaded = true;
      const pixel = markIn(photo()) ?? photos[shown].pixel;
      if (pixel) plane.show(pixel, Math.max(plane.wholeScale(), kNear));
      else plane.showWhole();
      draw();
    },
  });
  const glass = loupe(plane.image);
  view.append(glass.element);
  /** @param {HTMLElement} element @param {Spot|null} pixel @param {number} size_px */
  const place = (element, pixel, size_px) => {
    element.hidden = !pixel || !is_loaded;
    if (!pixel) return;
    const at = plane.onScreen(pixel);
    element.style.transform = `translate(${at.x - size_px / 2}px, ${at.y - size_px / 2}px)`;
  };
  const isWithin = (/** @type {Spot} */ { x, y }) => x >= -0.5 && y >= -0.5 && x < plane.image.naturalWidth - 0.5 && y < plane.image.naturalHeight - 0.5;

  /** @param {Spot|null} pixel */
  const put = (pixel) => {
    if (!is_loaded || (pixel ? !isWithin(pixel) : !markIn(photo()))) return;
    aim = null;
    control.mark(name, markIn(photo())?.photo ?? photo(), pixel);
    announce(pixel ? words.marked(photo()) : words.mark_removed);
  };
  /** The cross goes on from where it is, from the mark, or from where the point is expected. @param {[number, number]} by pixels */
  const move = ([x, y]) => {
    const from = aim ?? markIn(photo()) ?? photos[shown].pixel ?? plane.pixelAt(middleOf(view));
    const next = { x: from.x + x, y: from.y + y };
    if (!is_loaded || !isWithin(next)) return;
    aim = next;
    const at = plane.onScreen(next);
    if (at.x < 0 || at.y < 0 || at.x > view.clientWidth || at.y > view.clientHeight) plane.show(next);
    draw();
  };
  const draw = () => {
    const own = shownMark();
    facts.textContent = dotted(
      photo(),
      strings.photo.of(shown + 1, photos.length),
      photos[shown].off_vertical_deg === null ? '' : strings.photo.off_vertical(Number(photos[shown].off_vertical_deg)),
      aim ? words.aimed(fixed(aim.x, 1), fixed(aim.y, 1)) : '',
      own && !aim ? words.pixel(fixed(own.x, 1), fixed(own.y, 1)) : '',
      own && !aim ? listener.residual_of(photo()) : '',
    );
    undo.disabled = !control.can_undo;
    remove.disabled = !own;
    [...strip.element.children].forEach((frame, i) => {
      const is_marked = markIn(photos[i].record.name) !== null;
      frame.classList.toggle('frame-marked', is_marked);
      frame.setAttribute('aria-description', is_marked ? words.is_marked : '');
    });
    plane.draw();
    glass.show(aim ?? own);
    if (aim) announce(words.aimed(fixed(aim.x, 1), fixed(aim.y, 1)), { is_progress: true });
  };
  const show = (/** @type {number} */ index) => {
    shown = (index + photos.length) % photos.length;
    is_loaded = false;
    aim = null;
    endDrag();
    plane.open(photos[shown].url, photo());
    strip.show(shown);
    draw();
  };
  view.addEventListener('click', (event) => {
    if (!event.defaultPrevented && event.target !== mark) put(plane.pixelAt(event));
  });
  view.addEventListener('pointermove', (event) => {
    if (is_loaded && !is_dragging) glass.show(plane.pixelAt(event));
  });
  view.addEventListener('pointerleave', () => glass.show(aim ?? markIn(photo())));

  let is_dragging = false;
  let grip = { x: 0, y: 0 };
  mark.addEventListener('pointerdown', (event) => {
    const own = markIn(photo());
    if (!own) return;
    const at = plane.pixelAt(event);
    grip = { x: own.x - at.x, y: own.y - at.y };
    is_dragging = true;
    mark.setPointerCapture(event.pointerId);
  });
  mark.addEventListener('pointermove', (event) => {
    if (!is_dragging) return;
    event.stopPropagation();
    const at = plane.pixelAt(event);
    const next = { x: at.x + grip.x, y: at.y + grip.y };
    if (!isWithin(next)) return;
    aim = null;
    dragged = next;
    draw();
  });
  const endDrag = () => {
    is_dragging = false;
    dragged = null;
  };
  mark.addEventListener('pointerup', () => {
    const to = dragged;
    endDrag();
    if (to) put(to);
  });
  mark.addEventListener('pointercancel', () => {
    endDrag();
    draw();
  });

  /** @type {Record<string, () => void>} */
  const keys = {
    ...plane.keys,
    PageDown: () => show(shown + 1),
    PageUp: () => show(shown - 1),
    Delete: () => put(null),
    Backspace: () => put(null),
  };
  /** @param {KeyboardEvent} event @returns {(() => void)|undefined} */
  const actionOf = (event) => {
    if ((event.ctrlKey || event.metaKey) && event.key.toLowerCase() === 'z') return () => control.undo();
    const arrow = kArrows[event.key];
    if (arrow) {
      const step = event.shiftKey ? 10 : event.ctrlKey ? 0.1 : 1;
      return () => move([step * arrow[0], step * arrow[1]]);
    }
    // Enter on a button or a photo of the strip is theirs.
    if (event.key === 'Enter') return aim && (event.target === view || event.target === mark) ? () => put(aim) : undefined;
    return event.ctrlKey || event.metaKey || event.altKey ? undefined : keys[event.key];
  };
  dialog.addEventListener('keydown', (event) => {
    const action = actionOf(event);
    if (!action) return;
    event.preventDefault();
    action();
  });
  control.addEventListener('change', draw);
  void ask(dialog).then(() => {
    control.removeEventListener('change', draw);
    strip.close();
    listener.on_close();
  });
  // The first photo that is not marked yet.
  show(Math.max(0, photos.findIndex(({ record }) => !markIn(record.name))));
  view.focus();
}

/** @param {HTMLElement} element */
function middleOf(element) {
  const box = element.getBoundingClientRect();
  return { clientX: box.left + box.width / 2, clientY: box.top + box.height / 2 };
}
