// The panel of a flight's control points: the list with what is marked and how far it is missed, what is lacking, and the
// button that brings the map to the points. The points are on the map as well.
/** @import { ControlSubject } from './control_section.js' */
/** @import { ControlPoint } from './control_lists.js' */
/** @import { PointResidual } from './control_residuals.js' */
import { showError, showNote } from '../shared/announce.js';
import { messageOf } from '../shared/api.js';
import { arrange, h, keptElements, put } from '../shared/dom.js';
import { button, icon, iconButton, onFirstClick } from '../shared/icons.js';
import { fixed, number } from '../shared/language.js';
import { inOneLine } from '../shared/remarks.js';
import { strings } from '../shared/flight_strings.js';
import { chosenUnits, inUnits, lengthIn, units_chosen } from '../shared/units.js';
import { controlOf } from './control_document.js';
import { openImport, openPointForm } from './control_forms.js';
import { isCheckPoint } from './control_lists.js';
import { controlPlaces } from './control_places.js';
import { predictionOf, residualOfMark, residualsOf } from './control_residuals.js';
import { openMarking } from './marking_dialog.js';

const kMinMarks = 2;
const kMinPoints = { placed: 1, nowhere: 3 };

/** @param {number} metres */
const told = (metres) => lengthIn(metres, chosenUnits());

/** @param {number} px */
const pixels = (px) => `${fixed(px, px < 10 ? 1 : 0)}\u00a0px`;

/**
 * @param {ControlSubject} subject
 * @returns {{element: HTMLElement, close: () => void}}
 */
export function controlPanel({ flight, report, photos, stage, may_change, apply }) {
  const words = strings.control;
  const control = controlOf(flight.id);
  const is_placed = report.is_placed !== false;
  const places = controlPlaces(flight, photos, is_placed);
  const residuals = residualsOf(report);
  const names = photos.features.map(({ properties }) => properties.name);

  const body = h('tbody', {});
  const table = h('table', { class: 'control-table', id: 'control-points', hidden: true }, headings([words.point, words.marks, words.residual], may_change && h('td', {})), body);
  const hint = h('p', { class: 'muted', id: 'control-hint' });
  const state = h('p', { class: 'control-state', id: 'control-state', role: 'status' });
  const advice = h('p', { class: 'muted', id: 'control-advice' });
  const go = button(words.apply, () => void start(), { picture: 'move', class: 'button small primary', id: 'control-apply' });
  const tools = h('div', { class: 'row no-print', hidden: true },
    button(words.import, () => openImport(control, names), { picture: 'upload', id: 'control-import-open' }),
    button(words.add, () => openPointForm(control, null), { picture: 'plus', id: 'control-add' }));
  const element = h(
    'div',
    {},
    tools,
    hint,
    h('div', { class: 'control-scroll', role: 'group', 'aria-label': words.heading, tabindex: 0 }, table),
    state,
    may_change && h('div', { class: 'control-apply no-print' }, advice, go),
    residualTable(residuals),
    predictionTable(residuals),
  );
  let is_closed = false;
  let is_starting = false;
  let map_turn = 0;
  let mark_turn = 0;
  let on_map = '';

  const usable = () => control.points.filter(({ marks }) => marks.length >= kMinMarks);

  /** @param {ControlPoint} point */
  const row = (point) => {
    const found = residuals.find(({ name }) => name === point.name);
    return h(
      'tr',
      { 'data-point': point.name, class: found?.is_outlier ? 'outlier' : null },
      h('th', { scope: 'row' }, may_change
        ? button(point.name, () => void mark(point.name), { class: 'text-button', 'aria-label': words.mark_point(point.name) })
        : point.name),
      h('td', { class: point.marks.length >= kMinMarks ? 'control-ready' : null }, point.marks.length >= kMinMarks && icon('check'), number(point.marks.length)),
      h('td', { title: found?.reason ? inOneLine(found.remark && [found.remark], found.reason) : null }, found ? residualText(found) : ''),
      may_change &&
        h('td', { class: 'control-tools' },
          iconButton('pencil', words.change(point.name), () => openPointForm(control, point)),
          iconButton('trash', words.remove(point.name), onFirstClick(() => remove(point.name)))),
    );
  };
  const rowsOf = keptElements((/** @type {ControlPoint} */ point) => point.name, ({ name, x, y, height, marks }) => JSON.stringify([name, x, y, height, marks.length, chosenUnits()]), row);
  const drawRows = () => arrange(body, rowsOf(control.points));
  const draw = () => {
    const focused = body.contains(document.activeElement) ? document.activeElement?.getAttribute('aria-label') : null;
    drawRows();
    if (focused && !body.contains(document.activeElement)) /** @type {HTMLElement|null} */ (body.querySelector(`[aria-label="${CSS.escape(focused)}"]`))?.focus();
    table.hidden = control.points.length === 0;
    const texts = control.points.length > 0 ? (may_change ? words.hint_mark : '') : may_change ? words.hint_empty : words.none;
    hint.textContent = texts;
    hint.hidden = texts === '';
    const marked = usable().length;
    const placing = usable().filter(({ name }) => !isCheckPoint(name)).length;
    const lacking = is_placed ? kMinPoints.placed - marked : kMinPoints.nowhere - placing;
    const ready = placing === 0 ? words.checks_alone : placing < kMinPoints.nowhere ? words.shifts : words.ready(marked);
    advice.textContent = control.points.length === 0 ? '' : lacking > 0 ? words.lacking(lacking) : ready;
    go.hidden = control.points.length === 0;
    go.disabled = lacking > 0 || is_starting;
    void drawMap();
  };
  const drawMap = async () => {
    const turn = (map_turn += 1);
    const shown = await places.onMap(control.points);
    if (turn !== map_turn || is_closed) return;
    const marks = new Map(control.points.map((point) => [point.name, point.marks.length]));
    const points = shown.map(({ name, place }) => ({ name, place, is_marked: (marks.get(name) ?? 0) >= kMinMarks, label: words.on_map(name, marks.get(name) ?? 0) }));
    const content = JSON.stringify(points);
    if (content === on_map) return;  // a mark that is being clicked stays
    on_map = content;
    stage.showControl(points, (name) => {
      if (may_change) void mark(name);
    });
  };
  const drawState = () => {
    const texts = { saved: control.points.length > 0 ? words.saved : '', saving: words.saving, waiting: `${words.waiting} ${control.failure}`, failed: control.failure };
    state.textContent = may_change ? texts[control.state] : '';
    state.classList.toggle('control-fault', control.state === 'failed' || control.state === 'waiting');
  };
  const remove = (/** @type {string} */ name) => {
    const { reference_system, points } = control;
    const at = points.findIndex((point) => point.name === name);
    control.change({ reference_system, points: points.filter((_, i) => i !== at) });
    // What was changed after it stays; a point of that name, or other coordinates, that came meanwhile as well.
    const putBack = () => {
      if (control.point(name) || control.reference_system !== reference_system) return;
      control.change({ reference_system, points: [...control.points.slice(0, at), points[at], ...control.points.slice(at)] });
    };
    showNote(words.removed(name), { action: { label: strings.flights.undo, run: putBack } });
  };
  const mark = async (/** @type {string} */ name) => {
    const point = control.point(name);
    if (!point) return;
    const turn = (mark_turn += 1);
    try {
      const seen = await places.photosOf(point, control.points);
      if (turn !== mark_turn || is_closed) return;
      if (seen.length === 0) {
        showNote(words.unseen(name));
        return;
      }
      openMarking(control, name, seen, {
        residual_of: (photo) => {
          const found = residualOfMark(residuals, name, photo);
          return found ? words.was_missed(pixels(found.px)) : '';
        },
        on_close: () => /** @type {HTMLElement|null} */ (body.querySelector(`[aria-label="${CSS.escape(words.mark_point(name))}"]`))?.focus(),
      });
    } catch (error) {
      if (turn === mark_turn && !is_closed) showError(error);
    }
  };
  const start = async () => {
    is_starting = true;
    draw();
    try {
      await control.flush();
      await apply();
    } catch (error) {
      showError(error);
    }
    is_starting = false;
    if (!is_closed) draw();
  };

  const read = async () => {
    hint.textContent = strings.photo.loading;
    try {
      await control.load();
      tools.hidden = !may_change;
    } catch (error) {
      if (is_closed) return;
      put(hint, messageOf(error), ' ',
        button(strings.errors.retry, () => void read(), { class: 'text-button', id: 'control-retry' }));
    }
  };

  control.addEventListener('change', draw);
  control.addEventListener('saved', drawState);
  units_chosen.addEventListener('change', drawRows);
  go.hidden = true;
  void read();
  return {
    element,
    close() {
      is_closed = true;
      control.removeEventListener('change', draw);
      control.removeEventListener('saved', drawState);
      units_chosen.removeEventListener('change', drawRows);
      control.close();
      stage.showControl([], () => undefined);
    },
  };
}

/** @param {string[]} texts of a table's columns @param {HTMLElement|false} [more] */
const headings = (texts, more = false) => h('thead', {}, h('tr', {}, ...texts.map((text) => h('th', { scope: 'col' }, text)), more));

/** @param {PointResidual} found */
const residualText = (found) => (found.is_used ? `${told(found.horizontal_m)} · ${pixels(found.px)}` : strings.control.not_used);

/** @param {PointResidual[]} residuals @returns {HTMLElement|null} */
function predictionTable(residuals) {
  const words = strings.control;
  const found = predictionOf(residuals);
  if (!found) return null;
  return h(
    'details',
    { class: 'control-residuals', id: 'control-predictions' },
    h('summary', {}, words.predictions, inUnits(() => h('span', { class: 'muted' }, ` ${words.predicted(told(found.median_m), found.worst, told(found.worst_m))}`))),
    inUnits(() => h('table', { class: 'control-table' }, headings([words.point, words.residual]),
      h('tbody', {}, ...residuals.map(({ name, predicted_m }) => predicted_m !== null && h('tr', {}, h('th', { scope: 'row' }, name), h('td', {}, told(predicted_m))))))),
    h('p', { class: 'muted' }, words.predictions_hint),
  );
}

/** @param {PointResidual[]} residuals @returns {HTMLElement|null} */
function residualTable(residuals) {
  const words = strings.control;
  const marks = residuals.flatMap((point) => point.marks.map((mark) => ({ point, mark })));
  if (marks.length === 0) return null;
  const worst = marks.filter(({ mark }) => mark.is_outlier).length;
  return h(
    'details',
    { class: 'control-residuals', id: 'control-residuals' },
    h('summary', {}, words.residuals, worst > 0 && h('span', { class: 'amber' }, ` ${words.outliers(worst)}`)),
    h('div', { class: 'control-scroll', role: 'group', 'aria-label': words.residuals, tabindex: 0 },
      inUnits(() => h('table', { class: 'control-table' }, headings([words.point, words.photo, words.residual]),
        h('tbody', {}, ...marks.map(({ point, mark }) =>
          h('tr', { class: mark.is_outlier ? 'outlier' : null }, h('th', { scope: 'row' }, point.name), h('td', {}, mark.photo), h('td', {}, `${pixels(mark.px)} · ${told(mark.m)}`, mark.is_outlier && h('span', { class: 'control-flag' }, ` ${words.outlier}`)))))))),
    h('p', { class: 'muted' }, words.residuals_hint),
  );
}
