// The verdict before the flight is sent: are there positions, does the flight hold together, what is missing.
// Judged in the browser from each photo's first bytes; a few seconds for a thousand photos.
/** @import { ChosenFile } from './drop_files.js' */
/** @import { PhotoGlance } from './exif_reader.js' */
import { headOf, isArchive, isFilm } from './drop_files.js';
import { glanceAtPhoto, kHeadBytes } from './exif_reader.js';
import { lonBeside } from '../map/coordinates.js';
import { boundsOf, geodesicLength } from '../map/geodesy.js';

/**
 * @typedef {object} Verdict
 * @property {number} photos
 * @property {number} with_position
 * @property {number} logs
 * @property {number} films whose frames become photos
 * @property {number} archives whose content is not known yet
 * @property {number} span_m the diagonal of the camera positions' box
 * @property {number} duration_s from the first to the last photo; 0 when unknown
 * @property {string[]} far names of photos that lie far from all others
 * @property {number} longest_gap_s the longest pause between two photos; 0 when unknown
 * @property {number} usual_gap_s the median pause
 * @property {string} camera
 */

/** @param {ChosenFile[]} files @returns {Promise<Verdict>} */
export async function judge(files) {
  const photos = files.filter(({ name }) => /\.(jpe?g|tiff?|dng|png)$/i.test(name));
  /** @type {{name: string, glance: PhotoGlance}[]} */
  const glances = [];
  for (const { file, name } of photos) glances.push({ name, glance: glanceAtPhoto(await headOf(file, kHeadBytes)) });
  const archives = files.filter(({ name }) => isArchive(name)).length;
  const films = files.filter(({ name }) => isFilm(name)).length;
  return { ...verdictOf(glances), archives, films, logs: files.length - photos.length - archives - films };
}

/** @param {number[]} values @returns {number} */
function median(values) {
  if (values.length === 0) return 0;
  const sorted = [...values].sort((a, b) => a - b);
  return sorted[Math.floor((sorted.length - 1) / 2)];
}

/**
 * @param {{name: string, glance: PhotoGlance}[]} glances
 * @returns {Omit<Verdict, 'logs'|'archives'|'films'>}
 */
export function verdictOf(glances) {
  const placed = glances.flatMap(({ name, glance }) =>
    glance.lon_deg === null || glance.lat_deg === null ? [] : [{ name, lon: glance.lon_deg, lat: glance.lat_deg }],
  );
  const middle = { lon: median(placed.map(({ lon }) => lon)), lat: median(placed.map(({ lat }) => lat)) };
  const away = placed.map(({ name, lon, lat }) => ({ name, lon, lat, m: geodesicLength([middle.lon, middle.lat], [lon, lat]) }));
  // Far is ten times the usual distance and at least two kilometres: another place, not the end of a long field.
  const limit_m = Math.max(2000, 10 * median(away.map(({ m }) => m)));
  const near = away.filter(({ m }) => m <= limit_m);
  const [west, south, east, north] = boundsOf(near.map(({ lon, lat }) => [lonBeside(lon, middle.lon), lat]));
  const times = glances
    .map(({ glance }) => glance.taken_s)
    .filter((t) => t !== null)
    .sort((a, b) => a - b);
  const gaps = times.slice(1).map((t, i) => t - times[i]);
  return {
    photos: glances.length,
    with_position: placed.length,
    span_m: near.length > 1 ? geodesicLength([west, south], [east, north]) : 0,
    duration_s: times.length > 1 ? times[times.length - 1] - times[0] : 0,
    far: away.filter(({ m }) => m > limit_m).map(({ name }) => name),
    longest_gap_s: Math.max(0, ...gaps),
    usual_gap_s: median(gaps),
    camera: glances.find(({ glance }) => glance.camera)?.glance.camera ?? '',
  };
}
