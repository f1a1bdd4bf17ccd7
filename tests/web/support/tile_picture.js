// Pictures of a made-up countryside as map tiles, so that the page has something real to draw: fields, tracks and a
// pond, fixed to the ground (not to the tile), transparent outside a slightly turned rectangle.
import * as zlib from 'node:zlib';

const table = new Uint32Array(256).map((_, n) => {
  let c = n;
  for (let k = 0; k < 8; k += 1) c = c & 1 ? 0xedb88320 ^ (c >>> 1) : c >>> 1;
  return c >>> 0;
});

/** @param {Uint8Array} bytes */
function crc32(bytes) {
  if (zlib.crc32) return zlib.crc32(bytes);  // not in Node 18
  let c = 0xffffffff;
  for (const byte of bytes) c = table[(c ^ byte) & 0xff] ^ (c >>> 8);
  return (c ^ 0xffffffff) >>> 0;
}

/** @param {string} type @param {Uint8Array} data */
function chunk(type, data) {
  const head = Buffer.alloc(8);
  head.writeUInt32BE(data.length, 0);
  head.write(type, 4, 'latin1');
  const tail = Buffer.alloc(4);
  tail.writeUInt32BE(crc32(Buffer.concat([head.subarray(4), data])), 0);
  return Buffer.concat([head, data, tail]);
}

/**
 * @param {number} width
 * @param {number} height
 * @param {Uint8Array} rgba
 * @returns {Buffer} PNG
 */
export function encodePng(width, height, rgba) {
  const header = Buffer.alloc(13);
  header.writeUInt32BE(width, 0);
  header.writeUInt32BE(height, 4);
  header.set([8, 6, 0, 0, 0], 8);
  const rows = Buffer.alloc((width * 4 + 1) * height);
  for (let y = 0; y < height; y += 1) rows.set(rgba.subarray(y * width * 4, (y + 1) * width * 4), y * (width * 4 + 1) + 1);
  return Buffer.concat([
    Buffer.from([0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a]),
    chunk('IHDR', header),
    chunk('IDAT', zlib.deflateSync(rows, { level: 1 })),
    chunk('IEND', Buffer.alloc(0)),
  ]);
}

/** A repeatable number in 0..1 for a cell. */
function chance(x, y, seed) {
  let n = (Math.imul(x, 374761393) + Math.imul(y, 668265263) + Math.imul(seed, 974711)) | 0;
  n = Math.imul(n ^ (n >>> 13), 1274126177);
  return ((n ^ (n >>> 16)) >>> 0) / 4294967296;
}

const crops = [[150, 160, 84], [112, 138, 70], [186, 170, 106], [98, 122, 66], [168, 142, 92], [132, 152, 96]];

/**
 * Colour of the ground at a place in metres from the middle of the flight.
 * @returns {[number, number, number]|null} null outside the mosaic
 */
function ground(east_m, north_m, half_m, season) {
  const angle = 0.14;
  const u = east_m * Math.cos(angle) + north_m * Math.sin(angle);
  const v = -east_m * Math.sin(angle) + north_m * Math.cos(angle);
  const ragged = 4 * Math.sin(u / 9) + 3 * Math.sin(v / 7 + 1);
  if (Math.abs(u) > half_m * 0.9 + ragged || Math.abs(v) > half_m * 0.62 + ragged) return null;
  const grain = (chance(Math.floor(east_m * 4), Math.floor(north_m * 4), 5) - 0.5) * 18;
  const bend = 6 * Math.sin(u / 30);
  if (Math.abs(v - bend - 4) < 2.6) return [178 + grain, 168 + grain, 150 + grain];
  if (Math.hypot((u - half_m * 0.45) / 1.6, v + half_m * 0.25) < 15) return [62 + grain / 3, 96 + grain / 3, 104 + grain / 3];
  const column = Math.floor((u + bend) / 34);
  const row = Math.floor(v / 26);
  const edge = Math.min(Math.abs(((u + bend) / 34) % 1), Math.abs((v / 26) % 1));
  const [r, g, b] = edge < 0.025 ? [66, 86, 50] : crops[Math.floor(chance(column, row, 11 + season) * crops.length)];
  const furrow = (chance(column, row, 3) > 0.5 ? Math.sin(u * 2.2) : Math.sin(v * 2.2)) * 7;
  return [r + grain + furrow, g + grain + furrow, b + grain + furrow];
}

/** Cases ask for the same places. @type {Map<string, Buffer>} */
const drawn = new Map();
/** @param {unknown} key @param {() => Buffer} draw */
function once(key, draw) {
  const text = JSON.stringify(key);
  const known = drawn.get(text) ?? draw();
  drawn.set(text, known);
  return known;
}

/**
 * @param {{lon: number, lat: number, half_m: number, season: number}} place
 * @param {number} z
 * @param {number} x
 * @param {number} y
 * @returns {Buffer} PNG, 256 x 256
 */
export const countrysideTile = (place, z, x, y) => once([place, z, x, y], () => drawTile(place, z, x, y));

/** @param {{lon: number, lat: number, half_m: number, season: number}} place @param {number} z @param {number} x @param {number} y */
function drawTile(place, z, x, y) {
  const size = 256;
  const rgba = new Uint8Array(size * size * 4);
  const metres = 40075016.686 * Math.cos((place.lat * Math.PI) / 180);
  const n = 2 ** z;
  const centre_x = (place.lon + 180) / 360;
  const centre_y = 0.5 - Math.atanh(Math.sin((place.lat * Math.PI) / 180)) / (2 * Math.PI);
  for (let py = 0; py < size; py += 1) {
    for (let px = 0; px < size; px += 1) {
      const east_m = ((x + (px + 0.5) / size) / n - centre_x) * metres;
      const north_m = (centre_y - (y + (py + 0.5) / size) / n) * metres;
      const colour = ground(east_m, north_m, place.half_m, place.season);
      if (!colour) continue;
      rgba.set([...colour.map((c) => Math.max(0, Math.min(255, c))), 255], (py * size + px) * 4);
    }
  }
  return encodePng(size, size, rgba);
}

/**
 * @param {{half_m: number, season: number}} place
 * @param {number} [width] of the picture
 * @returns {Buffer} PNG of the whole map, small
 */
export const countrysidePicture = ({ half_m, season }, width = 160) => once([half_m, season, width], () => drawPicture(half_m, season, width));

/** @param {number} half_m @param {number} season @param {number} width */
function drawPicture(half_m, season, width) {
  const height = 0.8 * width;
  const rgba = new Uint8Array(width * height * 4);
  for (let y = 0; y < height; y += 1) {
    for (let x = 0; x < width; x += 1) {
      const colour = ground(((x + 0.5) / width - 0.5) * 2 * half_m, (0.5 - (y + 0.5) / height) * 1.6 * half_m, half_m, season);
      if (colour) rgba.set([...colour.map((c) => Math.max(0, Math.min(255, c))), 255], (y * width + x) * 4);
    }
  }
  return encodePng(width, height, rgba);
}
