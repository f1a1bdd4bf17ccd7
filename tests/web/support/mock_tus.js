// The stand-in server's uploads: as much of tus 1.0 as the page uses.

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
