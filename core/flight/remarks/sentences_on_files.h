// The sentences of remarks on why a file, a film or a picture is not used, or not all of it; remark_sentences.cc
// joins them with the others. Any thread.
#pragma once

#include <array>

#include "core/flight/remarks/remark_words.h"

namespace skyquilt::flight {

inline constexpr std::array kSentencesOnFiles = std::to_array<RemarkSentence>({
    {RemarkCode::kHeicPicture, "heic_picture",
     "This is a HEIC picture. Convert it to JPEG, keeping the metadata."},
    {RemarkCode::kWebpPicture, "webp_picture",
     "This is a WebP picture. Convert it to JPEG, keeping the metadata."},
    {RemarkCode::kIsVideo, "is_video",
     "This is a video. Photos must be JPEG, TIFF or PNG."},
    {RemarkCode::kIsArchive, "is_archive",
     "This is a ZIP archive. Unpack it first. Photos must be JPEG, TIFF or PNG."},
    {RemarkCode::kIsText, "is_text",
     "This is a text file, whatever its name. Photos must be JPEG, TIFF or PNG."},
    {RemarkCode::kIsNoPicture, "is_no_picture",
     "This is not a picture that can be read. Photos must be JPEG, TIFF or PNG."},
    {RemarkCode::kPhotoEmpty, "photo_empty",
     "The file is empty. Copy it from the camera again."},
    {RemarkCode::kPhotoUnread, "photo_unread",
     "The file cannot be read from the disk."},
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
    {RemarkCode::kPngDamaged, "png_damaged",
     "The PNG is damaged or cut off. Copy the file again."},
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
    {RemarkCode::kFileEmpty, "file_empty",
     "{file} is empty; copy it from the aircraft again."},
    {RemarkCode::kFileEncrypted, "file_encrypted",
     "{file} is a DJI flight record, which is encrypted; export it as CSV (AirData) and add that"},
    {RemarkCode::kFileIsNoLog, "file_is_no_log",
     "{file} is no flight log of a kind that is read."},
    {RemarkCode::kFileNamedAsLog, "file_named_as_log",
     "{file} is named like a flight log but is none that can be read; copy it again."},
    {RemarkCode::kFileWithoutTimes, "file_without_times",
     "{file} has no row with a time; fill the column t (seconds) or utc."},
    {RemarkCode::kFileNamesNoPhoto, "file_names_no_photo",
     "{file} names no photo in its rows."},
    {RemarkCode::kFileNamesNoPlace, "file_names_no_place",
     "{file} names no photo with a position."},
    {RemarkCode::kFileWithoutRows, "file_without_rows",
     "{file} holds no readable row."},
    {RemarkCode::kFileWithoutHeader, "file_without_header",
     "{file} has no header with a time and a position, an attitude, an IMU or photos."},
    {RemarkCode::kFileLacksColumns, "file_lacks_columns",
     "{file} lacks the columns {columns}."},
    {RemarkCode::kGeoTxtEmpty, "geo_txt_empty",
     "{file} names no photo with a position; rows are \"image x y z\" below a line such as "
     "EPSG:4326."},
    {RemarkCode::kPointsEmpty, "points_empty",
     "{file} holds no ground control point; rows are \"x y z pixel_x pixel_y image\" below a line "
     "such as EPSG:32615"},
    {RemarkCode::kPointsOutsideSystem, "points_outside_system",
     "{file} holds no ground control point that lies within {system}"},
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
    {RemarkCode::kJsonDamaged, "json_damaged",
     "{file} is not used: it is no JSON from byte {byte} on. Export it again."},
    {RemarkCode::kShapesWithoutTimes, "shapes_without_times",
     "{file} is not used: it holds {shapes} lines or areas, which have no times, and no track "
     "that has (gx:Track, or a Placemark with TimeStamp and Point). An area that the map is to be "
     "cut to is given by --boundary."},
    {RemarkCode::kReflectancesWithoutColumns, "reflectances_without_columns",
     "{file} has no columns by which its rows are found: give photo (with left, top, right and "
     "bottom in pixels where the panel's code cannot be read), or lat, lon and radius_m."},
    {RemarkCode::kElevationsRefused, "elevations_refused",
     "The elevation model {model} {why_words}. Give a GeoTIFF of heights in metres."},
    {RemarkCode::kNoFilm, "no_film",
     "{file} is no film that can be read. Give an MP4 or MOV as the camera wrote it, or its "
     "frames as JPEGs."},
    {RemarkCode::kFilmDamaged, "film_damaged",
     "{file} is damaged. Copy it from the camera again."},
    {RemarkCode::kFilmTooLarge, "film_too_large",
     "{file} has frames of {width_px} x {height_px} pixels; films may have up to {most_side_px} a "
     "side."},
    {RemarkCode::kFilmFull, "film_full",
     "{file}: {frames} frames were taken, up to {until_s:.0f} s; what comes later is not used. "
     "Cut the film into parts."},
});

}  // namespace skyquilt::flight
