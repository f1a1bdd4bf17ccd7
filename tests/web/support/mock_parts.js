// What the stand-in server answers to uploads, exports, heights and indices.
import { encodePng } from './tile_picture.js';
import { geodesicLength } from '../../../web/src/map/geodesy.js';

// Uploads: as much of tus 1.0 as the page uses.

/**
 * @param {(upload: {flight: string, name: string, length: number}, isGone: () => boolean) => Promise<object|null>} finish
 *   takes a whole file, unless the client is gone by then; a problem refuses it
 */
export function mockTus(finish) {
  /** @type {Map<string, {flight: string, name: string, length: number, offset: number}>} */
  const uploads = new Map();
  let counter = 0;

  const metadataOf = (/** @type {string} */ header) =>
    Object.fromEntries(header.split(',').map((pair) => {
      const [key, value] = pair.trim().split(' ');
      return [key, Buffer.from(value ?? '', 'base64').toString()];
    }));

  /**
   * @param {string} path
   * @param {import('node:http').IncomingMessage} request
   * @param {() => Promise<Buffer>} readBody
   * @param {() => boolean} isGone
   * @returns {Promise<{status: number, headers?: object, body?: object}|null>} null: not an address of uploads
   */
  return async function answer(path, request, readBody, isGone) {
    if (!path.startsWith('/api/v1/uploads')) return null;
    const headers = { 'Tus-Resumable': '1.0.0' };
    let id = path.slice('/api/v1/uploads/'.length);
    if (request.method === 'POST') {
      const { flight, filename } = metadataOf(String(request.headers['upload-metadata']));
      id = `u${(counter += 1)}`;
      uploads.set(id, { flight, name: filename, length: Number(request.headers['upload-length']), offset: 0 });
      Object.assign(headers, { Location: `/api/v1/uploads/${id}` });
    }
    const upload = uploads.get(id);
    if (!upload) return { status: 404, headers };
    if (request.method === 'PATCH' || request.method === 'POST') {
      const body = await readBody();
      if (request.method === 'PATCH' && Number(request.headers['upload-offset']) !== upload.offset) return { status: 409, headers };
      if (upload.offset + body.length === upload.length) {
        const refusal = await finish(upload, isGone);
        if (refusal) return { status: /** @type {any} */ (refusal).status, headers, body: refusal };
        if (isGone()) return { status: 499, headers };
      }
      upload.offset += body.length;
    }
    Object.assign(headers, { 'Upload-Offset': String(upload.offset), 'Upload-Length': String(upload.length) });
    return { status: request.method === 'POST' ? 201 : request.method === 'PATCH' ? 204 : 200, headers };
  };
}

// Exports: made in a second, in four steps; EPSG:1 is refused, EPSG:2 fails while it is made.

const kStep_ms = 250;

/**
 * @param {any} flight
 * @param {string} method
 * @param {string} rest of the address
 * @param {any} wish
 * @returns {{status?: number, body?: object, detail?: string, file?: Buffer}}
 */
export function answerExports(flight, method, rest, wish) {
  flight.exports ??= [];
  const [, , id, file] = rest.split('/');
  if (method === 'POST') {
    if (wish.crs === 'EPSG:1') return { status: 422, detail: 'There is no coordinate system EPSG:1. Look the code up at epsg.io, or use "utm".' };
    flight.exports.unshift({ ...wish, id: `e${flight.exports.length + 1}`, at: Date.now() });
    return { status: 202, body: exportJson(flight, flight.exports[0]) };
  }
  if (!id) return { status: 200, body: { exports: flight.exports.map((/** @type {any} */ made) => exportJson(flight, made)) } };
  if (method === 'DELETE') {
    flight.exports = flight.exports.filter((/** @type {any} */ made) => made.id !== id);
    return { status: 204 };
  }
  return file ? { file: Buffer.from('mock') } : { status: 404, detail: 'No such export.' };
}

/** @param {any} flight @param {any} made */
function exportJson(flight, { id, at, format, crs = null, resolution_m = null, boundary = null }) {
  const progress = Math.min(1, Math.floor((Date.now() - at) / kStep_ms) / 4);
  const state = progress === 0 ? 'accepted' : progress < 1 ? 'running' : crs === 'EPSG:2' ? 'failed' : 'successful';
  const href = `/api/v1/flights/${flight.id}/exports/${id}`;
  return {
    id, flight_id: flight.id, revision: 1, is_current: true, format, crs, resolution_m, boundary, state, progress,
    bytes: state === 'successful' ? 12_345_678 : null, error: state === 'failed' ? { code: 'unprocessable', message: 'The map lies outside the coordinate system.' } : null,
    created_at: new Date(at).toISOString(), finished_at: null, expires_at: progress === 1 ? new Date(at + 86_400_000).toISOString() : null, href, download: state === 'successful' ? `${href}/file` : null,
  };
}

// Heights: a hill around the middle of each map, nothing beyond 400 m of it.

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

// Indices of colours, their values made up; what was asked for is kept for tests to read.

const kIndices = [
  { id: 'vari', title: 'VARI', expression: '(green-red)/(green+red-blue)', rescale: [-0.4, 0.4], colormap: 'rdylgn' },
  { id: 'gli', title: 'GLI', expression: '(2*green-red-blue)/(2*green+red+blue)', rescale: [-0.2, 0.3], colormap: 'rdylgn' },
];
const kColormaps = [
  { id: 'rdylgn', colours: ['#a50026', '#ffffbf', '#006837'] },
  { id: 'viridis', colours: ['#440154', '#1f9e89', '#fde725'] },
];
export const reported_bands = { bands: ['red', 'green', 'blue'].map((name) => ({ name, calibration: name === 'blue' ? 'levels' : 'reflectance', held_against: name === 'blue' ? null : 'panel' })) };
export const index_facts = { bands: ['red', 'green', 'blue'], indices: kIndices };

/** One colour for one request, so that a picture of the page tells which tiles it shows. @param {URLSearchParams} query */
export const indexTile = (query) => {
  const of_green = query.get('colormap') === 'rdylgn' ? [0, 160, 60, 255] : [200, 40, 200, 255];
  return encodePng(8, 8, new Uint8Array(8 * 8 * 4).map((_, i) => of_green[i % 4]));
};

/**
 * @param {string} rest of the address, below the flight
 * @param {URLSearchParams} query
 * @returns {{status: number, body?: object, detail?: string}|null} null: no matter of indices
 */
export function answerIndices(rest, query) {
  if (rest === '/bands') return { status: 200, body: { revision: 1, ...index_facts, colormaps: kColormaps } };
  const expression = query.get('expression');
  if (rest !== '/point' && rest !== '/statistics') return null;
  if (expression?.endsWith('+')) return { status: 400, detail: `The expression cannot be read at character ${expression.length + 1}: it ends where a band or a number is expected.` };
  const named = kIndices.find(({ id }) => id === query.get('index'));
  const about = { title: named?.title ?? expression, expression: named?.expression ?? expression };
  if (rest === '/point') return { status: 200, body: { lon: Number(query.get('lon')), lat: Number(query.get('lat')), revision: 1, colour: null, height_m: null, photo: null, index: { ...about, value: 0.25 } } };
  const histogram = Array.from({ length: 64 }, (_, i) => Math.round(1000 * Math.exp(-(((i - 32) / 12) ** 2))));
  const percentiles = Object.fromEntries([2, 5, 10, 25, 50, 75, 90, 95, 98].map((p) => [`p${p}`, -0.3 + (0.6 * p) / 100]));
  return { status: 200, body: { index: { ...about, pixels: 20_000, min: -0.5, max: 0.5, mean: 0.01, std: 0.1, percentiles, histogram } } };
}
