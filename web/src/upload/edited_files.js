// A list, a log or a sidecar counts by what is in it, and may have been edited since it was sent: under a name that is taken
// in the flight it is either what lies there, or has a name of its own, so that it can be told that both count.
import { ApiError, getFile } from '../shared/api.js';

const kMaxRead_bytes = 32 << 20;  // larger ones are known by name and size, as photos are

/** @param {string} flight_id @param {string} name @param {File|Blob} file @param {AbortSignal} signal */
async function isStored(flight_id, name, file, signal) {
  if (file.size > kMaxRead_bytes) return true;
  const stored = await getFile(flight_id, name, signal).catch((error) => {
    if (error instanceof ApiError && error.status === 404) return new ArrayBuffer(0);  // its bytes are lost there
    throw error;
  });
  const [here, there] = [await file.arrayBuffer(), stored].map((bytes) => new Uint8Array(bytes));
  return here.length === there.length && here.every((byte, i) => byte === there[i]);
}

/**
 * @param {string} flight_id
 * @param {{name: string, file: File|Blob}} one
 * @param {Map<string, number>} there name to size of what the flight has
 * @param {AbortSignal} signal
 * @returns {Promise<{name: string, is_there: boolean}>} name: in the flight
 */
export async function toldApart(flight_id, { name, file }, there, signal) {
  if (!there.has(name)) return { name, is_there: false };
  const dot = name.lastIndexOf('.') > 0 ? name.lastIndexOf('.') : name.length;
  const [stem, ending] = [name.slice(0, dot), name.slice(dot)];
  for (const [other, bytes] of there) {
    const may_be_it = bytes === file.size && (other === name || (other.startsWith(`${stem}(`) && other.endsWith(`)${ending}`)));
    if (may_be_it && (await isStored(flight_id, other, file, signal))) return { name: other, is_there: true };
  }
  let number = 2;
  while (there.has(`${stem}(${number})${ending}`)) number += 1;
  return { name: `${stem}(${number})${ending}`, is_there: false };
}
