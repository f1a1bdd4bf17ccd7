// Runs files of tests in one process, and so in one Chromium, which is most of what a short case costs by itself:
// node --test-name-pattern=^NAME... in_one.js FILE...
// A name that no case has any longer fails: it would go from the suite unnoticed.
import { beforeEach } from 'node:test';
import { resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { missingForBrowser } from './browser.js';

const names = process.execArgv.flatMap((argument) => argument.match(/^--test-name-pattern=(.*)$/)?.slice(1) ?? []);
/** @type {Set<string>} */
const begun = new Set();
beforeEach((/** @type {any} */ { name }) => begun.add(name));
for (const file of process.argv.slice(2)) await import(pathToFileURL(resolve(file)).href);

process.on('exit', () => {
  const lost = names.filter((name) => ![...begun].some((one) => new RegExp(name).test(one)));
  if (lost.length === 0 || missingForBrowser()) return;
  console.error(`no case was run for ${lost.join(', ')}`);
  process.exitCode = 1;
});
