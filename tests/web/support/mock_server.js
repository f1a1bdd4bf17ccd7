// A stand-in for the server with the same HTTP API, for developing and testing the page alone. Development only.
// Run it by hand: node tests/web/support/mock_server.js [PORT]
//
// Names steer it: a file called *flaky* is refused once with 503, *refused* always with 422; a flight called
// *doomed* fails in its job. Jobs take options.job_ms.
import { createReadStream, existsSync, statSync } from 'node:fs';
import { createServer } from 'node:http';
import { dirname, extname, join, normalize } from 'node:path';
import { setTimeout as delay } from 'node:timers/promises';
import { fileURLToPath } from 'node:url';
import { gzipSync } from 'node:zlib';
import { tilePosition } from '../../../web/src/map/tile_addresses.js';
import { boundsOf, moveByPairs, photosGeoJson, reportOf, unplacedQuality } from './mock_flight.js';
import { answerExports, answerIndices, heightsOf, index_facts, indexTile, mockTus, reported_bands } from './mock_parts.js';
import { countrysidePicture, countrysideTile, encodePng } from './tile_picture.js';

export const web_root = join(dirname(fileURLToPath(import.meta.url)), '../../../web');
const max_zoom = 21;
const types = {
  '.html': 'text/html; charset=utf-8',
  '.css': 'text/css',
  '.js': 'text/javascript',
  '.mjs': 'text/javascript',
  '.svg': 'image/svg+xml',
};
export const security_headers = {
  'Content-Security-Policy':
    "default-src 'self'; img-src 'self' data: blob:; worker-src 'self' blob:; object-src 'none'; base-uri 'none'; frame-ancestors 'none'",
  'X-Content-Type-Options': 'nosniff',
  'Referrer-Policy': 'no-referrer',
};
const stages = ['read', 'pose', 'align', 'expose', 'render', 'export'];

// As those who run the server see them.
const kParts = [
  { kind: 'look', part: 3, worker: 'worker-a-7', since: '2026-11-21T10:00:00.000Z', attempt: 1 },
  { kind: 'look', part: 12, worker: 'worker-b-9', since: '2026-11-21T10:01:00.000Z', attempt: 2 },
];
const kAside = [
  { worker: 'worker-c-4', since: '2026-11-21T09:59:00.000Z', until: '2026-11-21T10:04:00.000Z', times: 3, code: 'out_of_space', message: 'The disk is full.' },
];
/** Where the network reaches it, once it was opened. */
export const kNetworkAddress = 'http://192.168.1.20:8080';

/**
 * @param {{port?: number, job_ms?: number, upload_ms?: number, basemap_makers?: string, public_basemap?: string, has_tokens?: boolean, scope?: 'read'|'upload'|'admin', trash_days?: number, keep_days?: number, is_whole?: boolean, is_unplaced?: boolean, has_indices?: boolean, has_heights?: boolean, bands_bounds?: number[], page_limit?: number, addresses?: string[]}} [options] upload_ms: time each file takes at least;
 *   addresses: where other machines reach it;
 *   basemap_makers: there is a basemap, of theirs; public_basemap: https://host of tiles that a browser may choose; has_tokens: it asks for tokens where flights are shared; scope: what
 *   every token may do; page_limit: flights in one answer, few so that paging is used; is_whole: maps have all photos; is_unplaced: they lie nowhere until they are placed
 */
export async function startMockServer(options = {}) {
  const job_ms = options.job_ms ?? 2500;
  const flights = new Map();
  const deleted = new Map();
  const trash_days = options.trash_days ?? 30;
  const jobs = new Map();
  const refused_once = new Set();
  /** Uploads wait here while a test holds them. */
  let gate = Promise.resolve();
  let held_uploads = 0;
  let counter = 0;
  const newId = () => `f${(counter += 1).toString(36).padStart(8, '0')}`;

  /** Holds every upload that comes from now on; the answer lets them through. */
  function holdUploads() {
    /** @type {() => void} */
    let release = () => {};
    gate = new Promise((resolve) => { release = () => resolve(undefined); });
    return release;
  }

  function addFlight(name) {
    const flight = {
      id: newId(), name, created_at: new Date(Date.UTC(2026, 4, 12, 9, 30 + counter)).toISOString(), files: new Map(), shares: [], tags: /** @type {string[]} */ ([]), keep: false,
      job: null, ready: false, captured: { first: '2026-05-12T09:31:00+02:00', last: '2026-05-12T09:31:34+02:00' },
      verdict: { photos_by_images: 0, gsd_m: 0.0173, area_m2: 24_310, expected_seconds: 21, left_out: [], warnings: [] }, revision: null, error: null,
      place: { lon: 7.4391, lat: 46.9512, half_m: 105, season: counter },
    };
    flights.set(flight.id, flight);
    return flight;
  }

  /** A flight whose map is there already. */
  function seedReady(name, photos = 18) {
    const flight = addFlight(name);
    for (let i = 0; i < photos; i += 1) flight.files.set(`DJI_${String(i + 1).padStart(4, '0')}.JPG`, 6_800_000 + i * 4211);
    flight.ready = true;
    flight.revision = 1;
    return flight;
  }

  function jobJson(job) {
    if (!job) return null;
    const flight = flights.get(job.flight_id);
    if (job.state === 'accepted' || job.state === 'running') {
      const age = Date.now() - job.at;
      const progress = Math.min(1, Math.max(0, (age - 300) / job_ms));
      const doomed = (flight?.name.includes('doomed') || (job.placing && flight?.contradicts_pairs)) && progress > 0.4;
      Object.assign(job, {
        state: doomed ? 'failed' : progress >= 1 ? 'successful' : age > 300 ? 'running' : 'accepted',
        stage: stages[Math.min(stages.length - 1, Math.floor(progress * stages.length))],
        progress,
        eta_s: progress > 0 ? ((1 - progress) * job_ms) / 1000 : null,
        eta_low_s: progress > 0 ? (0.8 * (1 - progress) * job_ms) / 1000 : null,
        eta_high_s: progress > 0 ? (1.25 * (1 - progress) * job_ms) / 1000 : null,
        message: '',
        ...(flight?.name.includes('large') && { parts: kParts, workers_aside: kAside }),
        error: doomed ? { code: 'unprocessable', message: 'No photo has a GPS position. Add the flight log or photos with GPS.' } : null,
      });
      if (job.state === 'successful' && flight) {
        flight.ready = true;
        flight.revision = (flight.revision ?? 0) + 1;
        if (job.placing) moveByPairs(flight, job.placing);
      }
      if (doomed && flight) flight.error = job.error;
    }
    const { at, placing, ...rest } = job;
    return rest;
  }

  const mapQuality = (flight, report) => (options.is_unplaced && !flight.is_placed ? unplacedQuality(report.quality) : report.quality);

  function flightJson(flight) {
    const job = jobJson(flight.job);
    const names = [...flight.files.keys()];
    const busy = job && (job.state === 'accepted' || job.state === 'running');
    let state = flight.ready ? 'ready' : names.length > 0 ? 'uploaded' : 'empty';
    if (job?.state === 'failed' && !flight.job.placing) state = 'failed';
    if (busy) state = job.state === 'accepted' ? 'queued' : 'processing';
    const report = flight.ready ? reportOf(flight.place, names, max_zoom, options.is_whole) : null;
    return {
      id: flight.id, name: flight.name, state, created_at: flight.created_at, file_count: names.length,
      bytes: [...flight.files.values()].reduce((a, b) => a + b, 0), revision: flight.revision, job,
      bounds: report?.bounds ?? null, georeferenced: report ? report.bounds.some((/** @type {number} */ degrees) => Math.abs(degrees) >= 0.1) : null, min_zoom: report?.min_zoom ?? null, max_zoom: report?.max_zoom ?? null,
      photos: report?.photos ?? null, captured: flight.ready ? flight.captured : null, gsd_m: report?.gsd_m ?? null, quality: report ? mapQuality(flight, report) : null,
      tilejson: flight.ready ? `/tiles/${flight.id}.json` : null, preview: null, error: flight.error, tags: flight.tags, keep: flight.keep, may_change: flight.may_change ?? options.scope !== 'read',
    };
  }

  const uploads = mockTus(async ({ flight: flight_id, name, length }, isGone) => {
    held_uploads += 1;
    while (!isGone() && (await Promise.race([gate.then(() => true), delay(20, false)])) === false);
    held_uploads -= 1;
    if (isGone()) return null;
    if (options.upload_ms) await new Promise((resolve) => setTimeout(resolve, options.upload_ms));
    if (isGone()) return null;  // a file that nobody sends any more does not come after it was counted
    const refusal = (status, title, detail) => ({ type: 'about:blank', title, status, detail });
    if (name.includes('refused')) return refusal(422, 'Not a photo', 'The photo is cut off after 12 kB; copy it from the card again.');
    if (name.includes('flaky') && !refused_once.has(name)) {
      refused_once.add(name);
      return refusal(503, 'Busy', 'Try again in a moment.');
    }
    const flight = flights.get(flight_id);
    if (!flight) return refusal(404, 'No such flight', 'This flight does not exist.');
    flight.files.set(name, length);
    return null;
  });

  let is_open = false;  // to the network
  let is_closed = false;

  const server = createServer(async (request, response) => {
    const url = new URL(request.url ?? '/', 'http://mock');
    const path = decodeURI(url.pathname);
    const send = (status, body, type = 'application/json', headers = {}) => {
      const plain = Buffer.isBuffer(body) ? body : body === null ? Buffer.alloc(0) : Buffer.from(JSON.stringify(body));
      const as_gzip = !Buffer.isBuffer(body) && plain.length > 1000 && /\bgzip\b/.test(String(request.headers['accept-encoding']));
      const bytes = as_gzip ? gzipSync(plain) : plain;
      response.writeHead(status, { 'Content-Type': type, 'Content-Length': bytes.length, ...(as_gzip ? { 'Content-Encoding': 'gzip' } : {}), ...security_headers, ...headers });
      response.end(bytes);
    };
    const problem = (status, title, detail) => send(status, { type: 'about:blank', title, status, detail }, 'application/problem+json');
    const readBody = async () => {
      const parts = [];
      for await (const part of request) parts.push(part);
      return Buffer.concat(parts);
    };

    const answered = await uploads(path, request, readBody, () => is_closed || response.destroyed);
    if (answered && (is_closed || response.destroyed)) return undefined;
    if (answered) return send(answered.status, answered.body ?? null, answered.body ? 'application/problem+json' : 'text/plain', answered.headers);
    let match;
    if (options.scope === 'read' && !['GET', 'HEAD'].includes(request.method ?? '')) {
      await readBody();
      return problem(403, 'Forbidden', 'This token may not do that: it needs the scope "upload".');
    }
    if (path === '/api/v1/network' && request.method === 'POST') {
      is_open = true;
      return send(200, { addresses: [kNetworkAddress] });
    }
    if (path === '/api/v1/access') return send(200, { needs_token: Boolean(options.has_tokens), scope: options.scope ?? 'admin', flight: null, keep_days: options.keep_days ?? 0 });
    if (path === '/basemap.json') {
      const left = options.public_basemap ? [{ name: 'stand-in', title: 'Stand-in', tiles: [`${options.public_basemap}/{z}/{x}/{y}.png`], attribution: 'Stand-in makers', maxzoom: 19 }] : [];
      if (!options.basemap_makers) return send(200, { tilejson: '3.0.0', tiles: [], public: left });
      return send(200, { tilejson: '3.0.0', tiles: [`http://${request.headers.host}/basemap.png?{z}/{x}/{y}`], attribution: options.basemap_makers });
    }
    if (path === '/basemap.png') return send(200, encodePng(1, 1, new Uint8Array([200, 210, 200, 255])), 'image/png');
    if (path === '/api/v1/events') {
      response.writeHead(200, { 'Content-Type': 'text/event-stream', ...security_headers });
      response.write(': nothing happens here but what the page asks for\n\n');
      return undefined;
    }
    if (path === '/api/v1/trash') {
      const kept = [...deleted.values()].map((flight) => {
        const { id, name, created_at, file_count, bytes } = flightJson(flight);
        return { id, name, created_at, file_count, bytes, deleted_at: created_at, removed_at: created_at, days_left: trash_days };
      });
      return send(200, { days: trash_days, flights: kept });
    }
    if ((match = path.match(/^\/api\/v1\/trash\/([^/]+)$/)) && request.method === 'DELETE') {
      return deleted.delete(match[1]) ? send(204, null) : problem(404, 'No such flight', 'There is no such deleted flight.');
    }
    if (path === '/api/v1/flights' && request.method === 'POST') {
      const { name } = JSON.parse((await readBody()).toString());
      return send(201, flightJson(addFlight(name)));
    }
    if (path === '/api/v1/flights') {
      const all = [...flights.values()].reverse();
      const start = Number(url.searchParams.get('cursor') ?? 0);
      const limit = Math.min(options.page_limit ?? 3, Number(url.searchParams.get('limit') ?? 50));  // small pages, so that paging is used
      const next = start + limit < all.length ? String(start + limit) : null;
      return send(200, { flights: all.slice(start, start + limit).map(flightJson), next_cursor: next });
    }
    if ((match = path.match(/^\/api\/v1\/jobs\/([^/]+)$/))) {
      const job = jobs.get(match[1]);
      if (!job) return problem(404, 'No such job', 'This job does not exist.');
      if (request.method === 'DELETE' && (job.state === 'accepted' || job.state === 'running')) job.state = 'dismissed';
      return send(200, jobJson(job));
    }
    if ((match = path.match(/^\/api\/v1\/flights\/([^/]+)(\/.*)?$/))) {
      const rest = match[2] ?? '';
      if (rest === '/restore' && request.method === 'POST' && deleted.has(match[1])) {
        flights.set(match[1], deleted.get(match[1]));
        deleted.delete(match[1]);
        return send(200, flightJson(flights.get(match[1])));
      }
      const flight = flights.get(match[1]);
      if (!flight) {
        await readBody();
        return problem(404, 'No such flight', 'This flight does not exist.');
      }
      if (rest === '' && request.method === 'PATCH') {
        Object.assign(flight, JSON.parse((await readBody()).toString()));
        return send(200, flightJson(flight));
      }
      if (rest === '' && request.method === 'DELETE') {
        flights.delete(flight.id);
        if (trash_days > 0) deleted.set(flight.id, flight);
        return send(204, null);
      }
      if (rest === '') return send(200, flightJson(flight));
      if (rest === '/heights') {
        flight.asked_heights = (flight.asked_heights ?? 0) + 1;
        const found = heightsOf(flight, JSON.parse((await readBody()).toString()));
        return found ? send(200, found) : problem(404, 'Not found', 'This map knows no heights.');
      }
      if (rest === '/verdict') {
        const photos = [...flight.files.keys()].filter((name) => /\.jpg$/i.test(name)).length;
        return send(200, { photos_readable: photos, photos_placeable: photos, ...flight.verdict });
      }
      if (rest === '/files') return send(200, { files: [...flight.files].map(([name, bytes]) => ({ name, bytes })) });
      if (rest.startsWith('/files/') && request.method === 'GET') {
        const { x, y } = tilePosition(flight.place.lon, flight.place.lat, 18);
        return send(200, countrysideTile(flight.place, 18, Math.floor(x), Math.floor(y)), 'image/png');
      }
      if (rest === '/at') {
        const names = [...flight.files.keys()].slice(2, 5);
        return send(200, { photos: names.map((name, i) => ({ name, x: 40 + 10 * i, y: 60, off_nadir_deg: [21, 3, 9][i], placement: 'aligned', sigma_m: 2.3 })) });
      }
      if (rest === '/shares' && request.method === 'GET') {
        return send(200, { needs_token: Boolean(options.has_tokens) || is_open, may_open_network: !options.addresses, addresses: options.addresses ?? (is_open ? [kNetworkAddress] : []), shares: flight.shares.map(({ token, page, embed, ...share }) => share) });
      }
      if (rest === '/shares' && request.method === 'POST') {
        const { expires_in_days: days } = JSON.parse((await readBody()).toString());
        const token = `sq_${newId()}`;
        const share = { id: newId(), created_at: new Date().toISOString(), expires_at: days ? new Date(Date.now() + days * 86_400_000).toISOString() : null,
          token, page: `/#/flights/${flight.id}?token=${token}`, embed: `/embed/${flight.id}#token=${token}` };
        flight.shares.unshift(share);
        return send(201, share);
      }
      if (rest.startsWith('/shares/') && request.method === 'DELETE') {
        flight.shares = flight.shares.filter(({ id }) => id !== rest.slice('/shares/'.length));
        return send(204, null);
      }
      if (rest === '/notes') {
        flight.notes ??= { features: [], number: 0 };
        const etag = () => (flight.notes.number === 0 ? '"none"' : `"n${flight.notes.number}"`);
        if (request.method === 'PUT') {
          const { features } = JSON.parse((await readBody()).toString());
          if (flight.refuses_notes) return problem(flight.refuses_notes.status, 'Refused', flight.refuses_notes.detail);
          if (request.headers['if-match'] !== etag()) return problem(412, 'Changed', 'The notes were changed elsewhere meanwhile.');
          flight.notes = { features, number: flight.notes.number + 1 };
        }
        return send(200, { type: 'FeatureCollection', features: flight.notes.features }, 'application/geo+json', { ETag: etag() });
      }
      if (rest.startsWith('/exports')) {
        const answer = answerExports(flight, request.method ?? 'GET', rest, request.method === 'POST' ? JSON.parse((await readBody()).toString()) : null);
        return answer.file ? send(200, answer.file, 'image/tiff') : answer.detail ? problem(answer.status, 'Refused', answer.detail) : send(answer.status, answer.body ?? null);
      }
      if (rest === '/jobs' && request.method === 'POST') {
        const { options: asked = {} } = JSON.parse((await readBody()).toString() || '{}');
        if (flight.refuses_jobs) return problem(flight.refuses_jobs.status, 'Refused', flight.refuses_jobs.detail);
        const job = { placing: asked.place ?? null, options: asked, id: `j${newId()}`, flight_id: flight.id, state: 'accepted', stage: 'queued', progress: 0, message: '', eta_s: null, eta_low_s: null, eta_high_s: null, priority: 0, attempts: 1,
          created_at: new Date().toISOString(), started_at: null, finished_at: null, error: null, at: Date.now() };
        flight.error = null;
        flight.job = job;
        jobs.set(job.id, job);
        return send(202, jobJson(job));
      }
      const names = [...flight.files.keys()];
      if (!flight.ready) return problem(404, 'No map yet', 'The map of this flight has not been made.');
      const of_indices = answerIndices(rest, url.searchParams);
      if (of_indices) return of_indices.detail ? problem(of_indices.status, 'Bad request', of_indices.detail) : send(of_indices.status, of_indices.body ?? null);
      if (rest === '/report') return send(200, { ...reportOf(flight.place, names, max_zoom, options.is_whole), quality: mapQuality(flight, reportOf(flight.place, names, max_zoom, options.is_whole)), is_placed: !(options.is_unplaced && !flight.is_placed), ...(options.has_heights ? { surface: { cell_m: 0.1, measured_share: 0.9, heights_from: 'records', records_from: 'take_off' } } : {}), ...(options.bands_bounds ? { bands: reported_bands } : {}), alignment: { placed_by: options.is_unplaced ? 'images' : 'records' } });
      if (rest === '/photos.geojson') return send(200, photosGeoJson(flight.place, names), 'application/geo+json');
      if (rest === '/thumbnail.webp' || rest === '/thumbnail.png') return send(200, countrysidePicture(flight.place, url.searchParams.get('size') === '1024' ? 1000 : 160), 'image/png');
      if (options.has_heights && ['/dsm.tif', '/dtm.tif', '/contours.gpkg', '/contours.dxf'].includes(rest)) return send(200, Buffer.from('heights'), 'application/octet-stream');
      if (rest.startsWith('/download.')) return send(200, Buffer.from('mock'), 'application/octet-stream');
    }
    if ((match = path.match(/^\/tiles\/([^/]+)\.json$/)) && flights.get(match[1])?.ready) {
      const flight = flights.get(match[1]);
      return send(200, {
        tilejson: '3.0.0', version: `${flight.revision}.0.0`, tiles: [`http://${request.headers.host}/tiles/${flight.id}/{z}/{x}/{y}?rev=${flight.revision}`], tileSize: 256,
        minzoom: 14, maxzoom: max_zoom, bounds: boundsOf(flight.place), name: flight.name, attribution: flight.attribution, ...(options.has_indices ? index_facts : {}),
        ...(options.bands_bounds ? { bands_bounds: options.bands_bounds } : {}),
      });
    }
    if ((match = path.match(/^\/tiles\/([^/]+)\/(\d+)\/(\d+)\/(\d+)(?:\.png)?$/)) && flights.get(match[1])?.ready) {
      const [z, x, y] = match.slice(2).map(Number);
      if (url.searchParams.has('index') || url.searchParams.has('expression')) return send(200, indexTile(url.searchParams), 'image/png', { 'Cache-Control': 'no-cache' });
      return send(200, countrysideTile(flights.get(match[1]).place, z, x, y), 'image/png', { 'Cache-Control': 'no-cache' });
    }
    if (path.startsWith('/api/') || path.startsWith('/tiles/')) return problem(404, 'Not found', `There is nothing at ${path}.`);
    const is_bare_map = /^\/embed\/\w+$/.test(path);
    const policy = security_headers['Content-Security-Policy'].replace("img-src 'self'", `connect-src 'self' ${options.public_basemap ?? ''}; img-src 'self' ${options.public_basemap ?? ''}`);
    const page_headers = { ...security_headers, 'Content-Security-Policy': is_bare_map ? policy.replace(/frame-ancestors .*/, 'frame-ancestors *') : policy };
    const file = join(web_root, normalize(is_bare_map ? '/embed.html' : path === '/' ? '/index.html' : path));
    if (!file.startsWith(web_root) || !existsSync(file) || !statSync(file).isFile()) return problem(404, 'Not found', path);
    // As the server does: what the build compressed is sent so.
    const as_gzip = existsSync(`${file}.gz`) && /\bgzip\b/.test(String(request.headers['accept-encoding']));
    const sent = as_gzip ? `${file}.gz` : file;
    response.writeHead(200, { 'Content-Type': types[extname(file)] ?? 'application/octet-stream', 'Content-Length': statSync(sent).size, ...(as_gzip ? { 'Content-Encoding': 'gzip' } : {}), ...page_headers });
    createReadStream(sent).pipe(response);
    return undefined;
  });
  await new Promise((resolve) => server.listen(options.port ?? 0, '127.0.0.1', () => resolve(undefined)));
  const { port } = /** @type {any} */ (server.address());
  return {
    url: `http://127.0.0.1:${port}/`,
    flights,
    deleted,
    seedReady,
    addFlight,
    holdUploads,
    heldUploads: () => held_uploads,
    close: () => {
      is_closed = true;  // what a test still holds waits no longer
      server.closeAllConnections();
      return new Promise((resolve) => server.close(resolve));
    },
  };
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const mock = await startMockServer({ port: Number(process.argv[2] ?? 0), job_ms: 12_000, upload_ms: 600 });
  mock.seedReady('Brook meadow');
  mock.seedReady('Brook meadow, two weeks later', 24);
  console.log(mock.url);
}
