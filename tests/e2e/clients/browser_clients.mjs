// Runs browser_pages.js in headless Chromium, on a page of an origin of its own: node browser_clients.mjs CONFIG.json, with
// {port, web (the folder whose node_modules has playwright-core), chromium, file, out, runs: [{name, client, map}]}. Leaves a
// screenshot NAME.png of what each client drew in `out`, and says {NAME: {answer} or {error, console}}.
import {readFileSync} from 'node:fs';
import {createServer} from 'node:http';
import {createRequire} from 'node:module';
import {fileURLToPath} from 'node:url';
import {build} from 'esbuild';

const config = JSON.parse(readFileSync(process.argv[2], 'utf8'));
const {chromium} = createRequire(`${config.web}/package.json`)('playwright-core');
const bundle = await build({
  entryPoints: [fileURLToPath(new URL('browser_pages.js', import.meta.url))], bundle: true, format: 'iife', write: false, logLevel: 'error',
});
const page_text = `<!doctype html><meta charset="utf-8"><link rel="icon" href="data:,">
<style>body { margin: 0; background: #fff } #map { width: 256px; height: 256px; position: relative; overflow: hidden }
#map canvas { display: block } .leaflet-tile { position: absolute; left: 0; top: 0 }
.leaflet-pane, .leaflet-tile-container { position: absolute; left: 0; top: 0 }
.maplibregl-canvas { position: absolute; left: 0; top: 0 }</style>
<div id="map"></div><script src="/bundle.js"></script>`;
const files = {
  '/': ['text/html', page_text],
  '/bundle.js': ['text/javascript', bundle.outputFiles[0].text],
  '/file': ['image/jpeg', readFileSync(config.file)],
};
const elsewhere = createServer((request, response) => {
  const [type, content] = files[request.url] ?? ['text/plain', ''];
  response.writeHead(request.url in files ? 200 : 404, {'Content-Type': type}).end(content);
});
await new Promise((resolve) => elsewhere.listen(config.port, '127.0.0.1', resolve));
const browser = await chromium.launch({
  executablePath: config.chromium, headless: true,
  args: ['--no-sandbox', '--disable-background-networking', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
});
const told = {};
for (const {name, client, map} of config.runs) {
  const page = await browser.newPage({viewport: {width: 300, height: 300}});
  const said = [];
  page.on('console', (message) => said.push(message.text()));
  await page.goto(`http://127.0.0.1:${config.port}/`);
  const run = page.evaluate(([called, given]) => window.clients[called](given), [client, map]);
  const late = new Promise((_, reject) => setTimeout(() => reject(new Error('it did not end in 90 s')), 90_000).unref());
  try {
    told[name] = {answer: (await Promise.race([run, late])) ?? null};
    await page.screenshot({path: `${config.out}/${name}.png`, clip: {x: 0, y: 0, width: 256, height: 256}});
  } catch (error) {
    told[name] = {error: String(error), console: said};
  }
  await page.close();
}
await browser.close();
elsewhere.close();
console.log(JSON.stringify(told));
