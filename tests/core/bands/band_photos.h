// Photos of one band as cameras write them, for tests of what reads them.
#pragma once

#include <fmt/format.h>

#include "tests/core/flight/synthetic_photo.h"

namespace skyquilt::bands {

inline constexpr const char* kCameraXmp = "xmlns:Camera=\"http://pix4d.com/camera/1.0/\" ";
inline constexpr const char* kMicaSenseXmp =
    "xmlns:MicaSense=\"http://micasense.com/MicaSense/1.0/\" xmlns:DLS=\"http://micasense.com/DLS/1.0/\" ";

inline constexpr std::uint16_t kBlackLevel = 0xC61A, kExposureTime = 0x829A, kIso = 0x8827;
inline constexpr std::uint16_t kDateTimeOriginal = 0x9003;

// Exposure 1/500 s, ISO 200, black level 4800.
inline flight::ExifWriter UsualExif(const std::string& taken_at = "2024:06:01 10:00:00") {
  return flight::ExifWriter()
      .Ascii(flight::ExifIfd::kImage, 0x010F, "Maker")
      .Ascii(flight::ExifIfd::kImage, 0x0110, "Rig")
      .Short(flight::ExifIfd::kImage, kBlackLevel, 4800)
      .Rational(flight::ExifIfd::kExif, kExposureTime, {{1, 500}})
      .Short(flight::ExifIfd::kExif, kIso, 200)
      .Ascii(flight::ExifIfd::kExif, kDateTimeOriginal, taken_at);
}

inline flight::Bytes BandPhotoBytes(const std::string& attributes,
                                    const flight::ExifWriter& exif = UsualExif(),
                                    std::uint16_t level = 20'000) {
  constexpr int kWidth = 40, kHeight = 30;
  return flight::BandTiff(
      exif, kWidth, kHeight, std::vector<std::uint16_t>(std::size_t{kWidth} * kHeight, level),
      flight::XmpPacket(std::string(kCameraXmp) + kMicaSenseXmp + flight::kDjiNamespace + attributes));
}

}  // namespace skyquilt::bands
