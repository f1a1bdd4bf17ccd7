// Exports of the stand-in server: made in a second, in four steps; EPSG:1 is refused, EPSG:2 fails while it is made.

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
