// The sentences of remarks on where the flight was, its map, and why a picture takes no part;
// remark_sentences.cc joins them with the others. Any thread.
#pragma once

#include <array>

#include "core/flight/remarks/remark_words.h"

namespace skyquilt::flight {

inline constexpr std::array kSentencesOnMaps = std::to_array<RemarkSentence>({
    {RemarkCode::kReckonedFromOrigin, "reckoned_from_origin",
     "No position anywhere: the flight is reckoned from the given origin, and its error grows with time."},
    {RemarkCode::kReckonedFromNowhere, "reckoned_from_nowhere",
     "No position anywhere: the map has the right scale and north, but its place on Earth is not known; "
     "it is drawn at 0 degrees north, 0 degrees east. Give --origin LAT,LON of the take-off to place "
     "it, also later with `skyquilt place`."},
    {RemarkCode::kNotGeoreferenced, "not_georeferenced",
     "The map is whole but NOT GEOREFERENCED: it lies at a local origin, its north is a guess and its "
     "scale is as if a photo showed {width_m:.0f} m of ground. Add the flight log, surveyed points "
     "(gcp_list.txt) or positions (geo.txt), or give `skyquilt place` what is known to place it without "
     "aligning it again."},
    {RemarkCode::kNoAngles, "no_angles", "{photos} of {total} photos recorded no camera angles."},
    {RemarkCode::kAnglesAssumed, "angles_assumed",
     "They are taken as looking straight down, turned along the flight's course."},
    {RemarkCode::kAnglesFound, "angles_found", "Their angles were found from what they show."},
    {RemarkCode::kNoHeights, "no_heights", "No photo says how high it was above the ground."},
    {RemarkCode::kHeightBySpacing, "height_by_spacing",
     "{height_m:.0f} m is assumed from the photos' spacing; the map's scale depends on it. Photos with "
     "a relative height (DJI RelativeAltitude) do better."},
    {RemarkCode::kOnTheGround, "on_the_ground",
     "By the recorded heights most photos stand on or below the ground (half of them lower than "
     "{height_m:.0f} m above it), which cannot be: the ground below them is not as high as the place of "
     "take-off, or the heights count from something else."},
    {RemarkCode::kHeightBySpacingOnTheGround, "height_by_spacing_on_the_ground",
     "{height_m:.0f} m above the ground is assumed from the photos' spacing; the map's scale depends on "
     "it. Add an elevation model (--dem) if the ground lies lower than take-off."},
    {RemarkCode::kHeightFound, "height_found",
     "{assumed_m:.0f} m above the ground was assumed to begin with; by what the photos show it was "
     "{found_m:.0f} m."},
    {RemarkCode::kAssumedByPoses, "assumed_by_poses",
     "For the {photos} photos that are placed by their poses alone the assumption stands: {assumed}",
     "photos", "For the 1 photo that is placed by its pose alone the assumption stands: {assumed}"},
    {RemarkCode::kElevationModelBesideTakeoff, "elevation_model_beside_takeoff",
     "The elevation model does not cover the place of take-off; the ground is taken as flat."},
    {RemarkCode::kElevationModelTooSmall, "elevation_model_too_small",
     "The elevation model covers less than half of the photos; the ground is taken as flat."},
    {RemarkCode::kNoTies, "no_ties",
     "No two photos could be tied together by what they show: the map is by the recorded poses alone, "
     "and may show steps. If the ground is not water or bare, check that positions, heights and angles "
     "are those of this flight."},
    {RemarkCode::kGroups, "groups",
     "The photos form {groups} groups without ties between them; each lies where its recorded positions "
     "say."},
    {RemarkCode::kGroupsOfFeatures, "groups_of_features",
     "The features join the photos into {groups} connected components, each placed on its recorded "
     "positions."},
    {RemarkCode::kControlContradicts, "control_contradicts",
     "the surveyed points CONTRADICT the photos: half of the {points} used lie {apart_m:.1f} m or more "
     "from where all photos together show them. Check the list's coordinates, their zone and the marks"},
    {RemarkCode::kPointsDropped, "points_dropped",
     "only {used} of {points} points found in several photos fit the poses: the records CONTRADICT what "
     "the photos show, and the map may be torn. Check that every photo has a position of its own and "
     "that heights and angles are those of this flight, or leave the records out (--method images)"},
    {RemarkCode::kPositionsContradict, "positions_contradict",
     "the recorded positions CONTRADICT what the photos show: half of the {photos} photos lie "
     "{apart_m:.0f} m or more from where they were recorded, which is {times:.0f} times what the "
     "records claim: the map as a whole may be as far off"},
    {RemarkCode::kPlacedByImages, "placed_by_images",
     "Because {why}, what the photos show decides: {outcome}."},
    {RemarkCode::kHeightsTilted, "heights_tilted",
     "The recorded heights would have the flight lie tilted by {tilt_deg:.0f} degrees against the "
     "recorded camera angles, as after a second take-off from another height or by a barometer that "
     "drifted: they differ by up to {apart_m:.0f} m from how the photos lie to each other, and were "
     "believed only from each photo to the next."},
    {RemarkCode::kPositionsOfBefore, "positions_of_before",
     "The recorded positions are those of {lag:.1f} {unit} before the photos, {apart_m:.1f} m off in the median; "
     "each was moved along its flight line by that."},
    {RemarkCode::kPositionsOfAfter, "positions_of_after",
     "The recorded positions are those of {lag:.1f} {unit} after the photos, {apart_m:.1f} m off in the median; "
     "each was moved along its flight line by that."},
    {RemarkCode::kClockBehind, "clock_behind",
     "By how they lie to each other the photos were taken {clock_s:.1f} s later than the clocks of camera and log "
     "say: each was moved along the log's track by that ({moved_m:.1f} m in the median)."},
    {RemarkCode::kClockAhead, "clock_ahead",
     "By how they lie to each other the photos were taken {clock_s:.1f} s earlier than the clocks of camera and log "
     "say: each was moved along the log's track by that ({moved_m:.1f} m in the median)."},
    {RemarkCode::kSecondsApart, "seconds_apart", "seconds"},
    {RemarkCode::kPhotosApart, "photos_apart", "photos"},
    {RemarkCode::kRollingShutterFound, "rolling_shutter_found",
     "{camera}: the photos show that it reads its rows one after the other, in {readout_ms:.0f} ms from "
     "the first to the last ({photos} photos); the camera is not listed and nothing recorded says so",
     "photos",
     "{camera}: the photos show that it reads its rows one after the other, in {readout_ms:.0f} ms from "
     "the first to the last (1 photo); the camera is not listed and nothing recorded says so"},
    {RemarkCode::kMountTurned, "mount_turned",
     "all photos lie turned by {turn_deg} degrees against their recorded yaw, as of a camera mounted "
     "sideways; the mount was taken as that"},
    {RemarkCode::kMountTurnedAgainstCourse, "mount_turned_against_course",
     "all photos lie turned by {turn_deg} degrees against the flight's course, as of a camera mounted "
     "sideways; the mount was taken as that"},
    {RemarkCode::kPhotosStoredTurned, "photos_stored_turned",
     "Photos {first} to {last} are stored turned by {turn_deg} degrees against their recorded yaw; they "
     "were turned back. A viewer that saves pictures upright does this: use the originals if you can."},
    {RemarkCode::kPhotosStoredTurnedAgainstCourse, "photos_stored_turned_against_course",
     "Photos {first} to {last} are stored turned by {turn_deg} degrees against the flight's course; "
     "they were turned back. A viewer that saves pictures upright does this: use the originals if you "
     "can."},
    {RemarkCode::kFoundTurned, "found_turned",
     "found turned by {turn_deg} degrees against its recorded yaw and turned back"},
    {RemarkCode::kFoundTurnedAgainstCourse, "found_turned_against_course",
     "found turned by {turn_deg} degrees against the flight's course and turned back"},
    {RemarkCode::kYawCorrected, "yaw_corrected",
     "recorded yaw was {off_deg:.0f} degrees off and was corrected from its neighbours"},
    {RemarkCode::kCourseYawCorrected, "course_yaw_corrected",
     "yaw taken from the course was {off_deg:.0f} degrees off and was corrected from its neighbours"},
    {RemarkCode::kPositionCorrected, "position_corrected",
     "recorded position was {off_m:.0f} m off and was corrected from its neighbours"},
    {RemarkCode::kPositionElsewhere, "position_elsewhere",
     "recorded position is {off_m:.0f} m from where the photo was taken by what it shows"},
    {RemarkCode::kPlacedWithoutRecord, "placed_without_record",
     "records no usable position or height and was placed by what it shows"},
    {RemarkCode::kByPoseAlone, "by_pose_alone", "placed by its recorded pose; images were not compared"},
    {RemarkCode::kByPoseUnreadable, "by_pose_unreadable", "placed by its recorded pose: {error_words}"},
    {RemarkCode::kByPoseFewPoints, "by_pose_few_points",
     "placed by its recorded pose: too few points in common with other photos ({points})"},
    {RemarkCode::kByPoseAsNeighbours, "by_pose_as_neighbours",
     "placed by its recorded pose, corrected as its neighbours were: too few points in common with other "
     "photos ({points})"},
    {RemarkCode::kByPoseMovedToFit, "by_pose_moved_to_fit",
     "placed by its recorded pose, moved to where the whole picture fits {photos} other photos: too few "
     "points in common ({points})",
     "photos",
     "placed by its recorded pose, moved to where the whole picture fits 1 other photo: too few points in "
     "common ({points})"},
    {RemarkCode::kByPoseNoFit, "by_pose_no_fit",
     "placed by its recorded pose: no other picture fits it unambiguously"},
    {RemarkCode::kMovedToFit, "moved_to_fit", "moved to where the whole picture fits {photos} other photos",
     "photos", "moved to where the whole picture fits 1 other photo"},
    {RemarkCode::kFirstOfChain, "first_of_chain",
     "the first of its connected component, {misfit_px:.1f} px from what a camera could see"},
    {RemarkCode::kChained, "chained",
     "chained to {photos} photos by features, {misfit_px:.1f} px from what a camera could see", "photos",
     "chained to one photo by features, {misfit_px:.1f} px from what a camera could see"},
    {RemarkCode::kDoubtCopy, "doubt_copy", "shows the same picture as {other}"},
    {RemarkCode::kDoubtBlurred, "doubt_blurred", "is blurred"},
    {RemarkCode::kDoubtOtherPlace, "doubt_other_place",
     "has nothing in common with the photos around its recorded place: of another place, or of "
     "something that moves; used only where no other photo is"},
    {RemarkCode::kControlNotUsed, "control_not_used",
     "Ground control point {point} is not used: it {reason}."},
    {RemarkCode::kControlFarOff, "control_far_off",
     "Ground control point {point} lies {apart_m:.1f} m from where the photos and the other points put "
     "it: check its coordinates and its marks."},
    {RemarkCode::kControlFarOffAndNoted, "control_far_off_and_noted",
     "Ground control point {point} lies {apart_m:.1f} m from where the photos and the other points put "
     "it: check its coordinates and its marks; it {reason}."},
    {RemarkCode::kControlNoted, "control_noted", "Ground control point {point} {reason}."},
    {RemarkCode::kPointFewMarks, "point_few_marks",
     "is marked in fewer than two photos that are tied to others"},
    {RemarkCode::kPointMarksElsewhere, "point_marks_elsewhere",
     "is marked in {marks} photos ({names}) elsewhere than the other photos show it; those marks are left "
     "out",
     "marks", "is marked in {names} elsewhere than the other photos show it; that mark is left out"},
    {RemarkCode::kPointMarksApart, "point_marks_apart",
     "has marks that do not meet in one point on the ground"},
    {RemarkCode::kPointFarFromOthers, "point_far_from_others",
     "lies {apart_m:.1f} m from where the other points put it: check its coordinates and its marks"},
    {RemarkCode::kPointOffOthers, "point_off_others",
     "lies {apart_m:.2f} m off where the other points put it"},
    {RemarkCode::kPhotosAdded, "photos_added",
     "{photos} photos were added and placed against the finished flight, of which nothing was moved.",
     "photos", "1 photo was added and placed against the finished flight, of which nothing was moved."},
    {RemarkCode::kMovedToControl, "moved_to_control",
     "The finished flight was moved as a whole to {points} ground control points: {east_m:.2f} m east, "
     "{north_m:.2f} m north, turned by {turn_deg:.2f} degrees, {growth_percent:.2f} % larger.",
     "points",
     "The finished flight was moved as a whole to 1 ground control point: {east_m:.2f} m east, "
     "{north_m:.2f} m north, turned by {turn_deg:.2f} degrees, {growth_percent:.2f} % larger."},
    {RemarkCode::kPlacedByControl, "placed_by_control",
     "The finished map was placed by {points} surveyed points, which it misses by {apart_m:.2f} m in "
     "the median; it was turned by {turn_deg:.1f} degrees and became {times:.4g} times as large. No "
     "photo was compared again."},
    {RemarkCode::kPlacedByPairs, "placed_by_pairs",
     "The map was placed by hand, by {points} places on it; it was turned by {turn_deg:.1f} degrees and "
     "became {times:.4g} times as large.",
     "points",
     "The map was placed by hand, by 1 place on it; it was turned by {turn_deg:.1f} degrees and became "
     "{times:.4g} times as large."},
    {RemarkCode::kPairsDisagree, "pairs_disagree", "It misses them by up to {apart_m:.2f} m."},
    {RemarkCode::kPlacedByOrigin, "placed_by_origin",
     "The map was placed by hand: its origin lies at {lat_deg:.7f}, {lon_deg:.7f}; it was turned by "
     "{turn_deg:.1f} degrees and became {times:.4g} times as large. How far off it may be, the flight "
     "cannot tell: check it over known places."},
    {RemarkCode::kPlacedByPhoto, "placed_by_photo",
     "The map was placed by hand: {photo} lies at {lat_deg:.7f}, {lon_deg:.7f}; it was turned by "
     "{turn_deg:.1f} degrees and became {times:.4g} times as large. How far off it may be, the flight "
     "cannot tell: check it over known places."},
    {RemarkCode::kImported, "imported",
     "This map was imported from {file}. Where it lies and how accurate it is, that file says; no photo "
     "was looked at here."},
    {RemarkCode::kCoarserPixels, "coarser_pixels",
     "The map's pixels are {pixel_mm:.1f} mm where {wanted_mm:.1f} mm were wanted: tiles as large as "
     "that takes do not fit in the memory. Raise --max-memory for a finer map."},
    {RemarkCode::kHeightsMostlyFilled, "heights_mostly_filled",
     "Only {measured_percent:.0f} % of the heights were measured; elsewhere photos do not show the same thing (water, "
     "crowns in the wind, too little overlap) and heights were filled from around (dsm_photos.tif, where it is "
     "written, is 0 there)."},
    {RemarkCode::kNoBands, "no_bands", "There is no bands.tif. {why}"},
    {RemarkCode::kBandLaidAsOthers, "band_laid_as_others",
     "In {failed} of {captures} captures the band {band} could not be laid on the reference by what it shows; "
     "there it stands as in the others."},
    {RemarkCode::kBandLaidAsReference, "band_laid_as_reference",
     "In {failed} of {captures} captures the band {band} could not be laid on the reference by what it shows; "
     "there it stands as the reference does."},
    {RemarkCode::kCapturesNotPlaced, "captures_not_placed",
     "{missing} of {captures} captures of bands were not placed and are not in bands.tif; their reference "
     "photos are among those left out."},
    {RemarkCode::kTargetUnseen, "target_unseen",
     "Target {target} of known reflectance is not used: no capture shows all of it."},
    {RemarkCode::kTargetUneven, "target_uneven",
     "Target {target} of known reflectance is uneven: check its place and radius in {file}."},
    {RemarkCode::kEveryCaptureAPanel, "every_capture_a_panel",
     "Every capture is said to show a calibration panel, by the camera or in {file}: none is taken for one."},
    {RemarkCode::kBandsWithoutPanel, "bands_without_panel",
     "No picture of a calibration panel could be used for {bands}: an index of these bands and others is not "
     "calibrated."},
    {RemarkCode::kAllByImages, "all_by_images",
     "No photo records where it was taken. Where they overlap, they are laid to each other by what they "
     "show; the map is then whole, but lies nowhere on Earth: add the flight log, a geo.txt with "
     "positions or surveyed points (gcp_list.txt) to place it."},
    {RemarkCode::kAllByImagesAndControl, "all_by_images_and_control",
     "No photo records where it was taken. Where they overlap, they are laid to each other by what they "
     "show; the map is then whole and lies where the surveyed points say."},
    {RemarkCode::kSomeByImages, "some_by_images",
     "{photos} photos have no usable position or height: what they show joins them to the others, where "
     "they overlap.",
     "photos",
     "1 photo has no usable position or height: what they show joins them to the others, where they "
     "overlap."},
    {RemarkCode::kLittleOverlap, "little_overlap",
     "Neighbouring photos share only {overlap_percent:.0f} % of their ground: expect gaps and few "
     "places where photos can be matched. 75 % is usual."},
    {RemarkCode::kLeftSameBytes, "left_same_bytes", "The same bytes as {other}; one copy is enough."},
    {RemarkCode::kLeftPanorama, "left_panorama",
     "This is a panorama ({evidence_words}): a map is made of single photos. Give those instead."},
    {RemarkCode::kLeftRawPicture, "left_raw_picture",
     "This is a raw picture ({format}). Give the JPEG that the camera wrote beside it, or export it as JPEG or "
     "TIFF, keeping the metadata."},
    {RemarkCode::kLeftThumbnailFirst, "left_thumbnail_first",
     "The first picture in this TIFF is a thumbnail of a larger one behind it, as in raw pictures. Give "
     "the JPEG that the camera wrote, or export it as JPEG or TIFF, keeping the metadata."},
    {RemarkCode::kLeftCopy, "left_copy",
     "A copy of {other}, which is used: it is nearer to what the camera wrote."},
    {RemarkCode::kLeftOlderMetadata, "left_older_metadata",
     "The file as it was before its metadata were changed; {other}, which has the new ones, is used."},
    {RemarkCode::kLeftOtherCamera, "left_other_camera",
     "Taken by another camera ({camera}) at the same moments as the map's ({instead}). For a map of it "
     "give its pictures alone."},
    {RemarkCode::kLeftThermal, "left_thermal",
     "A thermal picture ({camera}); the map is made of the visible ones ({instead}). For a thermal map "
     "give the thermal pictures alone."},
    {RemarkCode::kLeftVisible, "left_visible",
     "A visible picture ({camera}); the map is made of the thermal ones ({instead}), of which there are "
     "more. For a map of the visible ones give them alone."},
    {RemarkCode::kLeftPanel, "left_panel", "A picture of a calibration panel, not of the ground."},
    {RemarkCode::kLeftWithoutPosition, "left_without_position",
     "has no position: no GPS in its EXIF or XMP and no log that covers it. Add the flight log or a "
     "geo.txt with its position."},
    {RemarkCode::kLeftOutsideLog, "left_outside_log",
     "has no position: no GPS in its EXIF or XMP, and the log does not cover the time it was taken. Add "
     "the log of its flight or a geo.txt with its position."},
    {RemarkCode::kLeftWithoutHeight, "left_without_height",
     "has no usable height above the ground, so its scale is unknown."},
    {RemarkCode::kLeftNoNumbers, "left_no_numbers",
     "has a position, height, angle or focal length that is not a number, or none that can be."},
    {RemarkCode::kLeftFarFromFlight, "left_far_from_flight",
     "was taken {apart_km:.0f} km away from the rest of the flight. If the position is right, stitch it "
     "as a flight of its own."},
    {RemarkCode::kLeftBeyondMaps, "left_beyond_maps",
     "was taken at {lat_deg:.2f} degrees of latitude, and no map is drawn beyond {highest_deg:.0f} "
     "degrees, where web maps (Web Mercator) end."},
    {RemarkCode::kLeftOnTheGround, "left_on_the_ground",
     "stood {height_m:.1f} m above the ground by its recorded height and the ground's. Check what its "
     "height counts from; where the ground differs from take-off, add an elevation model (--dem)."},
    {RemarkCode::kLeftBelowGround, "left_below_ground",
     "stood {height_m:.1f} m below the ground by its recorded height and the ground's. Check what its "
     "height counts from; where the ground differs from take-off, add an elevation model (--dem)."},
    {RemarkCode::kLeftTooMuchGround, "left_too_much_ground",
     "would show {times:.0f} times as much ground as the others, from {height_m:.0f} m above it. If its "
     "height and angles are right, stitch it as a flight of its own."},
    {RemarkCode::kLeftFarAway, "left_far_away",
     "was recorded {apart_km:.1f} km away from the other photos and has nothing in common with them. If "
     "the place is right, make a map of its own from it."},
    {RemarkCode::kLeftNoFeaturesMatch, "left_no_features_match",
     "its features match none of the photos before or after it; --method auto places it by its recorded "
     "pose"},
    {RemarkCode::kLeftBentByChain, "left_bent_by_chain",
     "the chain of homographies bends it beyond what a camera could see; --method auto does not chain"},
    {RemarkCode::kLeftNothingInCommon, "left_nothing_in_common",
     "It shows too little in common with the other photos to be placed by that."},
});

}  // namespace skyquilt::flight
