// Radiometric JPEGs as FLIR's thermal cameras write them, for tests of what reads them.
#pragma once

#include "core/flight/metadata/flir_record.h"
#include "tests/core/flight/synthetic_photo.h"

namespace skyquilt::flight {

enum class FlirLevels { kPng, kLittleEndian, kBigEndian };

struct FlirPhoto {
  FlirConstants constants;
  int width_px = 0, height_px = 0;
  std::vector<std::uint16_t> levels;
  Bytes png;  // for the kinds that store one, whose encoder the caller has
  FlirLevels kind = FlirLevels::kLittleEndian;
  bool is_big_endian = true;  // the record, as in the cameras' JPEGs
};

// Those of a camera of the Tau family.
FlirConstants UsualFlirConstants();

// The FFF record alone.
Bytes FlirRecordBytes(const FlirPhoto& photo);

// `jpeg` with the record in APP1 segments of at most `part_bytes` behind its first marker.
Bytes WithFlirRecord(const Bytes& jpeg, const Bytes& record, std::size_t part_bytes = 60'000);

}  // namespace skyquilt::flight
