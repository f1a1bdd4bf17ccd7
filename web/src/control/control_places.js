// Where the open map shows surveyed points, and which photos see them: asked of the server, which knows cameras and ground.
/** @import { Flight, PhotoCollection, PhotoRecord } from '../shared/types.js' */
/** @import { SeenPhoto } from '../flight/photo_card.js' */
/** @import { LonLat } from '../map/geodesy.js' */
/** @import { ControlPoint } from './control_lists.js' */
import { ApiError, getGround, getSightings, photoPath } from '../shared/api.js';
import { byQuality } from '../map/sighting_order.js';
import { guessedPlace } from './control_guess.js';
import { photoKey } from './control_lists.js';

const kSideBySide = 6;
const kMaxOthers = 40;

/** In degrees of latitude, near enough to put photos in order. @param {PhotoRecord} record @param {LonLat} place */
const awayFrom = ({ camera_lon, camera_lat }, [lon, lat]) => Math.hypot((camera_lon - lon) * Math.cos((lat * Math.PI) / 180), camera_lat - lat);

/**
 * @param {Flight} flight
 * @param {PhotoCollection} photos of its map
 * @param {boolean} is_placed the map has its place on Earth
 */
export function controlPlaces(flight, photos, is_placed) {
  /** @type {Map<string, PhotoRecord>} */
  const records = new Map(photos.features.map(({ properties }) => [photoKey(properties.name), properties]));
  /** @type {Map<string, LonLat|null>} by photo and pixel */
  const asked = new Map();

  /** Of the first mark that is on the ground. @param {ControlPoint} point @returns {Promise<LonLat|null>} */
  const ownPlace = async (point) => {
    for (const { photo, x, y } of point.marks) {
      const record = records.get(photoKey(photo));
      if (!record) continue;
      const key = `${record.name} ${x} ${y}`;
      if (!asked.has(key)) {
        const found = await getGround(flight.id, record.name, x, y).catch((error) => (error instanceof ApiError && error.is_passing ? undefined : null));
        if (found === undefined) continue;  // a server that is away is asked again
        asked.set(key, found);
      }
      const place = asked.get(key);
      if (place) return place;
    }
    return null;
  };

  /** @param {ControlPoint[]} points @returns {Promise<Map<string, LonLat>>} those that are marked, by name */
  const shownPlaces = async (points) => {
    /** @type {Map<string, LonLat>} */
    const shown = new Map();
    const waiting = points.filter(({ marks }) => marks.length > 0);
    const work = async () => {
      for (let point = waiting.shift(); point; point = waiting.shift()) {
        const place = await ownPlace(point);
        if (place) shown.set(point.name, place);
      }
    };
    await Promise.all(Array.from({ length: kSideBySide }, work));
    return shown;
  };

  return {
    /** @param {ControlPoint[]} points @returns {Promise<{name: string, place: LonLat}[]>} where the map shows them, as far as is known */
    async onMap(points) {
      const shown = await shownPlaces(points);
      return points.flatMap((point) => {
        const place = guessedPlace(point, shown, points, is_placed);
        return place ? [{ name: point.name, place }] : [];
      });
    },
    /**
     * The photos to mark a point in: those that should see it, the best first, then others; all where nothing tells.
     * @param {ControlPoint} point
     * @param {ControlPoint[]} points all
     * @returns {Promise<SeenPhoto[]>}
     */
    async photosOf(point, points) {
      const place = guessedPlace(point, await shownPlaces(points), points, is_placed);
      const sightings = place ? (await getSightings(flight.id, ...place).catch(() => [])).sort(byQuality) : [];
      /** @type {Map<string, SeenPhoto>} */
      const seen = new Map();
      const add = (/** @type {PhotoRecord|undefined} */ record, /** @type {{x: number, y: number}|null} */ pixel, /** @type {number|null} */ off_vertical_deg) => {
        if (record && !seen.has(record.name)) seen.set(record.name, { record, url: photoPath(flight.id, record.name), pixel, off_vertical_deg });
      };
      for (const { name, x, y, off_nadir_deg } of sightings) add(records.get(photoKey(name)), { x, y }, off_nadir_deg ?? null);
      for (const { photo } of point.marks) add(records.get(photoKey(photo)), null, null);
      // What is expected may be wrong: others taken near by come after them, or all where nothing is expected.
      const others = [...records.values()].filter(({ name }) => !seen.has(name));
      if (place && sightings.length > 0) others.sort((a, b) => awayFrom(a, place) - awayFrom(b, place)).splice(kMaxOthers);
      for (const record of others) add(record, null, null);
      return [...seen.values()];
    },
  };
}
