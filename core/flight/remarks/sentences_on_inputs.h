// The sentences of remarks on what was given: files, photos, lists and logs; remark_sentences.cc joins them
// with the others. Any thread.
#pragma once

#include <array>

#include "core/flight/remarks/remark_words.h"

namespace skyquilt::flight {

inline constexpr std::array kSentencesOnInputs = std::to_array<RemarkSentence>({
    {RemarkCode::kText, "text", "{text_words}"},
    {RemarkCode::kSentences, "sentences", "{first} {then}"},
    {RemarkCode::kOfPhoto, "of_photo", "{photo}: {said}"},
    {RemarkCode::kOfPhotos, "of_photos", "{photos} of {total} photos ({photo} first): {said}"},
    {RemarkCode::kMoreOfPhotos, "more_of_photos",
     "{remarks} more remarks like these on single photos are left out here."},
    {RemarkCode::kOfFile, "of_file", "{file}: {said}"},
    {RemarkCode::kSameFile, "same_file", "{file} is not used: it is the same as {other}."},
    {RemarkCode::kFileNotRead, "file_not_read", "{why}"},
    {RemarkCode::kFilesUnknown, "files_unknown",
     "Not used, because nothing in it is known as a log, a list of positions, surveyed points or "
     "reflectances, or an elevation model: {files}."},
    {RemarkCode::kFilesUnknownAndMore, "files_unknown_and_more",
     "Not used, because nothing in it is known as a log, a list of positions, surveyed points or "
     "reflectances, or an elevation model: {files} and {more} more."},
    {RemarkCode::kElevationModels, "elevation_models",
     "{models} elevation models were given; {file} is taken."},
    {RemarkCode::kElevationModelGiven, "elevation_model_given",
     "{file} is not used: the ground's heights are those of {given}."},
    {RemarkCode::kElevationModelNotRead, "elevation_model_not_read",
     "{file} is not used for the ground's heights. {why}"},
    {RemarkCode::kFilm, "film",
     "{file} is a film. Frames of it become photos when the map is made; they are not looked at here."},
    {RemarkCode::kNoBandsForList, "no_bands_for_list",
     "{file} is not used: the flight has no photos of several bands."},
    {RemarkCode::kPhotosWithoutPosition, "photos_without_position",
     "{photos} of {total} photos carry no usable position."},
    {RemarkCode::kPhotosTimedByName, "photos_timed_by_name",
     "{photos} of {total} photos carry no time in their metadata; the one in their names is taken."},
    {RemarkCode::kPhotosWithoutTime, "photos_without_time",
     "{photos} of {total} photos carry no time; they stand last, by name."},
    {RemarkCode::kPhotosOfUnknownZone, "photos_of_unknown_zone",
     "{photos} of {total} photos have a clock of unknown zone while others have UTC: their order in "
     "time is doubtful."},
    {RemarkCode::kResaved, "resaved",
     "Re-saved by {software}: the picture may have been turned after its angles were recorded."},
    {RemarkCode::kTurnedByExif, "turned_by_exif",
     "EXIF asks viewers to turn the picture (orientation {orientation}); it is used as the sensor stored it."},
    {RemarkCode::kXmpDamaged, "xmp_damaged", "The XMP metadata is damaged and was not used."},
    {RemarkCode::kPositionUnread, "position_unread", "The EXIF position cannot be read."},
    {RemarkCode::kPositionZero, "position_zero", "The EXIF position is 0, 0: the GPS had no fix."},
    {RemarkCode::kPositionNotOnEarth, "position_not_on_earth",
     "The EXIF position (latitude {lat_deg:.6f}, longitude {lon_deg:.6f}) is not on Earth."},
    {RemarkCode::kPositionNotValid, "position_not_valid", "The GPS marked its position as not valid."},
    {RemarkCode::kHemispheresUnsaid, "hemispheres_unsaid",
     "The EXIF position does not say north or south, east or west; north and east were taken."},
    {RemarkCode::kPositionsApart, "positions_apart",
     "EXIF and XMP put the photo {apart_m:.0f} m apart; EXIF was taken."},
    {RemarkCode::kAltitudeImpossible, "altitude_impossible",
     "The EXIF altitude of {altitude_m:.0f} m is impossible and was not used."},
    {RemarkCode::kAltitudeOfTakeoff, "altitude_of_takeoff",
     "The EXIF altitude is the height above take-off; it was not taken as height above the sea."},
    {RemarkCode::kAltitudeRepeatsHeight, "altitude_repeats_height",
     "The EXIF altitude repeats the height above take-off and was not taken as height above the sea."},
    {RemarkCode::kAltitudesApart, "altitudes_apart",
     "EXIF says {exif_m:.0f} m above the sea, XMP {xmp_m:.0f} m; neither should be trusted."},
    {RemarkCode::kClocksDisagree, "clocks_disagree",
     "The camera's clock and the GPS time disagree; the GPS time was taken."},
    {RemarkCode::kAnglesImpossible, "angles_impossible",
     "The angles of {tags} are impossible and were not used."},
    {RemarkCode::kAnglesZero, "angles_zero",
     "The angles of {tags} are all exactly zero, which devices write that do not know them; not used."},
    {RemarkCode::kHeadingAlone, "heading_alone",
     "The camera's angles are not recorded: the heading is the aircraft's, and the camera was taken to look "
     "straight down."},
    {RemarkCode::kGyroNotUsed, "gyro_not_used", "The gyro's records in the photo {why} and were not used."},
    {RemarkCode::kGyroAtImpossibleTime, "gyro_at_impossible_time", "begin at an impossible time"},
    {RemarkCode::kGyroDamaged, "gyro_damaged", "are damaged"},
    {RemarkCode::kGyroTooShort, "gyro_too_short", "are too few"},
    {RemarkCode::kGyroImpossibleRates, "gyro_impossible_rates", "tell of impossible rates"},
    {RemarkCode::kGyroBackwards, "gyro_backwards", "run backwards"},
    {RemarkCode::kGyroWithGaps, "gyro_with_gaps", "have gaps"},
    {RemarkCode::kFisheyeAsPlain, "fisheye_as_plain",
     "The lens is a fisheye; it is treated as a plain one until the photos are aligned."},
    {RemarkCode::kFisheyeFitted, "fisheye_fitted",
     "The lens is a fisheye, whose calibration the lens model fits within {worst_px:.1f} px."},
    {RemarkCode::kSizeNotAsRecorded, "size_not_as_recorded",
     "The camera recorded an image of {recorded_px} px, this one has {side_px} px: taken as a crop with the "
     "same pixel size, unless the images say otherwise."},
    {RemarkCode::kSensorOfWrongUnit, "sensor_of_wrong_unit",
     "By its focal plane resolution the sensor would be {written_mm:.1f} mm wide, and it is {sensor_mm:.1f} mm "
     "as {known}: its unit is wrong (inches for centimetres, or the like), and it is left aside."},
    {RemarkCode::kSensorAsKnown, "sensor_as_known", "the camera's sensor is known"},
    {RemarkCode::kSensorByEquivalent, "sensor_by_equivalent", "the 35 mm equivalent says"},
    {RemarkCode::kSensorImpossible, "sensor_impossible",
     "By its focal plane resolution the sensor would be {written_mm:.1f} mm wide, which hardly any is: it is "
     "left aside."},
    {RemarkCode::kNoFocalLength, "no_focal_length",
     "No focal length is recorded: a usual drone lens (60 to 70 degrees wide) is the first guess, which the "
     "images refine."},
    {RemarkCode::kOtherCameraAside, "other_camera_aside",
     "The map is made of one camera ({instead}); {pictures} pictures of another ({camera}) lie aside: "
     "both saw the same moments.",
     "pictures",
     "The map is made of one camera ({instead}); 1 picture of another ({camera}) lies aside: both saw "
     "the same moments."},
    {RemarkCode::kThermalAside, "thermal_aside",
     "The map is made of one camera ({instead}); {pictures} pictures of another ({camera}) lie aside: "
     "thermal and visible pictures do not mix.",
     "pictures",
     "The map is made of one camera ({instead}); 1 picture of another ({camera}) lies aside: thermal "
     "and visible pictures do not mix."},
    {RemarkCode::kVisibleAside, "visible_aside",
     "The map is made of one camera ({instead}); {pictures} pictures of another ({camera}) lie aside: "
     "there are more thermal than visible pictures.",
     "pictures",
     "The map is made of one camera ({instead}); 1 picture of another ({camera}) lies aside: there are "
     "more thermal than visible pictures."},
    {RemarkCode::kReadingSystem, "reading_system", "{system}"},
    {RemarkCode::kReadingDegreesEastFirst, "reading_degrees_east_first", "longitude, latitude in degrees"},
    {RemarkCode::kReadingDegreesNorthFirst, "reading_degrees_north_first", "latitude, longitude in degrees"},
    {RemarkCode::kReadingDegreesAsNamed, "reading_degrees_as_named",
     "latitude and longitude in degrees, as its columns are named"},
    {RemarkCode::kReadingDegreesAgainstNames, "reading_degrees_against_names",
     "degrees, the column named latitude as longitude and the other way round"},
    {RemarkCode::kReadingUtm, "reading_utm", "WGS 84 / UTM zone {zone} (EPSG:{epsg})"},
    {RemarkCode::kReadingNorthFirst, "reading_north_first", ", north before east"},
    {RemarkCode::kReadingWestPositive, "reading_west_positive", ", west counted as positive"},
    {RemarkCode::kReadingSouthPositive, "reading_south_positive", ", south counted as positive"},
    {RemarkCode::kOwnLists, "own_lists", "where the other lists and tracks place the flight"},
    {RemarkCode::kOwnPhotos, "own_photos", "the photos' own positions"},
    {RemarkCode::kOwnRecords, "own_records", "where the photos were taken by their own records"},
    {RemarkCode::kListNamesNoPhoto, "list_names_no_photo",
     "{file} is not used: its rows name {rows} photos (the first is {first}), and none of the photos "
     "given is called so.",
     "rows",
     "{file} is not used: its rows name 1 photo (the first is {first}), and none of the photos given is "
     "called so."},
    {RemarkCode::kListRowsOfSeveralPhotos, "list_rows_of_several_photos",
     "{file}: of {rows} rows (the first is {first}) it is not told which photo is meant, for several folders have "
     "one of that name: write the folders into the list too, as in 100MEDIA/{first}.",
     "rows",
     "{file}: of 1 row ({first}) it is not told which photo is meant, for several folders have one of that name: "
     "write the folders into the list too, as in 100MEDIA/{first}."},
    {RemarkCode::kListAnglesContradict, "list_angles_contradict",
     "{file}: its angles lie {apart_deg:.0f} degrees (median of {photos} photos) from those that the cameras' own "
     "gimbals recorded, as the airframe's do, and are not taken; its positions are.",
     "photos",
     "{file}: its angles lie {apart_deg:.0f} degrees from those that the camera's own gimbal recorded, as the "
     "airframe's do, and are not taken; its positions are."},
    {RemarkCode::kListReadInUnnamedZone, "list_read_in_unnamed_zone",
     "{file}: read as {reading}, which it does not name: so it lies {apart_m:length} from {own}."},
    {RemarkCode::kListReadOtherwise, "list_read_otherwise",
     "{file}: read as {reading}: as written it would lie {apart_m:length} from {own}."},
    {RemarkCode::kListReadOtherwiseOutsideSystem, "list_read_otherwise_outside_system",
     "{file}: read as {reading}: as written its rows are no places within {system}."},
    {RemarkCode::kListReadOtherwiseNowhere, "list_read_otherwise_nowhere",
     "{file}: read as {reading}: as written its rows are no places on Earth."},
    {RemarkCode::kListOrderAssumed, "list_order_assumed",
     "{file}: read as {reading}, the order of its format: nothing else says where the flight was, and "
     "the other way round it would lie {apart_m:length} away. Check the map's place; a line of column "
     "names (image longitude latitude) settles it."},
    {RemarkCode::kListOutsideArea, "list_outside_area",
     "{file}: read as {reading}, though it lies outside the area that this system is made for. Check "
     "the map's place, and the system."},
    {RemarkCode::kListFarFromOthers, "list_far_from_others",
     "{file}: read as {reading}, it lies {apart_m:length} from {own}. It is believed all the same; if "
     "they are right, leave it out."},
    {RemarkCode::kPointsWithoutSystem, "points_without_system",
     "{file} is not used: it names no reference system, so that its numbers are no places: write one "
     "into its first line, such as EPSG:4326 (longitude, latitude), EPSG:32632 (WGS 84 / UTM zone 32N) "
     "or the EPSG code of the survey."},
    {RemarkCode::kPointsWithoutSystemApart, "points_without_system_apart",
     "{file} is not used: it names no reference system, so that its numbers are no places: write one "
     "into its first line, such as EPSG:4326 (longitude, latitude), EPSG:32632 (WGS 84 / UTM zone 32N) "
     "or the EPSG code of the survey; read as {reading} its points would lie {apart_m:length} from "
     "{own}."},
    {RemarkCode::kListWithoutSystem, "list_without_system",
     "{file} is not used: its numbers are metres of a projected system that it does not name: write the "
     "system's EPSG code, such as EPSG:32632, into a first line of its own."},
    {RemarkCode::kListWithoutSystemApart, "list_without_system_apart",
     "{file} is not used: its numbers are metres of a projected system that it does not name, and as "
     "{reading} they would lie {apart_m:length} from {own}: write the system's EPSG code, such as "
     "EPSG:32632, into a first line of its own."},
    {RemarkCode::kListNowhere, "list_nowhere",
     "{file} is not used: most of its {rows} rows are no places on Earth, whichever way the two numbers "
     "are read."},
    {RemarkCode::kListOutsideSystem, "list_outside_system",
     "{file} is not used: most of its {rows} rows are no places in {system}, whichever way the two "
     "numbers are read."},
    {RemarkCode::kListFarFromPhotos, "list_far_from_photos",
     "{file} is not used: read as {reading}, which comes nearest, it lies {apart_m:length} from {own}, "
     "further than any receiver errs. Is it the list of another flight, or names another reference "
     "system? Without it the photos' own positions hold."},
    {RemarkCode::kListFarFromLists, "list_far_from_lists",
     "{file} is not used: read as {reading}, which comes nearest, it lies {apart_m:length} from {own}, "
     "further than a flight reaches. Is it the list of another flight, or names another reference "
     "system? Check which of the files is of this flight."},
    {RemarkCode::kListOfOtherShape, "list_of_other_shape",
     "{file} is not used: its rows are laid out otherwise than {own}: shifted as a whole to fit, half "
     "of them still lie more than {off_m:length} off. Is it the list of another flight with the same "
     "names, or are its rows in another order? Without it the photos' own positions hold."},
    {RemarkCode::kListOfOtherShapeThanLists, "list_of_other_shape_than_lists",
     "{file} is not used: its rows are laid out otherwise than {own}: shifted as a whole to fit, half "
     "of them still lie more than {off_m:length} off. Is it the list of another flight with the same "
     "names, or are its rows in another order? Check which of the files is of this flight."},
    {RemarkCode::kLogEmpty, "log_empty",
     "{file} is not used: it was read as a log ({format}), but no row of it holds a position, an "
     "attitude, inertial samples or a photo together with its time."},
    {RemarkCode::kLogAddsNothing, "log_adds_nothing",
     "{file} is not used: the other logs cover the same time with all that it holds."},
    {RemarkCode::kLogWithoutUtc, "log_without_utc",
     "{file} is not used: {without} does not say its UTC, so that the two cannot be laid side by side. "
     "Give one of them alone."},
    {RemarkCode::kLogOfOtherSeconds, "log_of_other_seconds",
     "{file} is not used: its times ({from_s:.1f} to {until_s:.1f} s) are not those of {other} "
     "({other_from_s:.1f} to {other_until_s:.1f} s), and {without} does not say its UTC, so that the "
     "two cannot be laid side by side. Let both count the same seconds."},
    {RemarkCode::kLogOfOtherTime, "log_of_other_time",
     "{file} is not used: none of the photos was taken in the time that it covers. Give the log of this "
     "flight."},
    {RemarkCode::kLogUnusable, "log_unusable", "The log could not be used: {why}"},
    {RemarkCode::kAnglesReadOtherwise, "angles_read_otherwise",
     "As recorded, the camera angles would not show the ground: {reading_words}."},
});

}  // namespace skyquilt::flight
