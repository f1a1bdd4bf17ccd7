#include "core/flight/aside/other_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "core/flight/aside/aside.h"
#include "core/flight/bytes/text_fields.h"

namespace skyquilt::flight {
namespace {

constexpr std::uint16_t kNewSubfileType = 0x00FE, kImageWidth = 0x0100, kImageHeight = 0x0101;
constexpr std::uint16_t kCompression = 0x0103, kPhotometric = 0x0106, kMakeOfTiff = 0x010F, kSubIfds = 0x014A;
constexpr std::uint16_t kDngVersion = 0xC612;
constexpr int kMaxPictures = 16;

double NumberOf(const ExifTable& table, std::uint16_t tag) {
  return table.Number(ExifIfd::kImage, tag).value_or(0.0);
}

bool IsReduced(const ExifTable& table) { return std::fmod(NumberOf(table, kNewSubfileType), 2.0) == 1.0; }

// What a sensor counted behind its colour filters, or what only makers compress so.
bool HoldsSensorLevels(const ExifTable& table) {
  constexpr std::array kPhotometrics = {32803.0, 34892.0};  // colour filter array, linear raw
  // Kodak, Nikon, Sony, Samsung (two), Pentax.
  constexpr std::array kCompressions = {65000.0, 34713.0, 32767.0, 32769.0, 32770.0, 65535.0};
  const auto is_one_of = [](const auto& list, double value) {
    return std::find(list.begin(), list.end(), value) != list.end();
  };
  return is_one_of(kPhotometrics, NumberOf(table, kPhotometric)) ||
         is_one_of(kCompressions, NumberOf(table, kCompression));
}

double PixelsOfTiff(const ExifTable& table) {
  return NumberOf(table, kImageWidth) * NumberOf(table, kImageHeight);
}

}  // namespace

std::string_view RawFormatOf(std::span<const std::uint8_t> head) {
  struct Mark {
    std::size_t at;
    std::string_view bytes, format;
  };
  using namespace std::string_view_literals;
  constexpr std::array kMarks = {
      Mark{0, "FUJIFILMCCD-RAW"sv, "RAF"sv},
      Mark{0, "IIRO"sv, "ORF"sv},
      Mark{0, "IIRS"sv, "ORF"sv},
      Mark{0, "MMOR"sv, "ORF"sv},
      Mark{0, "IIU\0"sv, "RW2"sv},
      Mark{4, "ftypcrx "sv, "CR3"sv},
      Mark{4, "\x10\0\0\0CR\2"sv, "CR2"sv},
      Mark{6, "HEAPCCDR"sv, "CRW"sv},
      Mark{0, "FOVb"sv, "X3F"sv},
      Mark{0, "\0MRM"sv, "MRW"sv},
  };
  const std::string_view text(reinterpret_cast<const char*>(head.data()), head.size());
  for (const Mark& mark : kMarks) {
    if (text.size() >= mark.at && text.substr(mark.at).starts_with(mark.bytes)) return mark.format;
  }
  return "";
}

std::optional<Error> WhyRaw(const ExifTable& first, ByteSource& source) {
  if (first.Find(ExifIfd::kImage, kDngVersion)) return AsideError(Aside::kRawPicture, "DNG");
  bool is_raw = HoldsSensorLevels(first);
  bool has_larger = false;
  if (!is_raw && (IsReduced(first) || first.Find(ExifIfd::kImage, kSubIfds))) {
    for (const ExifTable& other : ReadTiffPictures(source, kMaxPictures)) {
      is_raw |= HoldsSensorLevels(other);
      has_larger |= PixelsOfTiff(other) > PixelsOfTiff(first);
    }
  }
  if (is_raw) {
    const std::string make = first.Text(ExifIfd::kImage, kMakeOfTiff);
    return AsideError(Aside::kRawPicture, make.empty() ? "the sensor's own levels" : "of " + make);
  }
  if (IsReduced(first) && has_larger) return AsideError(Aside::kThumbnailFirst, "");
  return std::nullopt;
}

std::optional<Error> WhyPanorama(int width_px, int height_px, const XmpTags& xmp) {
  const std::string projection = LowerCase(xmp.Text("GPano:ProjectionType"));
  const bool is_plain = projection == "rectilinear" || projection == "perspective";
  if (!projection.empty() && !is_plain)
    return AsideError(Aside::kPanorama, "its XMP says " + projection.substr(0, 40));
  constexpr int kMaxAspect = 3;
  const auto [shorter, longer] = std::minmax(width_px, height_px);
  if (longer > static_cast<std::int64_t>(kMaxAspect) * shorter)
    return AsideError(Aside::kPanorama, "its long side is over three times its short one");
  return std::nullopt;
}

}  // namespace skyquilt::flight
