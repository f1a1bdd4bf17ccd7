// What of a profile is drawn: the surface that the photos show and the ground below it, where the map has their heights,
// else the smooth ground. Pure.
/** @import { GroundProfile, ProfileSample } from '../shared/types.js' */
import { knownRuns } from './height_chart.js';

/**
 * @typedef {Omit<GroundProfile, 'ground'|'surfaces'> & {is_level: boolean, is_surface: boolean, below: ProfileSample[]}} DrawnProfile
 *   is_level: of a map made on level ground, and nothing else is known; below: the ground below a surface, where that is known
 */

/**
 * @param {ProfileSample[]} samples
 * @returns {{lowest_m: number|null, highest_m: number|null, climb_m: number, descent_m: number}} the sums of what goes up
 *   and of what goes down between neighbours that both have a height
 */
export function figuresOf(samples) {
  const runs = knownRuns(samples);
  const heights = runs.flat().map(({ height_m }) => height_m);
  const steps = runs.flatMap((run) => run.slice(1).map(({ height_m }, i) => height_m - run[i].height_m));
  const sum = (/** @type {1|-1} */ sign) => steps.reduce((all, step) => all + Math.max(0, sign * step), 0);
  return {
    lowest_m: heights.length > 0 ? Math.min(...heights) : null,
    highest_m: heights.length > 0 ? Math.max(...heights) : null,
    climb_m: sum(1),
    descent_m: sum(-1),
  };
}

/** @param {GroundProfile} profile @returns {DrawnProfile} */
export function drawnProfile({ ground, surfaces = [], ...profile }) {
  if (!surfaces.includes('dsm')) return { ...profile, is_level: ground === 'plane', is_surface: false, below: [] };
  const of = (/** @type {'dsm_m'|'dtm_m'} */ height) => profile.samples.map((sample) => ({ ...sample, height_m: sample[height] ?? null }));
  const samples = of('dsm_m');
  // Beside what a photo shows the smooth ground may go on.
  if (knownRuns(samples).length === 0) return { ...profile, is_level: ground === 'plane', is_surface: false, below: [] };
  return { ...profile, ...figuresOf(samples), samples, is_level: false, is_surface: true, below: surfaces.includes('dtm') ? of('dtm_m') : [] };
}
