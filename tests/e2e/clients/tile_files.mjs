// Reads a tile by a library: node tile_files.mjs pmtiles|mbtiles SOURCE ZOOM COLUMN ROW, where SOURCE is an address of a PMTiles
// file or the path of an MBTiles file. Says {sha256, min_zoom, max_zoom}.
import {createHash} from 'node:crypto';

const [reader, source, ...numbers] = process.argv.slice(2);
const [zoom, column, row] = numbers.map(Number);

async function fromPmtiles() {
  const {PMTiles} = await import('pmtiles');
  const archive = new PMTiles(source);
  const {minZoom, maxZoom} = await archive.getHeader();
  return {bytes: Buffer.from((await archive.getZxy(zoom, column, row)).data), min_zoom: minZoom, max_zoom: maxZoom};
}

async function fromMbtiles() {
  const {default: MBTiles} = await import('@mapbox/mbtiles');
  const file = await new Promise((resolve, reject) => {
    new MBTiles(`${source}?mode=ro`, (error, opened) => (error ? reject(error) : resolve(opened)));
  });
  const answer = (ask) => new Promise((resolve, reject) => ask((error, value) => (error ? reject(error) : resolve(value))));
  const {minzoom, maxzoom} = await answer((done) => file.getInfo(done));
  return {bytes: await answer((done) => file.getTile(zoom, column, row, done)), min_zoom: minzoom, max_zoom: maxzoom};
}

const {bytes, ...zooms} = await (reader === 'pmtiles' ? fromPmtiles() : fromMbtiles());
console.log(JSON.stringify({sha256: createHash('sha256').update(bytes).digest('hex'), ...zooms}));
