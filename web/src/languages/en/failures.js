// English: why nothing came of it, by the codes of core/flight/remarks/remark.h: what ended a job, or refused an upload or an
// option. As remarks.js.
import { count, fixed, number } from '../../shared/language.js';
import { formatDuration } from '../../shared/format.js';
import { flight_words } from './flight.js';

const pictures = { one: 'picture', other: 'pictures' };
const damaged = 'One of the files may be damaged: take out what is no ordinary photo';
const more_room = 'Whoever runs the server can allow more.';
const stage = (/** @type {any} */ v) => flight_words.job.stages[v.stage] ?? v.stage;
const place = (/** @type {number} */ lat_deg, /** @type {number} */ lon_deg) => `${fixed(lat_deg, 5)}, ${fixed(lon_deg, 5)}`;
const resolution = (/** @type {number} */ metres) => `${number(100 * metres, { maximumSignificantDigits: 3 })}\u00a0cm`;

/** @type {Record<string, (v: any) => string>} */
export const failure_words = {
  then: (v) => ` ${v.said}`,
  photo_does: (v) => `${v.photo}: ${v.said}`,
  photo_and_more: (v) => `${v.photo} and ${number(v.more)} more: ${v.said}`,
  and_more_pictures: (v) => `And ${count(v.pictures, { one: 'more picture', other: 'more pictures' })}.`,
  so_with_more: (v) => `The same holds for ${number(v.photos)} more.`,
  fail_no_files: () => 'There are no files. Add the photos of the flight.',
  fail_no_photos: (v) => `${count(v.files, { one: 'file was added, and it is not', other: 'files were added, and none is' })} a photo that a map can be made of. ${v.left}`,
  fail_no_heights: (v) => `No photo has a usable height above the ground. ${v.left} Add the flight log, a list with heights (geo.txt) or an elevation model (GeoTIFF).`,
  fail_no_positions: () => 'No file is a photo with a position. Use the photos as they come from the drone (editing programs and messengers remove positions), or add the flight log.',
  fail_none_tied: () => 'No photo could be matched to the flight log, and none has a position of its own.',
  fail_others_aside: (v) => `${count(v.pictures, pictures)} can take no part in a map: ${v.left}`,
  fail_none_where_recorded: (v) => `No photo can be placed where its metadata put it. ${v.left}`,
  fail_none_drawable: (v) => `No photo can be drawn where it was placed. ${v.left}`,
  fail_nothing_in_common: () => 'No photo records where it was taken, and the photos show too little in common to be placed by that. Add the flight log, a list of positions (geo.txt), or photos that overlap more.',
  fail_no_features_match: () => 'No two photos match by their features alone. Choose the automatic method in the options.',
  fail_all_look_up: () => 'By their recorded angles and heights no photo looks at the ground. Check the angles, and what the heights count from.',
  fail_no_ground: () => 'The photos were placed, but none of them shows any ground.',
  fail_no_ground_in_boundary: () => 'The photos were placed, but none of them shows any ground within the area. Draw the area over the flight, or leave it out.',
  fail_boundary_elsewhere: (v) => `Nothing of the map lies within the area: the flight is around ${place(v.lat_deg, v.lon_deg)}, the area around ${place(v.boundary_lat_deg, v.boundary_lon_deg)}. Draw the area over the flight, or leave it out.`,
  fail_finer_than_photos: (v) => `A resolution of ${resolution(v.asked_m)} was asked for, but the photos show ${resolution(v.photos_m)}: a map finer than ${resolution(v.finest_m)} would show nothing more. Choose a coarser resolution.`,
  fail_much_coarser: (v) => `A resolution of ${resolution(v.asked_m)} was asked for, but the photos show ${resolution(v.photos_cm / 100)}, which is ${number(v.times, { maximumFractionDigits: 0 })} times finer. Choose a finer resolution, or confirm that so coarse a map is meant.`,
  fail_photo_too_wide: (v) => `${v.photo} alone would cover ${number(v.across)} × ${number(v.down)} blocks of the map. Check its height and angles and leave it out if they are wrong, or choose a coarser resolution.`,
  fail_map_too_large: () => 'The map would have more than a million megapixels. Choose a coarser resolution.',
  fail_map_changed: () => 'The map cannot be placed: its photos are no longer the files it was made from, or it was not finished. Make the map again.',
  fail_places_too_near: (v) => `The places lie within ${fixed(v.share_percent, 0)}\u00a0% of the map's extent, too near together to tell its scale and north. Choose places near its edges.`,
  fail_places_contradict: (v) => `The places contradict each other: however the map is rotated, scaled and moved, one stays ${fixed(v.apart_m, 1)}\u00a0m off. Check their order, and that each is the same thing on the map and on Earth.`,
  fail_no_point_marked: () => 'No control point is marked in a photo yet. Mark at least three, spread over the map, each in two or more photos.',
  fail_few_points: (v) => `${number(v.used)} of ${number(v.points)} control points can be used, and ${number(v.needed)} are needed, each marked in two or more photos of the map.`,
  fail_points_too_near: (v) => `The control points lie within ${fixed(v.share_percent, 0)}\u00a0% of the map's extent, too near together to tell its scale and north. Mark points near its edges.`,
  fail_points_contradict: (v) => `The control points contradict each other: however the map is rotated, scaled and moved, most are more than ${fixed(v.apart_m, 2)}\u00a0m off. Check the order of the coordinates, the coordinate system, and the marks.`,
  fail_scale: (v) => `At this scale a pixel of a photo would show ${number(v.pixel_m, { maximumSignificantDigits: 3 })}\u00a0m of ground; possible are ${fixed(v.finest_m, 4)} to ${fixed(v.coarsest_m, 0)}\u00a0m, and now it is ${fixed(v.now_m, 4)}\u00a0m.`,
  before_first_stage: () => 'before the first step',
  in_stage: (v) => `in the step “${stage(v)}”`,
  in_stage_at: (v) => `in the step “${stage(v)}” (${v.at_words})`,
  fail_memory: (v) => `Making the map was stopped ${v.where}: it needed more than ${fixed(v.limit_gib, 1)}\u00a0GiB of memory. ${damaged}, or make the map of fewer photos. ${more_room}`,
  fail_time: (v) => `Making the map was stopped ${v.where}: it took more than ${formatDuration(v.limit_s)}. ${damaged}. ${more_room}`,
  fail_processor_time: (v) => `Making the map was stopped ${v.where}: it took more than ${formatDuration(v.limit_s)} of processor time. ${damaged}. ${more_room}`,
  fail_process_ended: (v) => `The process that made the map ended unexpectedly ${v.where}. Try fewer or other photos if it does so again.`,
  fail_process_killed: (v) => `The process that made the map ended unexpectedly ${v.where}; the server may have run out of memory. Try fewer or other photos if it does so again.`,
  fail_worker_means: () => 'The server ran out of memory or another resource while it made the map.',
  fail_workers_died: () => 'Every attempt to make the map broke off; the server may have run out of memory. Try fewer or smaller photos.',
  fail_part_workers_died: () => 'Every attempt to make a part of the map broke off; the server may have run out of memory. Try fewer or smaller photos.',
  fail_cancelled: () => 'Making the map was cancelled.',
  fail_disk_full: () => 'The disk of the server is full. Once there is room again, try again.',
  fail_no_room: () => 'The disk of the server has no room for this file.',
  fail_not_stored: () => 'The server could not store the map.',
  fail_store_away: (v) => `The server cannot reach its storage for photos and maps (${v.store} at ${v.host}). Try again later.`,
  fail_store_trouble: (v) => `The server's storage for photos and maps (${v.store}) does not work at the moment. Try again later.`,
  fail_database_away: () => 'The server cannot reach its database at the moment. Try again; what you did last may have been done or not.',
  fail_folder_gone: () => 'The server cannot reach its data folder. Try again when it is back.',
  fail_file_empty: () => 'The file is empty. Was it copied completely from the card?',
  fail_file_too_large: (v) => `The file is larger than ${number(v.most_gib)}\u00a0GiB, more than the server takes.`,
  fail_quota: (v) => `The flights of the token “${v.token}” may hold ${v.room}, and this would be more. Delete a flight, or ask whoever runs the server for room.`,
  fail_archive: () => 'The archive was not accepted. Unpack it, and add the photos themselves.',
  fail_no_files_yet: () => 'This flight has no files yet. Add photos first.',
  fail_unfinished_job: () => 'A map of this flight is being made already. Cancel that or wait for its end.',
  fail_being_stitched: () => 'A map of this flight is being made. Cancel that or wait for its end.',
  fail_of_another_token: () => 'This flight belongs to somebody else. Only they and whoever runs the server may change it.',
  fail_option_unknown: (v) => `The server does not know the option “${v.option}”.`,
  fail_option: (v) => `The option “${v.option}” ${v.rule_words}.`,
  fail_boundary_unusable: () => 'The area cannot be used. Give one or more closed outlines as GeoJSON or KML, with longitudes and latitudes of WGS 84 in degrees.',
  fail_boundary_unread: () => 'The area is neither GeoJSON nor KML. Choose a file with an outline in one of these formats.',
  fail_import_missing: (v) => `This flight has no file “${v.file}” to be imported. Add it first.`,
};
