// FlirRecord: what a thermal camera of FLIR keeps in its JPEGs (APP1 segments "FLIR") beside the picture for
// looking: the sensor's own levels and the constants that make temperatures of them. Bounded: 4096 entries,
// 4096 levels a side, nothing is copied but the picture's own bytes. Pure; any thread. Source: the layout of
// FLIR's FFF file as ExifTool documents it (Image::ExifTool::FLIR); FLIR Systems, Streaming format
// ThermoVision.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/result.h"
#include "core/flight/bytes/byte_source.h"

namespace skyquilt::flight {

// One APP1 segment's share of the record.
struct FlirPart {
  std::uint64_t offset = 0;  // in the file
  std::uint32_t bytes = 0;
  std::uint8_t number = 0, last = 0;  // of the last part
};

// As the camera wrote them: nothing is judged here.
struct FlirConstants {
  double planck_r1 = 0.0, planck_r2 = 0.0, planck_b = 0.0, planck_f = 0.0, planck_o = 0.0;
  double emissivity = 1.0;
  double distance_m = 0.0;  // to the object, through air
  double reflected_k = 0.0, atmosphere_k = 0.0, window_k = 0.0;
  double window_transmission = 1.0;
  double relative_humidity = 0.0;  // 0 to 1
  double alpha_1 = 0.0, alpha_2 = 0.0, beta_1 = 0.0, beta_2 = 0.0, atmosphere_x = 0.0;
};

struct FlirRecord {
  FlirConstants constants;
  int width_px = 0, height_px = 0;    // of the levels
  std::vector<std::uint8_t> picture;  // a PNG, or two bytes a level
  bool is_big_endian = false;         // of levels that are no PNG
};

// Parts as they stand in a file, to one record. Errors: kCorrupt (parts are missing, or it is no record
// with levels and constants), kIo.
Result<FlirRecord> ReadFlirRecord(ByteSource& source, const std::vector<FlirPart>& parts);
Result<FlirRecord> ReadFlirRecord(std::span<const std::uint8_t> record);

}  // namespace skyquilt::flight
