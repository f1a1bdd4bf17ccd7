// Photos made byte by byte, for tests of the readers: a small EXIF writer, XMP packets, and headers of JPEG
// files that say any size without holding pixels.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/flight/metadata/exif_table.h"

namespace skyquilt::flight {

using Bytes = std::vector<std::uint8_t>;

class ExifWriter {
 public:
  ExifWriter& Ascii(ExifIfd ifd, std::uint16_t tag, const std::string& text);
  ExifWriter& Rational(ExifIfd ifd, std::uint16_t tag,
                       std::vector<std::pair<std::uint32_t, std::uint32_t>> values);
  ExifWriter& Short(ExifIfd ifd, std::uint16_t tag, std::uint16_t value);
  ExifWriter& Long(ExifIfd ifd, std::uint16_t tag, std::uint32_t value);
  ExifWriter& Undefined(ExifIfd ifd, std::uint16_t tag, const Bytes& bytes);
  // Degrees, minutes, seconds in steps of 1/10000 second.
  ExifWriter& Position(double lat_deg, double lon_deg);
  ExifWriter& Position(double lat_deg, double lon_deg, const std::string& lat_ref,
                       const std::string& lon_ref);

  // The TIFF block, or a whole TIFF file's worth of tags.
  Bytes Write(bool is_big_endian = false) const;

 private:
  struct Entry {
    ExifType type;
    std::uint32_t count;
    std::vector<std::uint32_t> numbers;  // for short, long, rational
    Bytes bytes;                         // for ascii and undefined
  };
  std::map<ExifIfd, std::map<std::uint16_t, Entry>> entries_;
};

// One rdf:Description with the given namespace declarations and properties, each as `name="value"`.
std::string XmpPacket(const std::string& attributes, const std::string& elements = "");

struct JpegParts {
  int width_px = 4000;
  int height_px = 3000;
  Bytes exif{};  // TIFF block
  std::string xmp{};
  std::string extended_xmp{};  // written in two parts
  bool has_end = true;
};
// Segments, a frame header, a token scan: enough for header readers, no picture.
Bytes JpegHeader(const JpegParts& parts);

// A TIFF with `pixels_rgb` (8 bits a sample, uncompressed) and the writer's tags beside it.
Bytes TiffImage(ExifWriter tags, int width_px, int height_px, const Bytes& pixels_rgb,
                const std::string& xmp = "");

// The same of one channel of 16 bits.
Bytes BandTiff(ExifWriter tags, int width_px, int height_px, const std::vector<std::uint16_t>& samples,
               const std::string& xmp);

// A TIFF directory as DJI writes it into its maker note: floats under tags 3..11.
Bytes DjiNote(const std::map<std::uint16_t, float>& values);

inline constexpr const char* kDjiNamespace = "xmlns:drone-dji=\"http://www.dji.com/drone-dji/1.0/\" ";

}  // namespace skyquilt::flight
