// How far surveyed points and their marks lie from where the finished map has them, from its report; those that stand out
// are flagged. Pure.
/** @import { ControlFigures, Remark, Report } from '../shared/types.js' */
import { photoKey } from './control_lists.js';

/** @typedef {{photo: string, px: number, m: number, is_outlier: boolean}} MarkResidual */
/** @typedef {{name: string, is_used: boolean, reason: string, remark: Remark|undefined, horizontal_m: number, predicted_m: number|null, px: number, is_outlier: boolean, marks: MarkResidual[]}} PointResidual */

const kOutlying = 3;   // times the median
const kMinPx = 3;      // less is as well as one clicks
const kMinGsds = 3;

/** @param {number[]} values @returns {number} NaN of none */
function median(values) {
  const sorted = [...values].sort((a, b) => a - b);
  const half = sorted.length / 2;
  return sorted.length % 2 ? sorted[Math.floor(half)] : (sorted[half - 1] + sorted[half]) / 2;
}

/** @param {Report|null} report @returns {PointResidual[]} empty where the map was made without points */
export function residualsOf(report) {
  /** @type {ControlFigures[]} */
  const points = report?.alignment?.ground_control ?? [];
  const horizontal = (/** @type {ControlFigures} */ point) => Math.hypot(point.miss_east_m, point.miss_north_m);
  const usual_m = median(points.filter(({ is_used, is_check }) => is_used && !is_check).map(horizontal)) || 0;
  const usual_px = median(points.flatMap(({ marks = [] }) => marks.filter(({ is_used }) => is_used).map(({ residual_px }) => residual_px))) || 0;
  return points.map((point) => ({
    name: point.name,
    is_used: point.is_used,
    reason: point.reason,
    remark: point.remark,
    horizontal_m: horizontal(point),
    predicted_m: point.left_out ? Math.hypot(point.left_out.miss_east_m, point.left_out.miss_north_m) : null,
    px: point.residual_px,
    is_outlier: !point.is_used || horizontal(point) > Math.max(kOutlying * usual_m, kMinGsds * (report?.gsd_m ?? 0)),
    marks: (point.marks ?? []).map(({ photo, residual_px, residual_m, is_used }) => ({
      photo,
      px: residual_px,
      m: residual_m,
      is_outlier: !is_used && point.is_used || residual_px > Math.max(kOutlying * usual_px, kMinPx),
    })),
  }));
}

/**
 * How far points lie from where a map placed by the others alone puts each.
 * @param {PointResidual[]} residuals
 * @returns {{median_m: number, worst_m: number, worst: string}|null} null: too few points for it
 */
export function predictionOf(residuals) {
  const told = residuals.filter(({ predicted_m }) => predicted_m !== null).map(({ name, predicted_m }) => ({ name, miss_m: predicted_m ?? 0 }));
  if (told.length === 0) return null;
  const worst = told.reduce((a, b) => (b.miss_m > a.miss_m ? b : a));
  return { median_m: median(told.map(({ miss_m }) => miss_m)), worst_m: worst.miss_m, worst: worst.name };
}

/** @param {PointResidual[]} residuals @param {string} name @param {string} photo */
export const residualOfMark = (residuals, name, photo) => residuals.find((one) => one.name === name)?.marks.find((mark) => photoKey(mark.photo) === photoKey(photo)) ?? null;
