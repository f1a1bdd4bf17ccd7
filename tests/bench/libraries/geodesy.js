// Lengths and areas of the page (web/src/map/geodesy.js) beside GeographicLib's (npm, a development dependency): bytes
// that a browser would load, time a call, and how far ours are off.
//   node tests/bench/libraries/geodesy.js [PAIRS]
// Random numbers are seeded: accuracy is the same in every run, times are medians of seven rounds.
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { fileURLToPath } from 'node:url';
import { gzipSync } from 'node:zlib';
import { geodesicLength, polygonArea } from '../../../web/src/map/geodesy.js';

const web = fileURLToPath(new URL('../../../web/', import.meta.url));
const { Geodesic } = createRequire(`${web}package.json`)('geographiclib-geodesic');
const wgs84 = Geodesic.WGS84;
const pairs = Number(process.argv[2] ?? 20000);

/** Repeatable numbers in 0..1. */
function random(/** @type {number} */ seed) {
  let state = seed >>> 0;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 4294967296;
  };
}

const median = (/** @type {number[]} */ values) => [...values].sort((a, b) => a - b)[Math.floor(values.length / 2)];
const microseconds = (/** @type {() => void} */ run, /** @type {number} */ count) =>
  median(Array.from({ length: 7 }, () => {
    const start = process.hrtime.bigint();
    run();
    return Number(process.hrtime.bigint() - start) / 1000 / count;
  }));

const bytes = (/** @type {string} */ path) => {
  const text = readFileSync(path);
  return `${text.length} bytes, ${gzipSync(text, { level: 9 }).length} as gzip`;
};
console.log(`geodesy.js (with isInside): ${bytes(`${web}src/map/geodesy.js`)}`);
console.log(`GeographicLib, minified: ${bytes(`${web}node_modules/geographiclib-geodesic/geographiclib-geodesic.min.js`)}`);

/** @type {[string, (next: () => number) => number[]][]} lat, lon, lat, lon */
const kinds = [
  ['up to 50 km', (next) => {
    const [lat, lon, span] = [next() * 160 - 80, next() * 360 - 180, 10 ** (next() * 6.5 - 7)];
    return [lat, lon, lat + (next() - 0.5) * span, lon + (next() - 0.5) * span];
  }],
  ['anywhere', (next) => [
    (Math.asin(2 * next() - 1) * 180) / Math.PI, next() * 360 - 180, (Math.asin(2 * next() - 1) * 180) / Math.PI, next() * 360 - 180]],
  ['within a degree of the antipode', (next) => {
    const [lat, lon] = [(Math.asin(2 * next() - 1) * 180) / Math.PI, next() * 360 - 180];
    return [lat, lon, Math.max(-90, Math.min(90, -lat + 2 * next() - 1)), lon + 179 + 2 * next()];
  }],
];
for (const [name, make] of kinds) {
  const next = random(1);
  const made = Array.from({ length: pairs }, () => make(next));
  const truth = made.map((pair) => wgs84.Inverse(pair[0], pair[1], pair[2], pair[3], Geodesic.DISTANCE).s12);
  const errors = made.map(([lat, lon, lat2, lon2], i) => Math.abs(geodesicLength([lon, lat], [lon2, lat2]) - truth[i])).sort((a, b) => a - b);
  const ours_us = microseconds(() => made.forEach(([lat, lon, lat2, lon2]) => geodesicLength([lon, lat], [lon2, lat2])), pairs);
  const theirs_us = microseconds(() => made.forEach((pair) => wgs84.Inverse(pair[0], pair[1], pair[2], pair[3], Geodesic.DISTANCE)), pairs);
  console.log(
    `lengths ${name}: ours ${ours_us.toFixed(2)} us, GeographicLib ${theirs_us.toFixed(2)} us; ours off by ` +
      `${errors[Math.floor(pairs / 2)].toExponential(1)} m in the median, ${errors[pairs - 1].toExponential(1)} m at most, ` +
      `more than 1 mm in ${errors.filter((error) => !(error <= 1e-3)).length} of ${pairs}`,
  );
}

for (const [name, radius] of /** @type {[string, (next: () => number) => number][]} */ ([
  ['up to 50 km', (next) => 10 ** (next() * 3.3 - 4) * 0.2],
  ['50 to 500 km', (next) => 0.3 + 2 * next()],
])) {
  const next = random(2);
  const rings = Array.from({ length: pairs / 10 }, () => {
    const [lat, lon, radius_deg, corners] = [next() * 140 - 70, next() * 360 - 180, radius(next), 3 + Math.floor(next() * 8)];
    return Array.from({ length: corners }, (_, k) => {
      const angle = (2 * Math.PI * (k + next() * 0.7)) / corners;
      return /** @type {[number, number]} */ ([lon + (radius_deg * Math.cos(angle)) / Math.cos((lat * Math.PI) / 180), lat + radius_deg * Math.sin(angle)]);
    });
  });
  const area = (/** @type {number[][]} */ ring) => {
    const polygon = wgs84.Polygon(false);
    for (const [x, y] of ring) polygon.AddPoint(y, x);
    return Math.abs(polygon.Compute(false, true).area);
  };
  const errors = rings.map((ring) => Math.abs(polygonArea(ring) / area(ring) - 1)).sort((a, b) => a - b);
  console.log(
    `areas ${name}: ours ${microseconds(() => rings.forEach(polygonArea), rings.length).toFixed(2)} us, GeographicLib ` +
      `${microseconds(() => rings.forEach(area), rings.length).toFixed(2)} us; ours off by ` +
      `${errors[Math.floor(errors.length / 2)].toExponential(1)} of the area in the median, ${errors[errors.length - 1].toExponential(1)} at most`,
  );
}
