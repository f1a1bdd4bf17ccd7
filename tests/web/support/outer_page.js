// A page of another site with something of ours in a frame: by the name localhost, which is no site of 127.0.0.1.
import { createServer } from 'node:http';

/** @param {string} markup in its body */
export async function startOuterPage(markup) {
  const server = createServer((_, response) => {
    response.writeHead(200, { 'Content-Type': 'text/html; charset=utf-8' });
    response.end(`<!DOCTYPE html><html lang="en"><head><title>Outer</title><link rel="icon" href="data:,"></head><body><h1>Outer</h1>${markup}<p style="height:3000px"></p></body></html>`);
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', () => resolve(undefined)));
  return {
    url: `http://localhost:${/** @type {any} */ (server.address()).port}/`,
    close: () => {
      server.closeAllConnections();
      return new Promise((resolve) => server.close(() => resolve(undefined)));
    },
  };
}

/** @param {any} page @returns {Promise<any>} what its frame shows */
export async function frameOn(page) {
  await page.locator('iframe').scrollIntoViewIfNeeded();
  return (await page.waitForSelector('iframe')).contentFrame();
}
