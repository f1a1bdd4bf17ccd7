// What this page may do on its server, by the token that it shows. Asked once; what would be refused is not offered.
/** @import { Access } from './types.js' */
import { getAccess } from './api.js';

/** @type {Promise<Access|null>|null} */
let asked = null;

/** @returns {Promise<Access|null>} null where the server does not say: then everything is offered, and it decides */
export function ownAccess() {
  asked ??= getAccess().catch(() => {
    asked = null;  // the next who asks tries again
    return null;
  });
  return asked;
}

/** @returns {Promise<boolean>} whether flights can be added */
export async function mayUpload() {
  const access = await ownAccess();
  return access === null || access.scope !== 'read';
}
