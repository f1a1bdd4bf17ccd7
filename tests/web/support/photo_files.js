// Files as a drone's camera saves them, as far as the page looks: a JPEG's first bytes with EXIF position, time and
// camera, and then whatever.

/**
 * One TIFF directory, little endian, with its values behind it.
 * @param {number} at offset of the directory
 * @param {[number, number, number, Buffer][]} entries tag, type, count, value
 */
function directory(at, entries) {
  const head = Buffer.alloc(2 + entries.length * 12 + 4);
  const values = [];
  let value_at = at + head.length;
  head.writeUInt16LE(entries.length, 0);
  entries.forEach(([tag, type, count, value], i) => {
    const o = 2 + i * 12;
    head.writeUInt16LE(tag, o);
    head.writeUInt16LE(type, o + 2);
    head.writeUInt32LE(count, o + 4);
    if (value.length <= 4) value.copy(head, o + 8);
    else {
      head.writeUInt32LE(value_at, o + 8);
      values.push(value);
      value_at += value.length;
    }
  });
  return Buffer.concat([head, ...values]);
}

const text = (/** @type {string} */ s) => Buffer.from(`${s}\0`, 'latin1');
const long = (/** @type {number} */ n) => {
  const bytes = Buffer.alloc(4);
  bytes.writeUInt32LE(n);
  return bytes;
};
const degrees = (/** @type {number} */ value) => Buffer.concat([long(Math.round(Math.abs(value) * 1e7)), long(1e7), long(0), long(1), long(0), long(1)]);

/** @param {number} lon @param {number} lat @param {string} taken 'YYYY:MM:DD HH:MM:SS' */
function exifSegment(lon, lat, taken) {
  const ascii = (/** @type {number} */ tag, /** @type {string} */ s) => /** @type {[number, number, number, Buffer]} */ ([tag, 2, s.length + 1, text(s)]);
  const gps = (/** @type {number} */ at) => directory(at, [ascii(1, lat < 0 ? 'S' : 'N'), [2, 5, 3, degrees(lat)], ascii(3, lon < 0 ? 'W' : 'E'), [4, 5, 3, degrees(lon)]]);
  const exif = (/** @type {number} */ at) => directory(at, [ascii(0x9003, taken)]);
  const main = (/** @type {number} */ exif_at, /** @type {number} */ gps_at) => directory(8, [ascii(0x0110, 'FC300S'), [0x8769, 4, 1, long(exif_at)], [0x8825, 4, 1, long(gps_at)]]);
  const exif_at = 8 + main(0, 0).length;
  const gps_at = exif_at + exif(exif_at).length;
  const tiff = Buffer.concat([Buffer.from('II*\0\x08\0\0\0', 'latin1'), main(exif_at, gps_at), exif(exif_at), gps(gps_at)]);
  const length = Buffer.alloc(2);
  length.writeUInt16BE(tiff.length + 8);
  return Buffer.concat([Buffer.from([0xff, 0xe1]), length, Buffer.from('Exif\0\0', 'latin1'), tiff]);
}

/**
 * @param {number} count
 * @param {number} [bytes]
 * @returns {{name: string, mimeType: string, buffer: Buffer}[]}
 */
export function photoFiles(count, bytes = 20_000) {
  return Array.from({ length: count }, (_, i) => {
    const seconds = 3 * i;
    const taken = `2026:05:12 09:${String(31 + Math.floor(seconds / 60)).padStart(2, '0')}:${String(seconds % 60).padStart(2, '0')}`;
    const exif = exifSegment(7.4384 + (i % 6) * 0.0003, 46.9508 + Math.floor(i / 6) * 0.0003, taken);
    return {
      name: `DJI_${String(i + 1).padStart(4, '0')}.JPG`,
      mimeType: 'image/jpeg',
      buffer: Buffer.concat([Buffer.from([0xff, 0xd8]), exif, Buffer.from([0xff, 0xda]), Buffer.alloc(bytes + i, i + 1)]),
    };
  });
}
