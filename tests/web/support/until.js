import assert from 'node:assert/strict';
import { setTimeout } from 'node:timers/promises';

/** @param {() => boolean|Promise<boolean>} is_so waits for it, at most half a minute @param {string} [failure] */
export async function until(is_so, failure) {
  for (let i = 0; i < 300 && !(await is_so()); i += 1) await setTimeout(100);
  assert.ok(await is_so(), failure);
}
