// Reads the colours of a screenshot, so that a test can tell a map from an empty canvas.

/**
 * @param {any} page
 * @param {{x: number, y: number, width: number, height: number}} clip
 * @returns {Promise<{colours: number, share: (r: number, g: number, b: number, tolerance: number) => number,
 *                    at: (x: number, y: number) => number[]}>}
 */
export async function screenshotPixels(page, clip) {
  const png = await page.screenshot({ clip });
  // The browser itself decodes the picture: no image library is needed here.
  const { width, data } = await page.evaluate(async (/** @type {string} */ base64) => {
    const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
    const bitmap = await createImageBitmap(new Blob([bytes], { type: 'image/png' }));
    const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
    const context = /** @type {OffscreenCanvasRenderingContext2D} */ (canvas.getContext('2d'));
    context.drawImage(bitmap, 0, 0);
    const image = context.getImageData(0, 0, bitmap.width, bitmap.height).data;
    let text = '';
    for (let i = 0; i < image.length; i += 8192) text += String.fromCharCode(...image.subarray(i, i + 8192));
    return { width: bitmap.width, data: btoa(text) };
  }, png.toString('base64'));
  const rgba = Buffer.from(data, 'base64');
  const seen = new Set();
  for (let i = 0; i < rgba.length; i += 4) seen.add((rgba[i] >> 3) * 1024 + (rgba[i + 1] >> 3) * 32 + (rgba[i + 2] >> 3));
  return {
    colours: seen.size,
    share(r, g, b, tolerance) {
      let near = 0;
      for (let i = 0; i < rgba.length; i += 4) {
        if (Math.abs(rgba[i] - r) + Math.abs(rgba[i + 1] - g) + Math.abs(rgba[i + 2] - b) <= tolerance) near += 1;
      }
      return near / (rgba.length / 4);
    },
    at: (x, y) => [...rgba.subarray((y * width + x) * 4, (y * width + x) * 4 + 3)],
  };
}
