// The PMTiles of a real job, read with the format's own library: exactly the tileset's tiles.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { existsSync, mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { test } from 'node:test';
import { fileURLToPath, pathToFileURL } from 'node:url';

const web_root = join(dirname(fileURLToPath(import.meta.url)), '../../web');
const library = join(web_root, 'node_modules/pmtiles/dist/esm/index.js');
const program = process.env.SKYQUILT_BINARY;
const skip = !existsSync(library)
  ? 'web/node_modules is missing (npm ci in web/)'
  : !program || !existsSync(program)
    ? 'no program: set SKYQUILT_BINARY'
    : spawnSync('sqlite3', ['--version']).error
      ? 'no program sqlite3'
      : false;

/** @param {string} path */
function fileSource(path) {
  const bytes = readFileSync(path);
  return {
    getKey: () => path,
    getBytes: async (/** @type {number} */ offset, /** @type {number} */ length) => ({
      data: bytes.buffer.slice(bytes.byteOffset + offset, bytes.byteOffset + Math.min(offset + length, bytes.length)),
    }),
  };
}

/** @param {string} file @param {string[]} args */
function run(file, args) {
  const done = spawnSync(file, args, { encoding: 'utf8', maxBuffer: 1 << 30 });
  assert.equal(done.status, 0, done.stderr);
  return done.stdout;
}

test('the archive answers with exactly the tiles of the MBTiles', { skip, timeout: 300_000 }, async () => {
  const { PMTiles } = await import(pathToFileURL(library).href);
  const folder = mkdtempSync(join(tmpdir(), 'skyquilt_pmtiles_'));
  try {
    run(program ?? '', ['simulate', '-o', join(folder, 'flight'), '--photos', '6', '--size', '640x480', '--no-world']);
    run(program ?? '', ['stitch', join(folder, 'flight/photos'), '-o', join(folder, 'map'), '--formats', 'pmtiles']);
    const rows = run('sqlite3', [
      '-readonly', join(folder, 'map/mosaic.mbtiles'), 'SELECT zoom_level, tile_column, tile_row, hex(tile_data) FROM tiles',
    ]).trim().split('\n').map((line) => line.split('|'));
    const archive = new PMTiles(fileSource(join(folder, 'map/mosaic.pmtiles')));
    const header = await archive.getHeader();
    assert.equal(header.specVersion, 3);
    assert.equal(header.clustered, true);
    assert.equal(header.numAddressedTiles, rows.length);
    assert.ok(rows.length > 10);
    for (const [zoom, column, row, hex] of rows) {
      const y = 2 ** Number(zoom) - 1 - Number(row);
      const tile = await archive.getZxy(Number(zoom), Number(column), y);
      assert.ok(tile, `${zoom}/${column}/${y}`);
      assert.equal(Buffer.from(tile.data).toString('hex').toUpperCase(), hex);
    }
    assert.equal(await archive.getZxy(header.maxZoom, 0, 0), undefined);
  } finally {
    rmSync(folder, { recursive: true, force: true });
  }
});
