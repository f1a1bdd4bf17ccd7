// InterpretExif: the EXIF tags that matter to a map, checked and in our units. What is missing, impossible or
// doubtful is absent and said in `notes`. Never fails. Any thread. Source: CIPA DC-008 (Exif 2.32).
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "core/flight/metadata/exif_table.h"
#include "core/flight/metadata/xmp.h"
#include "core/flight/photo.h"
#include "core/geo/lat_lon.h"

namespace skyquilt::flight {

struct ExifRecord {
  std::string make;
  std::string model;
  std::string software;
  std::string serial_number;
  std::optional<int> orientation;  // 1..8, recorded only: the angles belong to the sensor as stored
  std::optional<double> exposure_time_s;
  std::optional<double> iso;
  std::optional<double> f_number;
  std::optional<double> focal_length_mm;
  std::optional<double> focal_length_35mm_mm;
  std::optional<double> focal_plane_x_px_per_mm;
  std::optional<double> focal_plane_y_px_per_mm;
  std::optional<double> focal_plane_x_mm, focal_plane_y_mm;  // the same numbers read as lengths
  std::optional<int>
      recorded_width_px;  // what the tags say; another program may have changed the image since
  double digital_zoom = 1.0;

  std::optional<geo::LatLon> position;
  bool is_hemisphere_known = true;     // false: a reference was missing, north or east was taken
  double position_resolution_m = 0.0;  // the step in which the position is written
  bool is_beside_wgs84 = false;        // by its datum
  std::optional<double> altitude_m;    // above whatever the camera meant; only the plausible
  bool is_altitude_from_sea = false;   // as its reference says; most are used for either zero
  std::optional<double> position_error_m;
  std::optional<double> image_direction_deg;  // [0, 360), of the picture as viewers show it
  bool is_direction_from_true_north = false;  // false: from magnetic north, or it is not said

  std::optional<UtcTime> taken_at;  // the camera's clock as if it were UTC
  std::optional<std::chrono::minutes> clock_minus_utc;
  std::optional<UtcTime> gps_time;
  std::optional<std::chrono::microseconds> gps_time_of_day;  // where its day is not written

  std::vector<Remark> notes;
};

ExifRecord InterpretExif(const ExifTable& table);

// Camera and lens out of XMP's copies of EXIF (tiff:, exif:), where the tags themselves are lost: programs
// that write PNG, and some that write JPEG, keep nothing else.
void FillFromXmp(const XmpTags& xmp, ExifRecord& record);

// Of a file whose other tags do not matter.
std::optional<double> ExposureTimeS(const ExifTable& table);
std::optional<double> IsoOf(const ExifTable& table);

// "2013:06:04 17:38:03.25", also with '-', 'T', and a zone ("Z", "+02:00") that is given back apart. The time
// is as written; nothing for what is no date.
struct ExifTime {
  UtcTime as_written;
  std::optional<std::chrono::minutes> clock_minus_utc;
};
std::optional<ExifTime> ParseExifTime(const std::string& text);

}  // namespace skyquilt::flight
