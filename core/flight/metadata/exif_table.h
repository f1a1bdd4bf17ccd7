// ExifTable: the tags of an EXIF block as typed raw values, read by one bounded walker from the
// EXIF segment of a JPEG and from TIFF files. Values; any thread. Source of types and tag numbers: TIFF 6.0;
// CIPA DC-008 (Exif 2.32).
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/flight/bytes/byte_source.h"

namespace skyquilt::flight {

enum class ExifIfd { kImage, kExif, kGps };

// TIFF field types.
enum class ExifType : std::uint16_t {
  kByte = 1,
  kAscii = 2,
  kShort = 3,
  kLong = 4,
  kRational = 5,
  kSByte = 6,
  kUndefined = 7,
  kSShort = 8,
  kSLong = 9,
  kSRational = 10,
  kFloat = 11,
  kDouble = 12,
  kIfd = 13,
  kLong8 = 16,
  kSLong8 = 17,
  kIfd8 = 18  // BigTIFF
};

struct ExifValue {
  std::uint16_t type = 0;
  std::uint32_t count = 0;
  bool is_big_endian = false;
  std::vector<std::uint8_t> bytes;  // count x size of type, at most
  std::uint64_t offset = 0;         // of the bytes in what they were read from

  // The i-th number; nothing beyond the end, for text, and for what is not finite (a zero denominator).
  std::optional<double> Number(std::size_t i = 0) const;
  // Numerator and denominator of a rational.
  struct Fraction {
    double numerator = 0.0;
    double denominator = 0.0;
  };
  std::optional<Fraction> Rational(std::size_t i = 0) const;
  // Text up to its first zero, trimmed, unprintable characters replaced.
  std::string Text() const;
};

class ExifTable {
 public:
  void Set(ExifIfd ifd, std::uint16_t tag, ExifValue value) { values_[{ifd, tag}] = std::move(value); }
  const ExifValue* Find(ExifIfd ifd, std::uint16_t tag) const;
  std::optional<double> Number(ExifIfd ifd, std::uint16_t tag, std::size_t i = 0) const;
  std::string Text(ExifIfd ifd, std::uint16_t tag) const;
  const std::map<std::pair<ExifIfd, std::uint16_t>, ExifValue>& values() const { return values_; }

 private:
  std::map<std::pair<ExifIfd, std::uint16_t>, ExifValue> values_;
};

// Whether a TIFF says where on Earth it lies, as maps do (GeoTIFF 1.1, OGC 19-008r4).
bool IsGeoTiff(const ExifTable& table);

// By the first four bytes; BigTIFF too.
bool IsTiff(std::span<const std::uint8_t> head);

// The TIFF block of a JPEG's EXIF segment (without "Exif\0\0"), with the bounds of ReadTiffTags. Damaged
// parts are left out.
ExifTable ReadExifSegment(std::span<const std::uint8_t> tiff_block);

// The first image of a TIFF file and its EXIF and GPS directories. Errors: kCorrupt, kUnsupportedFormat.
Result<ExifTable> ReadTiffTags(ByteSource& source);

// The pictures of a TIFF file, each with its tags as of the image: the first, those below it (SubIFDs), those
// behind it; `most` at most, and none where the first cannot be read.
std::vector<ExifTable> ReadTiffPictures(ByteSource& source, int most);

// The directories in the chain that begins at the header of a TIFF file; `most` + 1 where there are more, or
// where the chain closes on itself. Errors: kCorrupt, kUnsupportedFormat.
Result<int> CountTiffDirectories(ByteSource& source, int most);

}  // namespace skyquilt::flight
