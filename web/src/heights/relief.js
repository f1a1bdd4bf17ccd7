// The map in three dimensions: its ground stands up by its heights, the view is tilted and can be tilted further.
/** @import { RasterDEMSourceSpecification } from '@maplibre/maplibre-gl-style-spec' */
/** @import { MapView } from '../map/map_view.js' */
import { showError } from '../shared/announce.js';
import { getTileJson } from '../shared/api.js';
import { tilesOf } from '../map/map_layers.js';
import { ownHost } from '../map/tile_addresses.js';

const kSource = 'relief';
const kPitch_deg = 60;
const kMaxPitch_deg = 80;
const kTilt_ms = 600;

/**
 * The heights of a map as tiles. They go on beyond it, so that no cliff stands at its edge.
 * @param {MapView} view
 * @returns {Promise<RasterDEMSourceSpecification>}
 */
export const reliefSource = async (view) => ({ type: 'raster-dem', encoding: 'terrarium', ...tilesOf(await getTileJson(ownHost(view.terrain))) });

/**
 * @param {MapView} view
 * @param {HTMLButtonElement} button that begins and ends it
 * @returns {{keepLevel: (is_level: boolean) => void}} keepLevel: at once, and until it is let go, for what a tilted map is of no use to
 */
export function relief(view, button) {
  const { map } = view;
  let is_on = false;
  let turn = 0;
  const set = (/** @type {boolean} */ on) => {
    turn += 1;
    is_on = on;
    button.setAttribute('aria-pressed', String(on));
  };
  const tilt = (/** @type {number} */ pitch) => {
    const reduced = matchMedia('(prefers-reduced-motion: reduce)').matches;
    map.easeTo({ pitch, duration: kTilt_ms, animate: !reduced });
  };
  const flatten = () => {
    if (!is_on) map.setMaxPitch(0);  // which levels what is still tilted
  };
  /** @param {boolean} at_once */
  const stop = (at_once) => {
    if (!is_on) return;
    set(false);
    if (map.getTerrain()) map.setTerrain(null);
    view.remove(kSource, []);
    if (at_once) {
      flatten();
      return;
    }
    tilt(0);
    if (map.isMoving()) map.once('moveend', flatten);
    else flatten();
  };
  const start = async () => {
    set(true);
    const own_turn = turn;
    try {
      const source = await reliefSource(view);
      if (own_turn !== turn) return;
      map.addSource(kSource, source);
      map.setTerrain({ source: kSource, exaggeration: 1 });
      map.setMaxPitch(kMaxPitch_deg);
      tilt(kPitch_deg);
    } catch (error) {
      if (own_turn !== turn) return;
      stop(true);
      showError(error);
    }
  };
  button.setAttribute('aria-pressed', 'false');
  button.hidden = true;
  button.addEventListener('click', () => {
    if (is_on) stop(false);
    else void start();
  });
  view.shown.addEventListener('change', () => {
    stop(true);
    button.hidden = view.terrain === '' || view.heights.length === 0;
  });
  return {
    keepLevel(is_level) {
      if (is_level) stop(true);
      button.disabled = is_level;
    },
  };
}
