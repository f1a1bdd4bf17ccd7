// The real server for tests and the gallery, and photos to give it.
import { spawn } from 'node:child_process';
import { existsSync, readdirSync } from 'node:fs';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';

export const binary = process.env.SKYQUILT_BINARY ?? fileURLToPath(new URL('../../../build/release/bin/skyquilt', import.meta.url));
export const missingBinary = () => (existsSync(binary) ? '' : `no program at ${binary}`);

/** @param {string} root @returns {string[]} */
export function findPhotos(root) {
  return readdirSync(root, { withFileTypes: true })
    .flatMap((entry) => (entry.isDirectory() ? findPhotos(join(root, entry.name)) : [join(root, entry.name)]))
    .filter((path) => /\.jpe?g$/i.test(path))
    .sort();
}

/** @param {string} name of a set of real photos @returns {string[]} empty where there are none */
export function realPhotos(name) {
  const data = process.env.SKYQUILT_DATA ?? fileURLToPath(new URL('../../../../shared/data', import.meta.url));
  const folder = join(data, name);
  return existsSync(folder) ? findPhotos(folder) : [];
}

/**
 * Starts the server and waits for the line that tells its address.
 * @param {string} data
 * @param {string} [listen]
 * @param {string[]} [options]
 */
export async function startServer(data, listen = '127.0.0.1:0', options = []) {
  const child = spawn(binary, ['serve', '--data', data, '--listen', listen, ...options], { stdio: ['ignore', 'pipe', 'pipe'] });
  let output = '';
  /** @type {string} */
  const url = await new Promise((resolve, reject) => {
    const read = (/** @type {Buffer} */ chunk) => {
      output += chunk;
      const match = output.match(/serving at (http:\/\/127\.0\.0\.1:\d+\/(?:\w+\/)?)/);
      if (match) resolve(match[1]);
    };
    child.stdout.on('data', read);
    child.stderr.on('data', read);
    child.on('exit', (code) => reject(new Error(`the server ended with ${code}: ${output}`)));
  });
  const stop = (signal = 'SIGTERM') =>
    new Promise((resolve) => {
      if (child.exitCode !== null || child.signalCode !== null) {
        resolve(child.exitCode);  // a test that failed between two servers has none to stop
        return;
      }
      child.removeAllListeners('exit');
      child.on('exit', (code) => resolve(code));
      child.kill(/** @type {any} */ (signal));
    });
  return { url, stop };
}
