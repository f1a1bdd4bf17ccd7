// The ground of the stand-in server: a hill around the middle of each map, nothing beyond 400 m of it.
import { geodesicLength } from '../../../web/src/map/geodesy.js';

const kKnown_m = 400;
const kSamples = 60;

/**
 * @param {{place: {lon: number, lat: number}, ground?: 'plane'|'grid'|'none'}} flight
 * @param {{coordinates: [number, number][]}} line
 * @returns {object|null} null: this map knows no heights
 */
export function heightsOf({ place, ground = 'grid' }, { coordinates }) {
  if (ground === 'none') return null;
  /** @type {{distance_m: number, lon: number, lat: number, height_m: number|null}[]} */
  const samples = [];
  let length_m = 0;
  for (let i = 1; i < coordinates.length; i += 1) {
    const [from, to] = [coordinates[i - 1], coordinates[i]];
    const part_m = geodesicLength(from, to);
    for (let k = i === 1 ? 0 : 1; k <= kSamples; k += 1) {
      const [lon, lat] = [0, 1].map((axis) => from[axis] + ((to[axis] - from[axis]) * k) / kSamples);
      const off_m = geodesicLength([place.lon, place.lat], [lon, lat]);
      samples.push({ distance_m: length_m + (part_m * k) / kSamples, lon, lat, height_m: off_m > kKnown_m ? null : ground === 'plane' ? 540 : 540 + 25 * Math.exp(-((off_m / 60) ** 2)) });
    }
    length_m += part_m;
  }
  const known = samples.flatMap(({ height_m }) => (height_m === null ? [] : [height_m]));
  const steps = known.slice(1).map((height_m, i) => height_m - known[i]);
  const sum = (/** @type {number[]} */ values) => values.reduce((all, value) => all + Math.abs(value), 0);
  return {
    revision: 1, ground, cell_m: ground === 'plane' ? null : 2, length_m, step_m: length_m / kSamples, lowest_m: known.length ? Math.min(...known) : null, highest_m: known.length ? Math.max(...known) : null,
    climb_m: sum(steps.filter((step) => step > 0)), descent_m: sum(steps.filter((step) => step < 0)), samples,
  };
}
