// Which photo shows a place best. Pure.
/** @import { Sighting } from '../shared/types.js' */

// Photos whose qualities differ by less than this are as good as each other; then the better placed is.
const kSameQuality = 0.02;

/**
 * The share of the fine detail that a sharp photo from straight above shows of the place: what the server says, or by
 * the angle alone where it does not say how sharp the photo is.
 * @param {Sighting} sighting
 */
const qualityOf = ({ quality, off_nadir_deg = 0 }) => quality ?? Math.cos((off_nadir_deg * Math.PI) / 180) ** 2;

/**
 * Aligned photos first, then the sharpest and most vertical views, then those that are placed best.
 * @param {Sighting} a
 * @param {Sighting} b
 */
export function byQuality(a, b) {
  const rank = (/** @type {Sighting} */ { placement }) => (placement === 'pose_only' ? 1 : 0);
  const step = (/** @type {Sighting} */ sighting) => Math.floor(qualityOf(sighting) / kSameQuality);
  return rank(a) - rank(b) || step(b) - step(a) || (a.sigma_m ?? 0) - (b.sigma_m ?? 0);
}
