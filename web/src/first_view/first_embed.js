// The first script of the bare map: takes its token, asks for the map's document and shows its poster, while everything
// else is still on its way.
import { fetchMapWorker, showPoster } from './poster.js';
import { kEmbedPadding } from './poster_place.js';
import { embedded } from '../embed/embed_address.js';
import { placeOfHash } from '../map/view_address.js';
import { askEarly, holdToken, readable } from '../shared/token.js';

const { id, token, wishes } = embedded();
holdToken(token);

async function show() {
  /** @type {import('../shared/types.js').TileJson|null} */
  const tilejson = await askEarly(`/tiles/${encodeURIComponent(id)}.json`);
  const revision = Number.parseInt(tilejson?.version ?? '', 10);
  const stage = document.getElementById('stage');
  const bounds = tilejson?.across_bounds ?? tilejson?.bounds;
  if (!stage || !bounds || !(revision > 0)) return;  // 0: a preview, of which there is no picture
  const address = readable(`/api/v1/flights/${encodeURIComponent(id)}/thumbnail.webp?size=1024&rev=${revision}`);
  await showPoster(stage, { flight_id: id, address, bounds, padding: kEmbedPadding, view: placeOfHash(`#?${wishes}`) });
  await fetchMapWorker();
}

show().catch((error) => console.debug('no poster', error));
