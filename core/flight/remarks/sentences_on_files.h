// The sentences of remarks on why a file, a film or a picture is not used, or not all of it, and why photos
// are not tied to a log; remark_sentences.cc joins them with the others. Any thread.
#pragma once

#include <array>

#include "core/flight/remarks/remark_words.h"

namespace skyquilt::flight {

inline constexpr std::array kSentencesOnFiles = std::to_array<RemarkSentence>({
    {RemarkCode::kHeicPicture, "heic_picture",
     "This is a HEIC picture. Convert it to JPEG, keeping the metadata."},
    {RemarkCode::kWebpPicture, "webp_picture",
     "This is a WebP picture. Convert it to JPEG, keeping the metadata."},
    {RemarkCode::kIsVideo, "is_video", "This is a video. Photos must be JPEG, TIFF or PNG."},
    {RemarkCode::kIsArchive, "is_archive",
     "This is a ZIP archive. Unpack it first. Photos must be JPEG, TIFF or PNG."},
    {RemarkCode::kIsText, "is_text",
     "This is a text file, whatever its name. Photos must be JPEG, TIFF or PNG."},
    {RemarkCode::kIsNoPicture, "is_no_picture",
     "This is not a picture that can be read. Photos must be JPEG, TIFF or PNG."},
    {RemarkCode::kPhotoEmpty, "photo_empty", "The file is empty. Copy it from the camera again."},
    {RemarkCode::kPhotoUnread, "photo_unread", "The file cannot be read from the disk."},
    {RemarkCode::kFileUnread, "file_unread", "The file {file} cannot be read: {system_words}."},
    {RemarkCode::kFileIrregular, "file_irregular",
     "{file} is no regular file (a pipe, a socket or a device); give the file itself."},
    {RemarkCode::kJpegCutOff, "jpeg_cut_off",
     "The JPEG is cut off: its end is missing. Copy the file from the camera again."},
    {RemarkCode::kJpegWithoutSize, "jpeg_without_size",
     "The JPEG ends before its image size was found. The file is damaged or cut off; copy it from "
     "the camera again."},
    {RemarkCode::kTiffWithoutSize, "tiff_without_size",
     "The TIFF does not say how large its image is; it cannot be read."},
    {RemarkCode::kTiffCutOff, "tiff_cut_off",
     "The TIFF is cut off: part of its picture is missing. Copy the file from the camera again."},
    {RemarkCode::kTiffTagsDamaged, "tiff_tags_damaged",
     "The TIFF's list of tags cannot be read. The file is damaged or cut off; copy it from the "
     "camera again."},
    {RemarkCode::kTiffNotRead, "tiff_not_read",
     "The TIFF holds {what_words}, which is not read. {instead_words}"},
    {RemarkCode::kPngDamaged, "png_damaged", "The PNG is damaged or cut off. Copy the file again."},
    {RemarkCode::kPictureTooLarge, "picture_too_large",
     "The image says it has {width_px} x {height_px} pixels; at most {most_side_px} a side and "
     "{most_million_px:.0f} million in all are read."},
    {RemarkCode::kPictureTooSmall, "picture_too_small",
     "The image has only {width_px} x {height_px} pixels: no aerial photo."},
    {RemarkCode::kPictureDamaged, "picture_damaged",
     "The picture is damaged or cut off and cannot be decoded. Copy the file from the camera "
     "again."},
    {RemarkCode::kPictureTakesTooMuch, "picture_takes_too_much",
     "Decoding the picture takes {needed_mib:.0f} MiB, and {left_mib:.0f} MiB are left for it. "
     "Raise --max-memory, or save it as a JPEG that is not progressive."},
    {RemarkCode::kPictureWithoutNumbers, "picture_without_numbers",
     "The picture holds no measurement: none of its samples is a number that one can be."},
    {RemarkCode::kFileEmpty, "file_empty", "{file} is empty; copy it from the aircraft again."},
    {RemarkCode::kFileEncrypted, "file_encrypted",
     "{file} is a DJI flight record, which is encrypted; export it as CSV (AirData) and add that"},
    {RemarkCode::kFileIsNoLog, "file_is_no_log", "{file} is no flight log of a kind that is read."},
    {RemarkCode::kFileNamedAsLog, "file_named_as_log",
     "{file} is named like a flight log but is none that can be read; copy it again."},
    {RemarkCode::kFileWithoutTimes, "file_without_times",
     "{file} has no row with a time; fill the column t (seconds) or utc."},
    {RemarkCode::kTableWithoutTimes, "table_without_times", "{file} has no row with a time."},
    {RemarkCode::kTableTimesUnread, "table_times_unread", "{file} has no row with a time: {why}."},
    {RemarkCode::kTableWithoutNames, "table_without_names",
     "{file} is a table, but not used: line {line}, {text}, holds no names of columns and is no list "
     "that is read without them. Write names above it as in time_s, lat_deg, lon_deg, alt_m "
     "(positions), time_s, photo (exposures) or image, lat_deg, lon_deg, alt_m (photos)."},
    {RemarkCode::kTableLacks, "table_lacks",
     "{file} is a table, but not used: {missing}{columns}. Name its columns as in time_s, lat_deg, "
     "lon_deg, alt_m (positions), time_s, photo (exposures) or image, lat_deg, lon_deg, alt_m (photos)."},
    {RemarkCode::kLacksLongitude, "lacks_longitude",
     "it has a latitude, but no column of it is recognised as a longitude"},
    {RemarkCode::kLacksLatitude, "lacks_latitude",
     "it has a longitude, but no column of it is recognised as a latitude"},
    {RemarkCode::kLacksTimeOrNames, "lacks_time_or_names",
     "no column of it is recognised as a time, or as the names of photos"},
    {RemarkCode::kLacksTime, "lacks_time", "no column of it is recognised as a time"},
    {RemarkCode::kLacksWhatIsTimed, "lacks_what_is_timed",
     "beside the time it has no position, attitude, inertial samples or photo's name that is recognised"},
    {RemarkCode::kColumnsKnown, "columns_known", "; recognised are {columns}"},
    {RemarkCode::kColumnsUnknown, "columns_unknown", "; not recognised are {columns}"},
    {RemarkCode::kColumnsUnknownAndMore, "columns_unknown_and_more",
     "; not recognised are {columns}, {more_columns}"},
    {RemarkCode::kColumnShown, "column_shown", "{column} ({cell} in line {line})"},
    {RemarkCode::kAndColumnShown, "and_column_shown", ", {column} ({cell} in line {line})"},
    {RemarkCode::kLikeListOfPlaces, "like_list_of_places",
     "{file} looks like a list of positions, but is not used: column {column} of line {line} {what}. "
     "Its rows are \"image x y z\" below a line such as EPSG:4326, or image,latitude,longitude,height."},
    {RemarkCode::kLikeListOfPoints, "like_list_of_points",
     "{file} looks like a list of surveyed points, but is not used: column {column} of line {line} "
     "{what}. Its rows are \"x y z pixel_x pixel_y image\" below a line such as EPSG:32632."},
    {RemarkCode::kCellMissing, "cell_missing", "is missing"},
    {RemarkCode::kCellNoNumber, "cell_no_number", "is no number: {cell}"},
    {RemarkCode::kFileNamesNoPhoto, "file_names_no_photo", "{file} names no photo in its rows."},
    {RemarkCode::kFileNamesNoPlace, "file_names_no_place", "{file} names no photo with a position."},
    {RemarkCode::kFileWithoutRows, "file_without_rows", "{file} holds no readable row."},
    {RemarkCode::kFileWithoutHeader, "file_without_header",
     "{file} has no header with a time and a position, an attitude, an IMU or photos."},
    {RemarkCode::kFileLacksColumns, "file_lacks_columns", "{file} lacks the columns {columns}."},
    {RemarkCode::kFileIsPointList, "file_is_point_list",
     "{file} is a list of ground control points, not a flight log."},
    {RemarkCode::kTextTooLarge, "text_too_large",
     "{file} is UTF-16 of {size_mib} MiB, and at most {most_mib} MiB of it are read; save it as UTF-8."},
    {RemarkCode::kCommasUnclear, "commas_unclear",
     "{file} has {cells} cells in line {line} below {headers} names of columns, and no decimal "
     "point: its decimal commas cannot be told from the commas between cells; save it with "
     "semicolons or tabs between the cells, or with decimal points."},
    {RemarkCode::kTableNotUsed, "table_not_used", "{file} is not used. {why}"},
    {RemarkCode::kColumnContradicts, "column_contradicts", "Column {column}: {why}; correct its header."},
    {RemarkCode::kUnitMakesGravity, "unit_makes_gravity",
     "its unit {unit} makes gravity {gravity_mps2:.3g} m/s2 instead of 9.8"},
    {RemarkCode::kGravityOfNoUnit, "gravity_of_no_unit",
     "the median specific force is {force:.3g}, which is gravity in no unit (is gravity removed?)"},
    {RemarkCode::kGravityOffAxis, "gravity_off_axis",
     "gravity does not lie along the z axis: the axes must be forward, right, down (or forward, left, up)"},
    {RemarkCode::kRatesLookLikeDegrees, "rates_look_like_degrees",
     "its unit {unit} does not fit the attitude: the rates look like degrees per second"},
    {RemarkCode::kTimesFall, "times_fall", "its values fall, so they are not times"},
    {RemarkCode::kIsNoLatitude, "is_no_latitude", "{degrees:.6g} is no latitude"},
    {RemarkCode::kIsNoLongitude, "is_no_longitude", "{degrees:.6g} is no longitude"},
    {RemarkCode::kGeoTxtEmpty, "geo_txt_empty",
     "{file} names no photo with a position; rows are \"image x y z\" below a line such as "
     "EPSG:4326."},
    {RemarkCode::kSystemUnknown, "system_unknown",
     "{file}: {system} names no reference system that is known; write its EPSG code (EPSG:32615), a "
     "name such as WGS84 UTM 15N, a +proj= string or WKT."},
    {RemarkCode::kPointsEmpty, "points_empty",
     "{file} holds no ground control point; rows are \"x y z pixel_x pixel_y image\" below a line "
     "such as EPSG:32615"},
    {RemarkCode::kPointsOutsideSystem, "points_outside_system",
     "{file} holds no ground control point that lies within {system}"},
    {RemarkCode::kPointsNameNoSystem, "points_name_no_system",
     "{file} names no reference system, so that its numbers are no places: write one into its first "
     "line, such as EPSG:4326 (longitude, latitude), EPSG:32632 (WGS 84 / UTM zone 32N) or the EPSG "
     "code of the survey."},
    {RemarkCode::kMrkEmpty, "mrk_empty",
     "{file} holds no exposure row; copy it from the camera's card again."},
    {RemarkCode::kSolutionEmpty, "solution_empty",
     "{file} holds no solution; run the post-processing again."},
    {RemarkCode::kSubtitlesEmpty, "subtitles_empty",
     "{file} holds no subtitle; copy it from the camera's card again."},
    {RemarkCode::kSubtitlesWithoutPlace, "subtitles_without_place",
     "{file} holds no position that can be read: the first of its {cues} subtitles says {text}. "
     "Switch on video captions in the camera's settings."},
    {RemarkCode::kDataflashEmpty, "dataflash_empty",
     "{file} holds no readable DataFlash message; copy it from the aircraft again."},
    {RemarkCode::kTlogEmpty, "tlog_empty",
     "{file} holds no readable MAVLink packet; save the telemetry log again."},
    {RemarkCode::kUlogEmpty, "ulog_empty",
     "{file} is a ULog without any data; copy it from the aircraft again."},
    {RemarkCode::kUlogBeginsOtherwise, "ulog_begins_otherwise", "{file} does not start as a ULog does."},
    {RemarkCode::kNmeaWithoutFix, "nmea_without_fix", "{file} holds no sentence with a fix (GGA, GNS, RMC)."},
    {RemarkCode::kNmeaDamaged, "nmea_damaged",
     "{file} holds no sentence with a fix (GGA, GNS, RMC). {wrong} sentences have a wrong checksum, "
     "first in line {line}: {sentence}.",
     "wrong",
     "{file} holds no sentence with a fix (GGA, GNS, RMC). 1 sentence has a wrong checksum, first in "
     "line {line}: {sentence}."},
    {RemarkCode::kJsonDamaged, "json_damaged",
     "{file} is not used: it is no JSON from byte {byte} on. Export it again."},
    {RemarkCode::kJsonTooDeep, "json_too_deep",
     "{file} is not used: its values are nested more than {most} deep."},
    {RemarkCode::kTrackNotUsed, "track_not_used", "{file} is not used: {why}."},
    {RemarkCode::kTrackEmpty, "track_empty", "{file} is not used: it holds no point of a track."},
    {RemarkCode::kTrackWithoutPlaces, "track_without_places",
     "{file} is not used: none of its {points} points has a latitude and a longitude in degrees."},
    {RemarkCode::kTrackWithoutTimes, "track_without_times",
     "{file} is not used: its {points} points have no times, so that no photo can be placed by them. "
     "Export the track with the time of each point.",
     "points",
     "{file} is not used: its 1 point has no times, so that no photo can be placed by them. Export "
     "the track with the time of each point."},
    {RemarkCode::kTrackTimesUnread, "track_times_unread",
     "{file} is not used: {unread} of its {points} points have a time that cannot be read, first "
     "{first}. Write times as 2016-06-23T21:31:09Z."},
    {RemarkCode::kTrackNothingPlaced, "track_nothing_placed",
     "{file} is not used: none of its {points} points has both a time and a position with a fix."},
    {RemarkCode::kKmzNotRead, "kmz_not_read",
     "{file} is not used: it is a zip around a KML file. Unzip it and give the .kml that is in it."},
    {RemarkCode::kNamedAsGpx, "named_as_gpx",
     "{file} is not used: it is named like a GPX track, but lacks an element <gpx> at its beginning; "
     "{begins}."},
    {RemarkCode::kNamedAsKml, "named_as_kml",
     "{file} is not used: it is named like a KML track, but lacks an element <kml> at its beginning; "
     "{begins}."},
    {RemarkCode::kNamedAsGeojson, "named_as_geojson",
     "{file} is not used: it is named like a GeoJSON track, but lacks a Feature or FeatureCollection "
     "at its beginning; {begins}."},
    {RemarkCode::kNamedAsNmea, "named_as_nmea",
     "{file} is not used: it is named like an NMEA recording, but lacks a sentence ($GPGGA, $GNRMC) "
     "in its first 200 lines; {begins}."},
    {RemarkCode::kNamedAsSrt, "named_as_srt",
     "{file} is not used: it is named like a file of subtitles, but lacks a line like 00:00:01,000 "
     "--> 00:00:02,000 in its first 8; {begins}."},
    {RemarkCode::kNamedAsAss, "named_as_ass",
     "{file} is not used: it is named like a file of subtitles, but lacks [Script Info], [Events] or "
     "Dialogue in its first line; {begins}."},
    {RemarkCode::kFirstLineIs, "first_line_is", "its first line is {text}"},
    {RemarkCode::kFirstBytesNoText, "first_bytes_no_text", "its first bytes are no text"},
    {RemarkCode::kShapesWithoutTimes, "shapes_without_times",
     "{file} is not used: it holds {shapes} lines or areas, which have no times, and no track "
     "that has (gx:Track, or a Placemark with TimeStamp and Point). An area that the map is to be "
     "cut to is given by --boundary."},
    {RemarkCode::kReflectancesWithoutColumns, "reflectances_without_columns",
     "{file} has no columns by which its rows are found: give photo (with left, top, right and "
     "bottom in pixels where the panel's code cannot be read), or lat, lon and radius_m."},
    {RemarkCode::kReflectancesUnused, "reflectances_unused", "{file} has no row that can be used."},
    {RemarkCode::kReflectancesUnusedAs, "reflectances_unused_as",
     "{file} has no row that can be used ({why})."},
    {RemarkCode::kReflectancesTooLarge, "reflectances_too_large",
     "{file} is larger than a list of panels is."},
    {RemarkCode::kOfLine, "of_line", "line {line}: {why}"},
    {RemarkCode::kOnlyFirstRows, "only_first_rows", "only its first {most} rows are read"},
    {RemarkCode::kIsNoNumber, "is_no_number", "{cell} is no number"},
    {RemarkCode::kIsNoReflectance, "is_no_reflectance", "{cell} is no reflectance between 0 and 1"},
    {RemarkCode::kBoxIncomplete, "box_incomplete", "left, top, right and bottom belong together"},
    {RemarkCode::kBoxReversed, "box_reversed", "right is not beyond left, or bottom not below top"},
    {RemarkCode::kRowNamesNoTarget, "row_names_no_target",
     "it has neither a photo nor lat, lon and radius_m"},
    {RemarkCode::kPlaceNotOnEarth, "place_not_on_earth", "its place is not on Earth"},
    {RemarkCode::kRadiusImpossible, "radius_impossible", "its radius is not between 0 and {most_m} m"},
    {RemarkCode::kRowWithoutReflectance, "row_without_reflectance", "it names no reflectance"},
    {RemarkCode::kOnlyFirstTargets, "only_first_targets", "only the first {most} targets count"},
    {RemarkCode::kElevationsRefused, "elevations_refused",
     "The elevation model {model} {why_words}. Give a GeoTIFF of heights in metres."},
    {RemarkCode::kElevationsOfMorePictures, "elevations_of_more_pictures",
     "The elevation model {model} holds more than {most} pictures; give a GeoTIFF with one."},
    {RemarkCode::kNoFilm, "no_film",
     "{file} is no film that can be read. Give an MP4 or MOV as the camera wrote it, or its "
     "frames as JPEGs."},
    {RemarkCode::kFilmDamaged, "film_damaged", "{file} is damaged. Copy it from the camera again."},
    {RemarkCode::kFilmTooLarge, "film_too_large",
     "{file} has frames of {width_px} x {height_px} pixels; films may have up to {most_side_px} a "
     "side."},
    {RemarkCode::kFilmFull, "film_full",
     "{file}: {frames} frames were taken, up to {until_s:.0f} s; what comes later is not used. "
     "Cut the film into parts."},
    {RemarkCode::kBandUnnamed, "band_unnamed",
     "The photo does not name its band (BandName in its XMP). Give the files as the camera wrote "
     "them."},
    {RemarkCode::kBandOfOtherNumbers, "band_of_other_numbers",
     "The picture of a band has more than one channel, or numbers other than whole ones of 8 or 16 "
     "bits. Give the file as the camera wrote it."},
    {RemarkCode::kThermalOfUnknownScale, "thermal_of_unknown_scale",
     "A thermal picture that does not say how many kelvins a level is (FLIR:TLinearGain in its "
     "XMP)."},
    {RemarkCode::kThermalWithoutLevels, "thermal_without_levels",
     "The JPEG holds no levels of a sensor beside its picture. Give the file as the camera wrote it."},
    {RemarkCode::kThermalOfOtherShape, "thermal_of_other_shape",
     "The thermal sensor's levels are of another shape than the JPEG's picture, which shows "
     "something else. Set the camera to store the thermal picture."},
    {RemarkCode::kTemperaturesDamaged, "temperatures_damaged",
     "The temperatures in the picture (its FLIR segments) are damaged or cut off. Copy the file from "
     "the camera again, as the camera wrote it."},
    {RemarkCode::kCaptureWithoutReference, "capture_without_reference",
     "Its capture has no picture of the band {band}, by which the bands are placed. Add the "
     "missing file."},
    {RemarkCode::kBandsOddlyCalibrated, "bands_oddly_calibrated",
     "{photos} photos of bands give no values to bands.tif: tags lack what makes levels values, "
     "or have it where those of most others lack it.",
     "photos",
     "1 photo of a band gives no values to bands.tif: tags lack what makes levels values, or have "
     "it where those of most others lack it."},
    {RemarkCode::kBandWithoutValues, "band_without_values", "{photo} gives no values to bands.tif. {why}"},
    {RemarkCode::kNoTemperatures, "no_temperatures",
     "{photos} thermal photos give no temperatures. {why_words}"},
    {RemarkCode::kAllShowPanels, "all_show_panels",
     "All captures show a calibration panel; without one of the ground alone none is taken for a "
     "panel's."},
    {RemarkCode::kPanelsUnused, "panels_unused",
     "{pictures} pictures of calibration panels are not used. {photo}: {why}", "pictures",
     "1 picture of a calibration panel is not used. {photo}: {why}"},
    {RemarkCode::kPanelNotExposed, "panel_not_exposed",
     "it does not say how it was exposed, so that nothing follows for other photos."},
    {RemarkCode::kPanelOtherValues, "panel_other_values",
     "its values are {values_words}, those of the photos of the ground {others_words}: of one of "
     "them the light sensor wrote nothing."},
    {RemarkCode::kPanelWithoutCode, "panel_without_code",
     "no code of a panel can be read in it; say where the panel is in a {list} (photo, left, top, "
     "right, bottom)."},
    {RemarkCode::kPanelUnknown, "panel_unknown",
     "the reflectance of {panel} is not known; give it in a {list} (photo, reflectance)."},
    {RemarkCode::kPanelTooSmall, "panel_too_small",
     "the panel's area is too small, or reaches beyond the picture."},
    {RemarkCode::kPanelOverexposed, "panel_overexposed", "the panel is overexposed in it."},
    {RemarkCode::kPanelUneven, "panel_uneven",
     "what it shows there is not even: a shadow lies on it, or it is no panel."},
    {RemarkCode::kPanelBlack, "panel_black", "the panel is black in it."},
    {RemarkCode::kPanelsApart, "panels_apart",
     "The pictures of the panel say different things of the band {band}: its reflectance is "
     "{apart_percent:.0f} % apart between them. Their median counts; the light changed, or a "
     "shadow lay on one."},
    {RemarkCode::kTargetsApart, "targets_apart",
     "Targets of known reflectance say different things of the band {band}: its reflectance is "
     "{apart_percent:.0f} % apart between them. Their median counts; the light changed, or a "
     "shadow lay on one."},
    {RemarkCode::kNotTiedNoEvents, "not_tied_no_events",
     "{photos} photos cannot be tied to {file} ({positions} positions): give photos with capture "
     "times, a log with camera events, or set the camera's clock.",
     "photos",
     "1 photo cannot be tied to {file} ({positions} positions): give photos with capture times, a "
     "log with camera events, or set the camera's clock."},
    {RemarkCode::kNotTiedToEvents, "not_tied_to_events",
     "{photos} photos cannot be tied to {file}, which holds {events} camera events: {why}. Give "
     "the photos and the events of one flight, as many of the one as of the other.",
     "photos",
     "1 photo cannot be tied to {file}, which holds {events} camera events: {why}. Give the "
     "photos and the events of one flight, as many of the one as of the other."},
    {RemarkCode::kFitsElsewhere, "fits_elsewhere",
     "the intervals hardly vary, so that the events fit as well {open_s:.1f} s later or earlier, "
     "and nothing says which event is which photo's"},
    {RemarkCode::kOtherIntervals, "other_intervals",
     "the intervals between the photos are not those between the events"},
    {RemarkCode::kOtherNumbers, "other_numbers", "the photos carry no capture times, and the numbers differ"},
    {RemarkCode::kSensorsContradict, "sensors_contradict",
     "The flight's sensors contradict each other so much that no track can be fitted; leave out "
     "the log or the damaged part of it."},
    {RemarkCode::kMoreThanADay, "more_than_a_day",
     "The photos and markers of this flight lie more than a day apart; stitch each flight on its "
     "own."},
    {RemarkCode::kTrackNotFixed, "track_not_fixed",
     "The flight's sensors do not fix its track; add a log with positions."},
    {RemarkCode::kNothingToStartFrom, "nothing_to_start_from",
     "Nothing says where this flight was: no positions in photos or log, and no start point. Give "
     "the log of the flight, or where it took off."},
});

}  // namespace skyquilt::flight
