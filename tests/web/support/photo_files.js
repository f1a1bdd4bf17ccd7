// Files as a camera would save them, for the page's pickers: the first bytes of a JPEG and then whatever.

/**
 * @param {number} count
 * @param {number} [bytes]
 * @returns {{name: string, mimeType: string, buffer: Buffer}[]}
 */
export function photoFiles(count, bytes = 20_000) {
  return Array.from({ length: count }, (_, i) => ({
    name: `DJI_${String(i + 1).padStart(4, '0')}.JPG`,
    mimeType: 'image/jpeg',
    buffer: Buffer.concat([Buffer.from([0xff, 0xd8, 0xff, 0xe1]), Buffer.alloc(bytes + i, i + 1)]),
  }));
}
