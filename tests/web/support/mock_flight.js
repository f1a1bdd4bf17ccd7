// A made-up flight's answers: bounds, report, photo footprints. Lawnmower strips over the countryside of tile_picture.

/** @typedef {{lon: number, lat: number, half_m: number, season: number}} Place */

const degrees_per_m = 1 / 111_320;

/** @param {Place} place @param {number} east_m @param {number} north_m */
export function at(place, east_m, north_m) {
  return [
    place.lon + (east_m * degrees_per_m) / Math.cos((place.lat * Math.PI) / 180),
    place.lat + north_m * degrees_per_m,
  ];
}

/** @param {Place} place @returns {[number, number, number, number]} */
export function boundsOf(place) {
  const [west, south] = at(place, -place.half_m, -place.half_m * 0.8);
  const [east, north] = at(place, place.half_m, place.half_m * 0.8);
  return [west, south, east, north];
}

/** By the first pair alone: a stand-in moves, and neither turns nor scales. @param {any} flight @param {{shown: number[], is: number[]}[]} pairs */
export function moveByPairs(flight, [{ shown, is }]) {
  flight.is_placed = true;
  flight.place = { ...flight.place, lat: flight.place.lat + is[0] - shown[0], lon: flight.place.lon + is[1] - shown[1] };
}

/** @param {Place} place @param {string[]} names */
export function photosGeoJson(place, names) {
  const per_strip = 6;
  const strips = Math.ceil(names.length / per_strip);
  const features = names.map((name, i) => {
    const strip = Math.floor(i / per_strip);
    const step = i % per_strip;
    const along = (strip % 2 ? per_strip - 1 - step : step) / (per_strip - 1);
    const east_m = (along - 0.5) * place.half_m * 1.35;
    const north_m = strips > 1 ? (strip / (strips - 1) - 0.5) * place.half_m * 0.85 : 0;
    const yaw_deg = strip % 2 ? 270 : 90;
    const pose_only = i % 9 === 7;
    const corners = [[-26, -19], [26, -19], [26, 19], [-26, 19], [-26, -19]].map(([e, n]) =>
      at(place, east_m + e + n * 0.08, north_m + n - e * 0.05),
    );
    const [camera_lon, camera_lat] = at(place, east_m, north_m);
    return {
      type: 'Feature',
      properties: {
        name,
        placement: pose_only ? 'pose_only' : 'aligned',
        reason: pose_only ? 'placed by its recorded pose: too few points in common with other photos (3)' : '',
        remarks: pose_only ? [{ code: 'by_pose_few_points', values: { points: 3 } }] : [],
        error_radius_m: pose_only ? 3.1 : 2.3,  // as the map's (TellPhotos)
        camera_lon,
        camera_lat,
        camera_height_above_ground_m: 41.3 + 0.1 * (i % 7),
        yaw_deg,
        pitch_deg: -0.4,
        roll_deg: 0.7,
        captured_at: new Date(Date.UTC(2026, 4, 12, 9, 31, 2 * i)).toISOString(),
      },
      geometry: { type: 'Polygon', coordinates: [corners] },
    };
  });
  return { type: 'FeatureCollection', features };
}

/** As core/pipeline/report/judge_map.cc has it. @param {number} total @param {number} pose_only @param {number} left_out */
function qualityOf(total, pose_only, left_out) {
  const limits = [];
  if (left_out > 0) limits.push({ kind: 'left_out', count: left_out, of: total + left_out });
  if (pose_only > 0) limits.push({ kind: 'pose_only', count: pose_only, of: total });
  const of_photos = { status: limits.length > 0 ? 'limited' : 'ready', limits };
  if (total === 0) return { status: 'unknown', limits, absolute: { sigma_m: null, by: 'none', count: 0 }, relative: { error_m: null, error_px: null, by: 'none', count: 0 } };
  return { ...of_photos, absolute: { sigma_m: 2.3, by: 'gnss', count: total - pose_only }, relative: { error_m: 0.012, error_px: 0.7, by: 'seams', count: 31 } };
}

/** Of a map that nothing places. @param {any} quality */
export const unplacedQuality = (quality) => ({
  ...quality,
  status: 'unplaced',
  absolute: { sigma_m: null, by: 'none', count: 0 },
  relative: { ...quality.relative, error_m: null },
  limits: [{ kind: 'not_georeferenced', count: 0, of: 0 }, { kind: 'scale_guessed', count: 0, of: 0 }, { kind: 'north_guessed', count: 0, of: 0 }, ...quality.limits],
});

/** @param {Place} place @param {string[]} names @param {number} max_zoom @param {boolean} [is_whole] */
export function reportOf(place, names, max_zoom, is_whole = false) {
  const total = names.length;
  const pose_only = is_whole ? 0 : names.filter((_, i) => i % 9 === 7).length;
  const left_out = is_whole ? [] : [{ name: 'DJI_0999.JPG', reason: 'It has no GPS position and no log covers its time.' }];
  return {
    photos: { total: total + left_out.length, aligned: total - pose_only, pose_only, left_out: left_out.length },
    left_out_photos: left_out,
    quality: qualityOf(total, pose_only, left_out.length),
    gsd_m: 0.0173,
    area_m2: (place.half_m * 2) ** 2 * 0.55,
    bounds: boundsOf(place),
    min_zoom: 14,
    max_zoom,
    timings: [
      { stage: 'read', wall_s: 1.9 },
      { stage: 'pose', wall_s: 0.4 },
      { stage: 'align', wall_s: 14.2 },
      { stage: 'render', wall_s: 21.7 },
      { stage: 'export', wall_s: 3.1 },
    ],
    peak_memory_bytes: 611_000_000,
    warnings: ['Two strips at the west edge overlap by less than 30 %: the seam there may show a step.',
      `${names[0]}: recorded position is 46 m from where the photo was taken by what it shows`],
    remarks: [{ code: 'text', values: { text_words: 'Two strips at the west edge overlap by less than 30 %: the seam there may show a step.' } },
      { code: 'of_photo', values: { photo: names[0], said: [{ code: 'position_elsewhere', values: { off_m: 46.2 } }] } }],
  };
}

const kTowns = ['Bern', 'Zürich', 'Genève', 'Łódź', 'Köln', 'Málaga', 'Tromsø', 'Ærø', 'Lugano', 'Brno'];

/** Many flights over Europe, for the home view at its size. @param {any} mock @param {number} count */
export function seedMany(mock, count) {
  for (let i = 0; i < count; i += 1) {
    const flight = mock.seedReady(`${kTowns[i % kTowns.length]}, field ${i + 1}`, 3);
    Object.assign(flight.place, { lon: -8 + ((i * 37) % 300) / 10, lat: 38 + ((i * 53) % 200) / 10, season: i });
    const day = `2026-${String(1 + (i % 9)).padStart(2, '0')}-${String(1 + (i % 27)).padStart(2, '0')}`;
    flight.captured = { first: `${day}T09:31:00+02:00`, last: `${day}T09:52:34+02:00` };
  }
}
