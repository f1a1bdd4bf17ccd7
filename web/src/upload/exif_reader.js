// Reads what a verdict before the upload needs from a photo's first bytes: where and when it was taken, by
// which camera. JPEG and TIFF (EXIF 2.3). Anything odd is simply absent: the server reads the photos properly.

/**
 * @typedef {object} PhotoGlance
 * @property {number|null} lon_deg
 * @property {number|null} lat_deg
 * @property {number|null} taken_s seconds on the camera's own clock
 * @property {string} camera
 */

export const kHeadBytes = 128 * 1024;

const kWidths = [0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8];

/**
 * Where the TIFF structure of a photo begins.
 * @param {DataView} view
 * @returns {number} -1 when there is none
 */
function tiffStart(view) {
  if (view.byteLength < 12) return -1;
  const magic = view.getUint32(0);
  if (magic === 0x49492a00 || magic === 0x4d4d002a) return 0;
  if (view.getUint16(0) !== 0xffd8) return -1;
  for (let at = 2; at + 10 <= view.byteLength; ) {
    if (view.getUint8(at) !== 0xff) return -1;
    const marker = view.getUint8(at + 1);
    if (marker === 0xff) {
      at += 1;
      continue;
    }
    if (marker === 0xda || marker === 0xd9) return -1;
    const length = view.getUint16(at + 2);
    const is_exif = marker === 0xe1 && length >= 16 && view.getUint32(at + 4) === 0x45786966 && view.getUint16(at + 8) === 0;
    if (is_exif) return at + 10;
    at += 2 + length;
  }
  return -1;
}

/** One directory of tags; every read is checked against the bytes there are. */
class Directory {
  /** @type {Map<number, {type: number, count: number, at: number}>} */
  tags = new Map();
  next = 0;  // offset of the directory after it, from base; 0 for none

  /**
   * @param {DataView} view
   * @param {number} base start of the TIFF structure
   * @param {number} offset of the directory, from base
   * @param {boolean} little
   */
  constructor(view, base, offset, little) {
    this.view = view;
    this.base = base;
    this.little = little;
    const start = base + offset;
    if (offset < 8 || start + 2 > view.byteLength) return;
    const count = view.getUint16(start, little);
    const next_at = start + 2 + count * 12;
    if (next_at + 4 <= view.byteLength) this.next = view.getUint32(next_at, little);
    for (let i = 0; i < count; i += 1) {
      const at = start + 2 + i * 12;
      if (at + 12 > view.byteLength) return;
      const type = view.getUint16(at + 2, little);
      const values = view.getUint32(at + 4, little);
      const bytes = (kWidths[type] ?? 0) * values;
      const value_at = bytes > 4 ? base + view.getUint32(at + 8, little) : at + 8;
      if (bytes === 0 || value_at + bytes > view.byteLength) continue;
      this.tags.set(view.getUint16(at, little), { type, count: values, at: value_at });
    }
  }

  /** @param {number} tag @returns {number[]} */
  numbers(tag) {
    const entry = this.tags.get(tag);
    if (!entry || entry.count > 16) return [];
    return Array.from({ length: entry.count }, (_, i) => {
      const at = entry.at + i * kWidths[entry.type];
      switch (entry.type) {
        case 1:
          return this.view.getUint8(at);
        case 3:
          return this.view.getUint16(at, this.little);
        case 4:
          return this.view.getUint32(at, this.little);
        case 5:
          return this.view.getUint32(at, this.little) / this.view.getUint32(at + 4, this.little);
        case 10:
          return this.view.getInt32(at, this.little) / this.view.getInt32(at + 4, this.little);
        default:
          return NaN;
      }
    });
  }

  /** @param {number} tag @returns {string} */
  text(tag) {
    const entry = this.tags.get(tag);
    if (!entry || entry.type !== 2) return '';
    const bytes = new Uint8Array(this.view.buffer, this.view.byteOffset + entry.at, Math.min(entry.count, 64));
    return String.fromCharCode(...bytes).split('\0')[0].trim();
  }
}

/**
 * @param {number[]} parts degrees, minutes, seconds
 * @param {string} reference
 * @param {number} limit
 * @returns {number|null}
 */
function degrees(parts, reference, limit) {
  if (parts.length < 1 || !reference) return null;
  const value = parts[0] + (parts[1] || 0) / 60 + (parts[2] || 0) / 3600;
  if (!Number.isFinite(value) || value > limit) return null;
  return /^[SsWw]/.test(reference) ? -value : value;
}

/**
 * @param {string} text 'YYYY:MM:DD HH:MM:SS'
 * @returns {number|null}
 */
function cameraSeconds(text) {
  const match = text.match(/^(\d{4})\D(\d\d)\D(\d\d)\D(\d\d)\D(\d\d)\D(\d\d)/);
  if (!match) return null;
  const [year, month, day, hour, minute, second] = match.slice(1).map(Number);
  const time = Date.UTC(year, month - 1, day, hour, minute, second) / 1000;
  return year > 1990 && Number.isFinite(time) ? time : null;
}

/**
 * @param {ArrayBuffer} head the first bytes of a photo
 * @returns {PhotoGlance}
 */
export function glanceAtPhoto(head) {
  const view = new DataView(head);
  /** @type {PhotoGlance} */
  const glance = { lon_deg: null, lat_deg: null, taken_s: null, camera: '' };
  const base = tiffStart(view);
  if (base < 0 || base + 8 > view.byteLength) return glance;
  const little = view.getUint16(base) === 0x4949;
  const main = new Directory(view, base, view.getUint32(base + 4, little), little);
  glance.camera = main.text(0x0110);
  const [exif_at] = main.numbers(0x8769);
  const [gps_at] = main.numbers(0x8825);
  if (exif_at) {
    const exif = new Directory(view, base, exif_at, little);
    glance.taken_s = cameraSeconds(exif.text(0x9003));
  }
  if (gps_at) {
    const gps = new Directory(view, base, gps_at, little);
    const lat = degrees(gps.numbers(2), gps.text(1), 90);
    const lon = degrees(gps.numbers(4), gps.text(3), 180);
    // A receiver without a fix writes zeros: that is no place.
    if (lat !== null && lon !== null && (Math.abs(lat) > 1e-6 || Math.abs(lon) > 1e-6)) {
      glance.lat_deg = lat;
      glance.lon_deg = lon;
    }
  }
  return glance;
}

/**
 * The small picture that cameras write beside the EXIF.
 * @param {ArrayBuffer} head the first bytes of a photo
 * @returns {Blob|null} JPEG; null where there is none in these bytes
 */
export function embeddedPicture(head) {
  const view = new DataView(head);
  const base = tiffStart(view);
  if (base < 0 || base + 8 > view.byteLength) return null;
  const little = view.getUint16(base) === 0x4949;
  const { next } = new Directory(view, base, view.getUint32(base + 4, little), little);
  const small = new Directory(view, base, next, little);
  const [at] = small.numbers(0x0201);
  const [bytes] = small.numbers(0x0202);
  if (!(at > 0 && bytes > 3) || base + at + bytes > view.byteLength || view.getUint16(base + at) !== 0xffd8) return null;
  return new Blob([head.slice(base + at, base + at + bytes)], { type: 'image/jpeg' });
}
