// Asks before a map is made far coarser than its photos: metres that were typed for centimetres, say. The server refuses
// it otherwise, with the same two numbers (MosaicOptions::CheckGsd).
/** @import { JobOptions } from './job_options.js' */
import { getFlight, getVerdict } from '../shared/api.js';
import { choose } from '../shared/dialogs.js';
import { formatGsd } from '../shared/format.js';
import { strings } from '../shared/flight_strings.js';
import { timesCoarser } from './job_options.js';

/** Where nothing foretells how fine the photos are: no field is mapped so coarse by a centimetre's slip. */
const kCoarse_m = 1;
/** So near to what is asked about, the photos' resolution by what they show may lie beyond it where that by records does not. */
const kTimesNear = 15;

/**
 * @param {string} flight_id
 * @param {JobOptions} options
 * @param {{photos_gsd_m?: number, signal?: AbortSignal}} [known] photos_gsd_m: by a verdict that is at hand; signal: nobody
 *   waits for it any more
 * @returns {Promise<JobOptions|null>} what was asked here, the server does not refuse; null: so coarse a map is not meant
 */
export async function confirmCoarse(flight_id, options, { photos_gsd_m, signal } = {}) {
  if (options.gsd_m === undefined || options.any_gsd) return options;
  const photos_m = photos_gsd_m ?? (await getVerdict(flight_id).catch((error) => console.debug('no verdict', error)))?.gsd_m ?? 0;
  if (signal?.aborted) return null;
  const meant = { ...options, any_gsd: true };
  const times = timesCoarser(options, photos_m);
  if (times === null && photos_m > 0) return options.gsd_m > kTimesNear * photos_m ? meant : options;
  if (times === null && options.gsd_m < kCoarse_m) return meant;
  // Several uploads may end while nobody looks at their flights.
  const name = (await getFlight(flight_id, signal).catch((error) => console.debug('no flight', error)))?.name;
  if (signal?.aborted) return null;
  const words = strings.options;
  const text = times === null ? words.coarse_unknown(formatGsd(options.gsd_m)) : words.coarse_text(formatGsd(options.gsd_m), formatGsd(photos_m), times);
  const chosen = await choose('coarse-dialog', words.coarse_title(name ?? flight_id), text, [
    { value: '', label: words.coarse_no, id: 'coarse-no', is_primary: true },
    { value: 'yes', label: words.coarse_yes, id: 'coarse-yes' },
  ]);
  return chosen === 'yes' ? meant : null;
}
