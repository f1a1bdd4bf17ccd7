// The sentences of remarks on why nothing came of it: what ends a job, or refuses an upload or an option.
// remark_sentences.cc joins them with the others. Any thread.
#pragma once

#include <array>

#include "core/flight/remarks/remark_words.h"

namespace skyquilt::flight {

inline constexpr std::array kSentencesOnFailures = std::to_array<RemarkSentence>({
    {RemarkCode::kThen, "then", " {said}"},
    {RemarkCode::kPhotoDoes, "photo_does", "{photo} {said}"},
    {RemarkCode::kPhotoAndMore, "photo_and_more", "{photo} and {more} more: {said}"},
    {RemarkCode::kAndMorePictures, "and_more_pictures", "And {pictures} more pictures.", "pictures",
     "And 1 more picture."},
    {RemarkCode::kSoWithMore, "so_with_more", "So it is with {photos} more."},
    {RemarkCode::kFailNoFiles, "fail_no_files",
     "No files were given. Give the flight's photos, or their folder."},
    {RemarkCode::kFailNoPhotos, "fail_no_photos",
     "None of the {files} files given is a photo that a map can be made of. {left}", "files",
     "The one file given is no photo that a map can be made of. {left}"},
    {RemarkCode::kFailNoHeights, "fail_no_heights",
     "No photo has a usable height above the ground: {left} Add the flight's log, a geo.txt with heights, or an "
     "elevation model (--dem)."},
    {RemarkCode::kFailNoPositions, "fail_no_positions",
     "None of the files is a photo with a position, so there is nothing to place on the ground. Check that "
     "the photos come straight from the drone (editing and messengers remove GPS data), or add the flight "
     "log."},
    {RemarkCode::kFailNoneTied, "fail_none_tied",
     "No photo could be tied to the log, and none has a position of its own, so there is nothing to place "
     "on the ground."},
    {RemarkCode::kFailOthersAside, "fail_others_aside",
     "{pictures} of the pictures given can take no part in a map: {left}"},
    {RemarkCode::kFailNoneWhereRecorded, "fail_none_where_recorded",
     "No photo can be placed where its records say: {left}"},
    {RemarkCode::kFailNoneDrawable, "fail_none_drawable",
     "No photo can be drawn where it was placed: {left}"},
    {RemarkCode::kFailNothingInCommon, "fail_nothing_in_common",
     "No photo records where it was taken, and the photos show too little in common to be laid to each "
     "other. Add the flight log or a geo.txt with positions, or photos that overlap more."},
    {RemarkCode::kFailNoFeaturesMatch, "fail_no_features_match",
     "No two photos match by their features alone; --method auto needs no matches."},
    {RemarkCode::kFailAllLookUp, "fail_all_look_up",
     "No photo looks at the ground: by the recorded angles and heights all look at the sky or from below. "
     "Check them, and what the heights count from."},
    {RemarkCode::kFailNoGround, "fail_no_ground",
     "The photos were placed, but none of them shows any ground."},
    {RemarkCode::kFailNoGroundInBoundary, "fail_no_ground_in_boundary",
     "The photos were placed, but none of them shows any ground within the boundary. Draw the boundary over the "
     "flight, or leave it out."},
    {RemarkCode::kFailBoundaryElsewhere, "fail_boundary_elsewhere",
     "Nothing of the map lies within the boundary: the flight is around {lat_deg:.5f}, {lon_deg:.5f} (latitude, "
     "longitude), the boundary around {boundary_lat_deg:.5f}, {boundary_lon_deg:.5f}. Draw the boundary over the "
     "flight, or leave it out."},
    {RemarkCode::kFailFinerThanPhotos, "fail_finer_than_photos",
     "--gsd asks for pixels of {asked_m:.4f} m, but those of the photos show {photos_m:.4f} m of the ground: a "
     "finer map than {finest_m:.4f} m would show nothing more. Choose a coarser --gsd, or leave it out."},
    {RemarkCode::kFailMuchCoarser, "fail_much_coarser",
     "The option gsd_m asks for pixels of {asked_m:g} m, but those of the photos show {photos_cm:.3g} cm of the "
     "ground, {times:.0f} times less. It counts in metres (0.05), at the command line also with a unit (5cm). "
     "If so coarse a map is meant, say --any-gsd, or \"any_gsd\": true in the options of a job."},
    {RemarkCode::kFailPhotoTooWide, "fail_photo_too_wide",
     "{photo} would cover {across} x {down} blocks of the map at this resolution. Check its height and angles "
     "and leave it out if they are wrong; otherwise choose a coarser --gsd."},
    {RemarkCode::kFailMapTooLarge, "fail_map_too_large",
     "The map would have more than a million megapixels; choose a coarser --gsd."},
    {RemarkCode::kFailMapChanged, "fail_map_changed",
     "The map cannot be placed: its photos are no longer the files it was made from, or it was not finished. "
     "Stitch them again."},
    {RemarkCode::kFailPlacesTooNear, "fail_places_too_near",
     "The places lie within {share_percent:.0f} % of the map's extent, too near together to tell its scale and "
     "north. Choose places near its edges."},
    {RemarkCode::kFailPlacesContradict, "fail_places_contradict",
     "The places contradict each other: no turn, scale and shift of the map brings all of them nearer than "
     "{apart_m:.1f} m to where they are said to be. Check their order, and that each is the same thing on the map "
     "and on Earth."},
    {RemarkCode::kFailNoPointMarked, "fail_no_point_marked",
     "No surveyed point is marked in a photo yet. Mark each in two or more photos, and three points or more, "
     "spread over the map."},
    {RemarkCode::kFailFewPoints, "fail_few_points",
     "Of {points} surveyed points {used} can be used, and {needed} are needed, each marked in two or more photos "
     "of the map."},
    {RemarkCode::kFailPointsTooNear, "fail_points_too_near",
     "The surveyed points lie within {share_percent:.0f} % of the map's extent, too near together to tell its "
     "scale and north. Mark points near its edges."},
    {RemarkCode::kFailPointsContradict, "fail_points_contradict",
     "The surveyed points contradict each other: no turn, scale and shift of the map brings most of them within "
     "{apart_m:.2f} m of where they were surveyed. Check the order of the coordinates, the reference system in "
     "the first line, and the marks."},
    {RemarkCode::kFailScale, "fail_scale",
     "With this scale a photo's pixel would show {pixel_m:.3g} m of ground; {finest_m:.4f} to {coarsest_m:.0f} m "
     "is possible. As the map is now it shows {now_m:.4f} m."},
    {RemarkCode::kBeforeFirstStage, "before_first_stage", "before its first stage"},
    {RemarkCode::kInStage, "in_stage", "in the stage \"{stage}\""},
    {RemarkCode::kInStageAt, "in_stage_at", "in the stage \"{stage}\" ({at_words})"},
    {RemarkCode::kFailMemory, "fail_memory",
     "The job was ended because it needed more than {limit_gib:.1f} GiB of memory {where}. One of the files may "
     "be damaged or made to do this: take out what is no ordinary photo, or make the map of fewer photos. "
     "Whoever runs the server can give jobs more with --job-memory."},
    {RemarkCode::kFailTime, "fail_time",
     "The job was ended because it took more than {limit_s:duration} and was still {where}. One of the files may "
     "be damaged or made to do this: take out what is no ordinary photo. Whoever runs the server can give jobs "
     "more time with --job-timeout."},
    {RemarkCode::kFailProcessorTime, "fail_processor_time",
     "The job was ended because it took more than {limit_s:duration} of processor time and was still {where}. One "
     "of the files may be damaged or made to do this: take out what is no ordinary photo. Whoever runs the "
     "server can give jobs more time with --job-timeout."},
    {RemarkCode::kFailProcessEnded, "fail_process_ended",
     "The process that made the map ended unexpectedly {where}. Try fewer or other photos if it does so again."},
    {RemarkCode::kFailProcessKilled, "fail_process_killed",
     "The process that made the map ended unexpectedly {where}; the machine may have run out of memory. Try "
     "fewer or other photos if it does so again."},
    {RemarkCode::kFailWorkerMeans, "fail_worker_means",
     "The worker ran out of memory or another means. It tries again."},
    {RemarkCode::kFailWorkersDied, "fail_workers_died",
     "The worker died on every attempt (it may have run out of memory). Try fewer or smaller photos."},
    {RemarkCode::kFailPartWorkersDied, "fail_part_workers_died",
     "The workers of a part of this flight died on every attempt (they may have run out of memory). Try fewer or "
     "smaller photos."},
    {RemarkCode::kFailCancelled, "fail_cancelled", "The job was cancelled."},
    {RemarkCode::kFailDiskFull, "fail_disk_full",
     "The server's disk is full. Free some space and try again."},
    {RemarkCode::kFailNoRoom, "fail_no_room",
     "The server's disk has no room for this file. Free some space first."},
    {RemarkCode::kFailNotStored, "fail_not_stored", "The server could not store the map."},
    {RemarkCode::kFailStoreAway, "fail_store_away",
     "The store of photos and maps at {store} ({host}) cannot be reached. Try again later."},
    {RemarkCode::kFailStoreTrouble, "fail_store_trouble",
     "The store of photos and maps at {store} does not work at the moment. Try again later."},
    {RemarkCode::kFailDatabaseAway, "fail_database_away",
     "The catalogue's database cannot be reached at the moment. Try again; what was asked last may have been "
     "done or not."},
    {RemarkCode::kFailFolderGone, "fail_folder_gone",
     "The server's data folder is gone: it was removed or is not mounted. Try again when it is back."},
    {RemarkCode::kFailFileEmpty, "fail_file_empty",
     "The file is empty. Was it copied completely from the card?"},
    {RemarkCode::kFailFileTooLarge, "fail_file_too_large",
     "This file is larger than {most_gib} GiB, more than the server takes."},
    {RemarkCode::kFailQuota, "fail_quota",
     "The flights of the token \"{token}\" may hold {room}, and this would be more. Delete a flight, or ask the "
     "server's operator for room."},
    {RemarkCode::kFailArchive, "fail_archive", "The archive was not taken: {why_words}."},
    {RemarkCode::kFailNoFilesYet, "fail_no_files_yet", "This flight has no files yet. Upload photos first."},
    {RemarkCode::kFailUnfinishedJob, "fail_unfinished_job",
     "This flight has a job that is not finished. Cancel it or wait for its end, then try again."},
    {RemarkCode::kFailBeingStitched, "fail_being_stitched",
     "This flight is being stitched. Cancel its job or wait for its end, then try again."},
    {RemarkCode::kFailOfAnotherToken, "fail_of_another_token",
     "This flight belongs to another token. Only that one, or one of scope admin, may change it."},
    {RemarkCode::kFailOptionUnknown, "fail_option_unknown",
     "The option \"{option}\" is not known; known are {known_words}."},
    {RemarkCode::kFailOption, "fail_option", "The option \"{option}\" {rule_words}."},
    {RemarkCode::kFailBoundaryUnusable, "fail_boundary_unusable",
     "The boundary cannot be used: {why_words} Give a GeoJSON Polygon or MultiPolygon, or a KML, with longitudes "
     "and latitudes of WGS 84 in degrees."},
    {RemarkCode::kFailBoundaryUnread, "fail_boundary_unread",
     "The boundary is neither GeoJSON nor KML. Give a file with a polygon in one of them."},
    {RemarkCode::kFailImportMissing, "fail_import_missing",
     "This flight has no file \"{file}\" to be imported. Upload it first."},
});

}  // namespace skyquilt::flight
