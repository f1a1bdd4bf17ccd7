// The server's HTTP API, one function a request. Every failure is an ApiError whose message can be shown.
/** @import { Access, ChangeTileJson, ContourCollection, Flight, GroundProfile, Job, MapExport, PhotoCollection, Remark, Report, ServerVerdict, Share, Sighting, StoredFile, SurfaceHeights, TileJson, Trash, VolumeFigures } from './types.js' */
import { kFallback, language } from './language.js';
import { at } from './router.js';
import { strings } from './strings.js';
import { authorization, isFromLink, readable, takeEarly } from './token.js';

/** What went wrong, in the server's words where it gave some (RFC 9457). */
export class ApiError extends Error {
  /**
   * @param {number} status HTTP status, 0 when the server could not be reached
   * @param {string} title
   * @param {string} [detail]
   */
  constructor(status, title, detail = '') {
    super(detail || title);
    this.status = status;
    this.title = title;
  }

  /** Worth trying again without a change by the user? */
  get is_passing() {
    return this.is_away || this.status >= 500;
  }

  /** Could the server not be reached, or is it (or a proxy before it) not ready? That passes, however long it takes. */
  get is_away() {
    return [0, 408, 429, 502, 503, 504].includes(this.status);
  }
}

/** What can be shown of it. @param {unknown} error */
export const messageOf = (error) => (error instanceof Error ? error.message : String(error));

/** Of what the server remarks, once the words of flights are there (flight_strings.js). @returns {Record<string, (values: any) => string>} */
const remarkSentences = () => /** @type {any} */ (strings).remarks ?? {};

/**
 * @param {Remark|null|undefined} remark
 * @returns {string|null} null where the page has no words for it
 */
export function remarkWords(remark) {
  const sentences = remarkSentences();
  if (!remark || !Object.hasOwn(sentences, remark.code)) return null;
  /** @type {Record<string, string|number>} */
  const values = {};
  for (const [name, value] of Object.entries(remark.values)) {
    if (!Array.isArray(value)) {
      values[name] = value;
      continue;
    }
    const within = value.map(remarkWords);
    if (within.includes(null)) return null;
    values[name] = within.join('');
  }
  return sentences[remark.code](values);
}

/**
 * What the server says: by the reason that it gives. Its sentences are English: without one that the page knows they are
 * quoted in other languages, after what the code means.
 * @param {string|undefined} code of its closed list of errors
 * @param {string} text
 * @param {Remark|null} [reason]
 * @returns {string}
 */
export function serverWords(code, text, reason) {
  const said = reason?.code === 'text' ? null : remarkWords(reason);
  if (said !== null) return said;
  const meaning = strings.codes[code ?? ''];
  if (!meaning) return text;
  return !text ? meaning : language === kFallback ? text : strings.errors.verbatim(meaning, text);
}

/**
 * @param {number} status
 * @param {string} text the answer's body
 * @returns {ApiError}
 */
export function problem(status, text) {
  if (status === 401 && isFromLink()) return new ApiError(status, strings.access.link_over);
  try {
    const body = JSON.parse(text);
    if (body && (body.title || body.detail)) return new ApiError(status, body.title ?? '', serverWords(body.code, body.detail || body.title, body.reason));
  } catch {
    // Not a problem document (a proxy's page, say): the status alone has to tell.
  }
  return new ApiError(status, strings.errors.status(status));
}

/** @param {Promise<Response>} asked @returns {Promise<{response: Response, text: string}>} the whole answer; fails where it refuses */
export async function answerOf(asked) {
  /** @type {Response} */
  let response;
  /** @type {string} */
  let text;
  try {
    response = await asked;
    text = await response.text();  // the line may be cut within it
  } catch (error) {
    if (error instanceof DOMException && error.name === 'AbortError') throw error;
    throw new ApiError(0, strings.errors.unreachable);
  }
  if (!response.ok) throw problem(response.status, text);
  return { response, text };
}

/** @param {Response} response @param {string} text of it @returns {any} */
export function parsed({ status }, text) {
  try {
    return JSON.parse(text);
  } catch {
    throw new ApiError(status, strings.errors.not_json);
  }
}

/**
 * @param {string} method
 * @param {string} path
 * @param {object} [body]
 * @param {AbortSignal} [signal]
 * @param {RequestPriority} [priority] of what the first view can wait for
 * @param {Record<string, string>} [headers] besides, or in place of what is usual with a body
 * @returns {Promise<any>} the JSON, or null for an empty answer
 */
async function request(method, path, body, signal, priority = 'auto', headers = {}) {
  const early = method === 'GET' ? takeEarly(path) : null;
  const { response, text } = await answerOf(early ?? fetch(at(path), {
    method,
    signal,
    priority,
    headers: { ...authorization(), ...(body ? { 'Content-Type': 'application/json' } : {}), ...headers },
    body: body ? JSON.stringify(body) : undefined,
  })).catch((error) => {
    if (error.status === 401) import('./access.js').then(({ askForToken }) => askForToken()).catch(() => undefined);  // the answer says it too
    throw error;
  });
  return text === '' ? null : parsed(response, text);
}

/** @returns {string} that nothing else has */
export function newId() {
  // crypto.randomUUID is there on secure origins only; in a field network the page often comes over plain HTTP.
  return [...crypto.getRandomValues(new Uint8Array(16))].map((byte) => byte.toString(16).padStart(2, '0')).join('');
}

const flight_path = (/** @type {string} */ id) => `/api/v1/flights/${encodeURIComponent(id)}`;

/** All flights, newest first as the server lists them. @returns {Promise<Flight[]>} */
export async function listFlights() {
  /** @type {Flight[]} */
  const flights = [];
  let cursor = '';
  do {
    const page = await request('GET', `/api/v1/flights?limit=500${cursor}`);
    flights.push(...page.flights);
    cursor = page.next_cursor ? `&cursor=${encodeURIComponent(page.next_cursor)}` : '';
  } while (cursor);
  return flights;
}

/** @param {string} name @returns {Promise<Flight>} */
export const createFlight = (name) => request('POST', '/api/v1/flights', { name });

/** @param {string} id @param {AbortSignal} [signal] @returns {Promise<Flight>} */
export const getFlight = (id, signal) => request('GET', flight_path(id), undefined, signal);

/**
 * What the server makes of the files that it has, before any map is made. Null where it gives no verdicts.
 * @param {string} id
 * @param {AbortSignal} [signal]
 * @returns {Promise<ServerVerdict|null>}
 */
export async function getVerdict(id, signal) {
  try {
    return await request('GET', `${flight_path(id)}/verdict`, undefined, signal);
  } catch (error) {
    if (error instanceof ApiError && error.status === 503) return null;
    throw error;
  }
}

/** @type {Promise<Access|null>|null} */
let asked_access = null;

/** What who asks may do here. Asked once; what would be refused is not offered. @returns {Promise<Access|null>} null where the server does not say: then everything is offered, and it decides */
export function ownAccess() {
  asked_access ??= request('GET', '/api/v1/access').catch(() => {
    asked_access = null;  // the next who asks tries again
    return null;
  });
  return asked_access;
}

/** @returns {Promise<boolean>} whether flights can be added */
export async function mayUpload() {
  const access = await ownAccess();
  return access === null || access.scope !== 'read';
}

/** @param {string} id @param {{name?: string, tags?: string[], keep?: boolean}} change @returns {Promise<Flight>} */
export const changeFlight = (id, change) => request('PATCH', flight_path(id), change);

/** Into the trash, where the server keeps one. @param {string} id @returns {Promise<null>} */
export const deleteFlight = (id) => request('DELETE', flight_path(id));

/**
 * The ground's height along a line.
 * @param {string} id
 * @param {[number, number][]} places
 * @param {AbortSignal} [signal]
 * @returns {Promise<GroundProfile>} fails with 404 where the map knows no heights
 */
export const getHeights = (id, places, signal) => request('POST', `${flight_path(id)}/heights`, { type: 'LineString', coordinates: places }, signal);

/**
 * The heights of a map's surfaces at a place.
 * @param {string} id
 * @param {number} lon
 * @param {number} lat
 * @param {AbortSignal} [signal]
 * @returns {Promise<SurfaceHeights>}
 */
export const getSurfaceHeights = (id, lon, lat, signal) => request('GET', `${flight_path(id)}/point?lon=${lon}&lat=${lat}&ground=false`, undefined, signal);

/**
 * What lies above and below a base, of what the photos show.
 * @param {string} id
 * @param {string} base as the query has it: base=lowest, base=plane, base= with its height in metres, or since= with a flight
 * @param {GeoJSON.Polygon} outline
 * @param {AbortSignal} [signal]
 * @returns {Promise<VolumeFigures>}
 */
export const getVolume = (id, base, outline, signal) =>
  request('POST', `${flight_path(id)}/volume?of=dsm&${base}`, outline, signal, 'auto', { 'Content-Type': 'application/geo+json' });

/** How heights differ from another flight's. @param {string} id @param {string} since @returns {Promise<ChangeTileJson>} */
export const getChange = (id, since) => request('GET', `/tiles/${encodeURIComponent(id)}/change.json?of=dsm&since=${encodeURIComponent(since)}`);

/** @param {string} id @returns {Promise<ContourCollection>} */
export const getContours = (id) => request('GET', `${flight_path(id)}/contours.geojson`);

/** @returns {Promise<Trash>} */
export const getTrash = () => request('GET', '/api/v1/trash');

/** @param {string} id @returns {Promise<Flight>} */
export const restoreFlight = (id) => request('POST', `${flight_path(id)}/restore`);

/** For good. @param {string} id of a deleted flight @returns {Promise<null>} */
export const removeFlight = (id) => request('DELETE', `/api/v1/trash/${encodeURIComponent(id)}`);

const filePath = (/** @type {string} */ id, /** @type {string} */ name) => `${flight_path(id)}/files/${encodeURIComponent(name)}`;

/** @param {string} id @returns {Promise<StoredFile[]>} */
export const listFiles = async (id) => (await request('GET', `${flight_path(id)}/files`)).files ?? [];

/** What lies there under a name. @param {string} id @param {string} name @param {AbortSignal} signal @returns {Promise<ArrayBuffer>} */
export async function getFile(id, name, signal) {
  let bytes = new ArrayBuffer(0);
  await answerOf(fetch(at(filePath(id, name)), { signal, headers: authorization() }).then(async (response) => {
    if (!response.ok) return response;
    bytes = await response.arrayBuffer();
    return new Response();
  }));
  return bytes;
}

/** @param {string} id @param {string} name @returns {Promise<null>} */
export const deleteFile = (id, name) => request('DELETE', filePath(id, name));

/** The layers that the map page offers. */
export const kLayers = ['photo', 'error', 'height'];

/**
 * @param {string} id
 * @param {Record<string, any>} options JobOptions of the contract
 * @param {string} [key] asked again with the same, as where the answer was lost, the server begins none but the first
 * @returns {Promise<Job>}
 */
export const startJob = (id, options, key = newId()) => request('POST', `${flight_path(id)}/jobs`, { options }, undefined, 'auto', { 'Idempotency-Key': key });

/**
 * Moves the finished map to where what it shows really is; its layers come along.
 * @param {string} id
 * @param {import('../map/place_pairs.js').PlacePair[]} pairs
 * @returns {Promise<Job>}
 */
export function startPlacing(id, pairs) {
  const latLon = (/** @type {[number, number]} */ [lon, lat]) => [lat, lon];
  const place = pairs.map(({ shown, is }) => ({ shown: latLon(shown), is: latLon(is) }));
  return request('POST', `${flight_path(id)}/jobs`, { options: { place, layers: kLayers } });
}

/** Brings the finished map to the flight's control points. @param {string} id @returns {Promise<Job>} */
export const startControl = (id) => request('POST', `${flight_path(id)}/jobs`, { options: { place: 'control', layers: kLayers } });

/** @param {string} id @param {AbortSignal} [signal] @returns {Promise<Job>} */
export const getJob = (id, signal) => request('GET', `/api/v1/jobs/${encodeURIComponent(id)}`, undefined, signal);

/** @param {string} id @returns {Promise<Job|null>} */
export const cancelJob = (id) => request('DELETE', `/api/v1/jobs/${encodeURIComponent(id)}`);

/** @param {string} id @param {AbortSignal} [signal] @returns {Promise<Report>} */
export const getReport = (id, signal) => request('GET', `${flight_path(id)}/report`, undefined, signal, 'low');

/** @param {string} id @returns {Promise<PhotoCollection>} */
export const getPhotos = (id) => request('GET', `${flight_path(id)}/photos.geojson`, undefined, undefined, 'low');

/**
 * The photos that see a place, the best view first.
 * @param {string} id
 * @param {number} lon
 * @param {number} lat
 * @returns {Promise<Sighting[]>}
 */
export async function getSightings(id, lon, lat) {
  return (await request('GET', `${flight_path(id)}/at?lon=${lon}&lat=${lat}`)).photos;
}

/**
 * Where on the map a photo's pixel lies.
 * @param {string} id
 * @param {string} name of the photo
 * @param {number} x pixels: the centre of the first one is 0
 * @param {number} y
 * @returns {Promise<[number, number]>} longitude, latitude
 */
export async function getGround(id, name, x, y) {
  const { lon, lat } = await request('GET', `${flight_path(id)}/photos/${encodeURIComponent(name)}/ground?x=${x}&y=${y}`);
  return [lon, lat];
}

/** @param {string} id @param {string} name @returns {string} where the photo itself can be read */
export const photoPath = (id, name) => readable(filePath(id, name));

/** @param {string} path @returns {Promise<TileJson>} */
export const getTileJson = (path) => request('GET', path);

/** @param {string} path @returns {Promise<import('./types.js').LayerLegends>} */
export const getLegends = (path) => request('GET', path);

/** @param {string} id @returns {Promise<import('./types.js').MapBands>} */
export const getBands = (id) => request('GET', `${flight_path(id)}/bands`);

/** Enough for a histogram, and quickly counted. */
const kCountedPixels = 500_000;

/**
 * What an index comes to over the whole map.
 * @param {string} id
 * @param {string} query which index
 * @param {import('./types.js').Bounds} bounds
 * @returns {Promise<import('./types.js').IndexStatistics>}
 */
export async function getIndexStatistics(id, query, [west, south, east, north]) {
  const outlineOf = (/** @type {number} */ from, /** @type {number} */ to) => [[[from, south], [to, south], [to, north], [from, north], [from, south]]];
  // Across the antimeridian one rectangle on either side of it.
  const area = east > 180
    ? { type: 'MultiPolygon', coordinates: [outlineOf(west, 180), outlineOf(-180, east - 360)] }
    : { type: 'Polygon', coordinates: outlineOf(west, east) };
  return (await request('POST', `${flight_path(id)}/statistics?max_pixels=${kCountedPixels}&${query}`, area)).index;
}

/**
 * @param {string} id
 * @param {string} query which index
 * @param {number} lon
 * @param {number} lat
 * @returns {Promise<number|null>} null: it has no value there
 */
export async function getIndexValue(id, query, lon, lat) {
  return (await request('GET', `${flight_path(id)}/point?lon=${lon}&lat=${lat}&ground=false&${query}`)).index.value;
}

/** @param {string} id @param {string} query which index, how many classes, which format @returns {string} */
export const zonesPath = (id, query) => readable(`${flight_path(id)}/zones?${query}`);

/**
 * @param {string} id
 * @returns {Promise<{needs_token: boolean, may_open_network: boolean, addresses: string[], shares: Share[]}>} addresses: where other
 *   machines reach the server; may_open_network: whoever asks can let them
 */
export const listShares = (id) => request('GET', `${flight_path(id)}/shares`);

/** Until the server ends. @returns {Promise<{addresses: string[]}>} */
export const openNetwork = () => request('POST', '/api/v1/network');

/** @param {string} id @param {number|null} days null: it never ends @returns {Promise<Share & {token: string, page: string, embed: string}>} */
export const addShare = (id, days) => request('POST', `${flight_path(id)}/shares`, { expires_in_days: days });

/** @param {string} id @param {string} share its id @returns {Promise<null>} */
export const removeShare = (id, share) => request('DELETE', `${flight_path(id)}/shares/${encodeURIComponent(share)}`);

/**
 * The whole map as one small picture.
 * @param {Flight} flight with a map
 * @param {'list'|'whole'} [use] of 15 kB, or the poster that the page opens with
 * @returns {string} another one for each revision
 */
export const thumbnailPath = ({ id, revision }, use = 'list') =>
  readable(`${flight_path(id)}/thumbnail.webp?size=${use === 'list' ? 320 : 1024}&rev=${revision}`);

/** @typedef {'download.tif'|'download.mbtiles'|'download.pmtiles'|'download.zip'|'photos.geojson'|'bands.tif'|'dsm.tif'|'dtm.tif'|'contours.gpkg'|'contours.dxf'} DownloadName */

/** @param {string} id @param {DownloadName} name @returns {string} */
export const downloadPath = (id, name) => `${flight_path(id)}/${name}`;

/**
 * @param {string} id
 * @param {DownloadName} name
 * @returns {Promise<number|null>} null when the server does not say, cannot be reached, or has none
 */
export async function downloadSize(id, name) {
  const response = await fetch(at(downloadPath(id, name)), { method: 'HEAD', headers: authorization() }).catch(() => null);
  const length = response?.ok ? Number(response.headers.get('Content-Length') ?? NaN) : NaN;
  return Number.isFinite(length) ? length : null;
}

/** @typedef {{format: string, crs?: string, resolution_m?: number, boundary?: GeoJSON.Geometry, index?: string, expression?: string}} ExportWish */

/** @param {string} id @returns {Promise<MapExport[]>} newest first */
export const listExports = async (id) => (await request('GET', `${flight_path(id)}/exports`)).exports;

/** @param {string} id @param {ExportWish} wish @returns {Promise<MapExport>} */
export const startExport = (id, wish) => request('POST', `${flight_path(id)}/exports`, wish);

/** Also one that is still being made. @param {string} id @param {string} made its id @returns {Promise<null>} */
export const removeExport = (id, made) => request('DELETE', `${flight_path(id)}/exports/${encodeURIComponent(made)}`);
