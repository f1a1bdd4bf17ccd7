// The page's sources: types, markup, and no address of another host.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { existsSync, readdirSync, readFileSync } from 'node:fs';
import { join, posix } from 'node:path';
import { test } from 'node:test';
import { web_root } from './support/mock_server.js';

const options = { skip: existsSync(join(web_root, 'node_modules')) ? false : 'web/node_modules is missing (npm ci in web/)', timeout: 120_000 };
const run = (/** @type {string} */ script, /** @type {string[]} */ ...args) =>
  spawnSync(process.execPath, [join(web_root, 'node_modules', script), ...args], { cwd: web_root, encoding: 'utf8' });

test('the types agree', options, () => {
  // What it found is kept: of sources that stayed as they are it says the same in a third of the time.
  const result = run('typescript/bin/tsc', '--noEmit', '-p', 'jsconfig.json', '--incremental', '--tsBuildInfoFile', 'node_modules/.cache/types.tsbuildinfo');
  assert.equal(result.status, 0, result.stdout);
});

test('the markup is valid', options, () => {
  const result = run('html-validate/bin/html-validate.mjs', 'index.html', 'embed.html');
  assert.equal(result.status, 0, result.stdout + result.stderr);
});

/** @param {string} folder @returns {string[]} its files and those of the folders in it */
const filesBelow = (folder) =>
    readdirSync(join(web_root, folder), {withFileTypes: true})
        .flatMap(
            (entry) =>
                (entry.isDirectory() ? filesBelow(join(folder, entry.name)) : [join(folder, entry.name)]));

test('nothing in the page names another host', () => {
  const files = ['index.html', 'embed.html', 'style.css', ...['src', 'styles'].flatMap((f) => filesBelow(f))];
  for (const file of files) {
    const text = readFileSync(join(web_root, file), 'utf8').replace(/http:\/\/www\.(w3\.org\/2000\/svg|opengis\.net\/kml\/2\.2|topografix\.com\/GPX\/1\/1)/g, '');
    assert.doesNotMatch(text, /https?:\/\/[a-z]/i, file);
  }
});

test('no script or style is inline, so that a strict content policy holds', () => {
  for (const file of ['index.html', 'embed.html']) {
    assert.doesNotMatch(readFileSync(join(web_root, file), 'utf8'), /<style|style=|\son[a-z]+=|<script(?![^>]*src=)/i, file);
  }
});

test('the page names every module that it starts with, so that none waits for another to be read', () => {
  const importsOf = (/** @type {string} */ path) => {
    const code = readFileSync(join(web_root, path), 'utf8').replace(/\/\*[^]*?\*\//g, '');
    return [...code.matchAll(/^(?:import|export)\s[^;]*?from '([^']+)'/gm)].map((match) => posix.join(posix.dirname(path), match[1]));
  };
  const neededBy = (/** @type {string} */ start) => {
    const needed = new Set(importsOf(start));
    for (const path of needed) if (path.startsWith('src/')) for (const next of importsOf(path)) needed.add(next);
    return needed;
  };
  const namedIn = (/** @type {string} */ html) => [...html.matchAll(/rel="modulepreload" href="([^"]+)"/g)].map((match) => match[1]);
  const [at_once, later, of_map] = readFileSync(join(web_root, 'index.html'), 'utf8').split(/<template id="(?:open|map)-parts">/);
  // What the first script needs comes first.
  const inOrder = (/** @type {string} */ earliest, /** @type {string} */ then) => {
    const first = neededBy(earliest);
    return [...[...first].sort(), ...[...neededBy(then)].filter((path) => !first.has(path)).sort()];
  };
  assert.deepEqual(namedIn(at_once), inOrder('src/first_view/first_view.js', 'src/main.js'));
  const first = new Set(namedIn(at_once));
  const opening = neededBy('src/open_parts.js').add('src/open_parts.js');
  assert.deepEqual(namedIn(later), [...opening].filter((path) => !first.has(path)).sort());
  const drawing = neededBy('src/map/map_view.js').add('src/map/map_view.js');
  assert.deepEqual(namedIn(of_map), [...drawing].filter((path) => !first.has(path) && !opening.has(path)).sort());
  // The bare map lies one folder deeper.
  assert.deepEqual(namedIn(readFileSync(join(web_root, 'embed.html'), 'utf8')), inOrder('src/first_view/first_embed.js', 'src/embed/embed.js').map((path) => `../${path}`));
});

test('the lockfile names no registry', () => {
  assert.doesNotMatch(readFileSync(join(web_root, 'package-lock.json'), 'utf8'), /"resolved"|https?:\/\/[^"]*registry/);
});
