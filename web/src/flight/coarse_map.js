// Asks before a map is made far coarser than its photos: metres that were typed for centimetres, say. The server refuses
// it otherwise, with the same two numbers (MosaicOptions::CheckGsd).
/** @import { JobOptions } from './job_options.js' */
import { getVerdict } from '../shared/api.js';
import { ask } from '../shared/dialogs.js';
import { h } from '../shared/dom.js';
import { formatGsd } from '../shared/format.js';
import { strings } from '../shared/flight_strings.js';
import { timesCoarser } from './job_options.js';

/**
 * @param {string} flight_id
 * @param {JobOptions} options
 * @returns {Promise<JobOptions|null>} with the answer where one was needed; null: so coarse a map is not meant
 */
export async function confirmCoarse(flight_id, options) {
  if (options.gsd_m === undefined || options.any_gsd) return options;
  // Without a verdict the server has the last word.
  const verdict = await getVerdict(flight_id).catch((error) => console.debug('no verdict', error));
  const times = timesCoarser(options, verdict?.gsd_m ?? 0);
  if (times === null) return options;
  const words = strings.options;
  const dialog = h(
    'dialog',
    { class: 'dialog', 'aria-labelledby': 'coarse-title', id: 'coarse-dialog' },
    h('h2', { id: 'coarse-title', class: 'dialog-title' }, words.coarse_title),
    h('p', {}, words.coarse_text(formatGsd(options.gsd_m), formatGsd(verdict?.gsd_m ?? 0), times)),
    h(
      'div',
      { class: 'dialog-actions' },
      h('button', { type: 'button', class: 'button primary', id: 'coarse-no', on: { click: () => dialog.close('') } }, words.coarse_no),
      h('button', { type: 'button', class: 'button', id: 'coarse-yes', on: { click: () => dialog.close('yes') } }, words.coarse_yes),
    ),
  );
  return (await ask(dialog)) === 'yes' ? { ...options, any_gsd: true } : null;
}
