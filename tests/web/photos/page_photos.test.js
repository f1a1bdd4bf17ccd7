// Photos over the whole window, in Chromium against the mock server: their order, the strip, north, keyboard.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { embeddedPicture } from '../../../web/src/upload/exif_reader.js';
import { kPhone, openPhotoCard } from '../support/browser.js';
import { assertAccessible, options, usePages } from '../support/pages.js';

const { setUpReady } = usePages();

/** A JPEG's first bytes with a small picture of `bytes` in its second directory. @param {number} bytes @param {number} [told] */
function photoWithPicture(bytes, told = bytes) {
  const tiff = Buffer.alloc(8 + 2 + 4 + 2 + 2 * 12 + 4 + bytes);
  tiff.write('II*\0', 'latin1');
  tiff.writeUInt32LE(8, 4);  // an empty first directory, then the one of the picture
  tiff.writeUInt32LE(14, 10);
  tiff.writeUInt16LE(2, 14);
  [[0x0201, 44], [0x0202, told]].forEach(([tag, value], i) => {
    tiff.writeUInt16LE(tag, 16 + 12 * i);
    tiff.writeUInt16LE(4, 18 + 12 * i);
    tiff.writeUInt32LE(1, 20 + 12 * i);
    tiff.writeUInt32LE(value, 24 + 12 * i);
  });
  tiff.writeUInt16BE(0xffd8, 44);
  const length = Buffer.alloc(2);
  length.writeUInt16BE(tiff.length + 8);
  const photo = Buffer.concat([Buffer.from([0xff, 0xd8, 0xff, 0xe1]), length, Buffer.from('Exif\0\0', 'latin1'), tiff]);
  return photo.buffer.slice(photo.byteOffset, photo.byteOffset + photo.length);
}

test('the small picture in a photo is found, and one that reaches past the bytes is none', async () => {
  const found = embeddedPicture(photoWithPicture(40));
  assert.equal(found?.size, 40);
  assert.deepEqual([...new Uint8Array(await /** @type {Blob} */ (found).arrayBuffer()).slice(0, 2)], [0xff, 0xd8]);
  for (const told of [41, 0, 0xffffffff]) assert.equal(embeddedPicture(photoWithPicture(40, told)), null, String(told));
  for (let cut = 0; cut < 90; cut += 1) assert.equal(embeddedPicture(photoWithPicture(40).slice(0, cut)), null);
});

for (const [screen, context] of Object.entries({ laptop: { viewport: { width: 1440, height: 900 } }, phone: kPhone })) {
  test(`the photos of a place, the most vertical first, are stepped through on a ${screen}`, options, async () => {
    const { page } = await setUpReady('Meadow', {}, context);
    await openPhotoCard(page);
    // On a phone the panel makes room: nothing of the card is cut.
    await page.waitForFunction((is_phone) => document.getElementById('panel')?.classList.contains('sheet-closed') === is_phone, screen === 'phone');
    await page.waitForFunction(() => {
      const card = /** @type {Element} */ (document.getElementById('photo-card'));
      return card.scrollHeight <= card.clientHeight + 1;
    });
    // The server says 21, 3 and 9 degrees.
    assert.match((await page.textContent('#photo-card')) ?? '', /DJI_0004\.JPG.*3° from vertical/);
    await page.click('#photo-open');
    await page.waitForSelector('.viewer-mark:not([hidden])');
    const viewer = await page.locator('#photo-viewer').boundingBox();
    assert.deepEqual([viewer.width, viewer.height], [context.viewport.width, context.viewport.height], 'over the whole window');
    assert.deepEqual(await page.locator('.frame').evaluateAll((all) => all.map((frame) => frame.title)), ['DJI_0004.JPG, 3° from vertical', 'DJI_0005.JPG, 9° from vertical', 'DJI_0003.JPG, 21° from vertical']);
    await page.waitForSelector('.frame-picture img');
    await assertAccessible(page, 'photos');

    const name = () => page.textContent('#photo-viewer .card-title');
    await page.keyboard.press('ArrowRight');
    assert.equal(await name(), 'DJI_0005.JPG');
    await page.keyboard.press('ArrowLeft');
    await page.keyboard.press('ArrowLeft');
    assert.equal(await name(), 'DJI_0003.JPG', 'after the last comes the first');
    await page.click('.frame >> nth=1');
    assert.equal(await name(), 'DJI_0005.JPG');
    await page.waitForSelector('.viewer-mark:not([hidden])');

    // What was under the mark stays there when the photo is turned, and when it is zoomed.
    const markAt = () => page.evaluate(() => {
      const box = /** @type {Element} */ (document.querySelector('.viewer-mark')).getBoundingClientRect();
      return [box.x, box.y];
    });
    const turn = () => page.evaluate(() => new DOMMatrix(getComputedStyle(/** @type {Element} */ (document.querySelector('.viewer-image'))).transform));
    const before = await markAt();
    assert.ok(Math.abs((await turn()).b) < 1e-6);
    await page.click('#viewer-north');
    assert.equal(await page.getAttribute('#viewer-north', 'aria-pressed'), 'true');
    const { a, b } = await turn();
    // It was flown with yaw 90: the top of the photo, east, points to the right.
    assert.ok(b > 0 && Math.abs(a) < 1e-6, `${a} ${b}`);
    await page.keyboard.press('+');
    const after = await markAt();
    before.forEach((value, i) => assert.ok(Math.abs(value - after[i]) < 1, `${before} ${after}`));
    await page.keyboard.press('Shift+ArrowRight');
    assert.ok((await markAt())[0] < after[0] - 70);
    await page.keyboard.press('Escape');
    await page.waitForSelector('#photo-viewer', { state: 'detached' });
    assert.match((await page.textContent('#photo-card .card-title')) ?? '', /DJI_0005/, 'the card shows the one that was looked at');
    assert.equal(await page.evaluate(() => document.activeElement?.id), 'photo-open', 'the keyboard goes on there');
  });
}
