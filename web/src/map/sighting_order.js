// Which photo shows a place best. Pure.
/** @import { Sighting } from '../shared/types.js' */

// Views that differ by less than this are as good as each other; then the better placed is.
const kSameView_deg = 4;

/**
 * Aligned photos first, then the most vertical views, then those that are placed best.
 * @param {Sighting} a
 * @param {Sighting} b
 */
export function byQuality(a, b) {
  const rank = (/** @type {Sighting} */ { placement }) => (placement === 'pose_only' ? 1 : 0);
  const view = (/** @type {Sighting} */ { off_nadir_deg = 0 }) => Math.floor(off_nadir_deg / kSameView_deg);
  return rank(a) - rank(b) || view(a) - view(b) || (a.sigma_m ?? 0) - (b.sigma_m ?? 0);
}
