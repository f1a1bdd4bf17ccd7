#include "core/flight/photos/sample_format.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "core/base/parallel_for.h"
#include "core/base/try.h"
#include "core/flight/bytes/text_fields.h"
#include "core/flight/remarks/because.h"

namespace skyquilt::flight {
namespace {

constexpr std::uint16_t kBitsTag = 0x0102, kPhotometricTag = 0x0106, kChannelsTag = 0x0115,
                        kSampleFormatTag = 0x0153, kNoDataTag = 42113, kWidthTag = 0x0100,
                        kHeightTag = 0x0101, kTileWidthTag = 0x0142, kTileHeightTag = 0x0143;
constexpr int kZeroIsWhite = 0, kZeroIsBlack = 1, kRgb = 2;
constexpr int kFormatUnsigned = 1, kFormatSigned = 2, kFormatFloating = 3, kFormatUndefined = 4;

Error NotDrawn(const std::string& what, const char* instead) {
  return Because(ErrorCode::kUnsupportedFormat,
                 {RemarkCode::kTiffNotRead, {{"what_words", what}, {"instead_words", instead}}});
}

constexpr const char* kAsWholeNumbers =
    "Export it with 8 or 16 bits a sample, or as 32-bit floating point, keeping the metadata.";

// Tiles are decoded whole, however little of them the picture shows: some are made to keep a decoder busy.
Result<void> CheckTiles(const ExifTable& tags) {
  const auto size = [&](std::uint16_t tag) { return tags.Number(ExifIfd::kImage, tag).value_or(0.0); };
  const double width = size(kWidthTag), height = size(kHeightTag);
  const double tile_width = size(kTileWidthTag), tile_height = size(kTileHeightTag);
  if (!(tile_width > 0.0 && tile_height > 0.0)) return {};
  constexpr double kMaxTimes = 4.0, kAlways = 4096.0 * 4096.0;
  const double decoded =
      std::ceil(width / tile_width) * tile_width * std::ceil(height / tile_height) * tile_height;
  if (decoded <= kMaxTimes * width * height + kAlways) return {};
  return NotDrawn(fmt::format("tiles of {:.0f} x {:.0f} pixels for a picture of {:.0f} x {:.0f}", tile_width,
                              tile_height, width, height),
                  "Export it again, with tiles no larger than the picture or in strips.");
}

}  // namespace

Result<SampleFormat> SampleFormatOfTiff(const ExifTable& tags) {
  SKYQUILT_TRY(CheckTiles(tags));
  const auto number = [&](std::uint16_t tag, int otherwise) {
    constexpr double kMaxTag = 65535.0;
    return static_cast<int>(std::clamp(tags.Number(ExifIfd::kImage, tag).value_or(otherwise), 0.0, kMaxTag));
  };
  // A TIFF that does not say is left to the decoder, which knows more kinds of small samples.
  const int bits = number(kBitsTag, 8);
  const int channels = number(kChannelsTag, 1);
  const int format = number(kSampleFormatTag, kFormatUnsigned);
  const int photometric = number(kPhotometricTag, channels == 1 ? kZeroIsBlack : kRgb);
  if (channels < 1 || channels > 4) {
    return NotDrawn(fmt::format("{} bands in one file", channels),
                    "Give each band as a file of its own, as the camera wrote it.");
  }
  SampleFormat found;
  found.zero_is_white = photometric == kZeroIsWhite;
  found.no_data = ParseNumber(tags.Text(ExifIfd::kImage, kNoDataTag));
  const auto one_band = [&](SampleKind kind, const char* numbers, bool are_read,
                            const char* instead) -> Result<SampleFormat> {
    const std::string what = fmt::format("{}-bit {}", bits, numbers);
    if (!are_read) return NotDrawn(what, kAsWholeNumbers);
    if (channels != 1) return NotDrawn(fmt::format("{} in {} bands", what, channels), instead);
    found.kind = kind;
    return found;
  };
  if (format == kFormatFloating) {
    return one_band(SampleKind::kFloating, "floating point numbers", bits == 32 || bits == 64,
                    "Give each band as a file of its own, or colours with 8 or 16 bits a sample.");
  }
  if (format == kFormatSigned) {
    return one_band(SampleKind::kSigned, "whole numbers with a sign", bits == 16 || bits == 32,
                    kAsWholeNumbers);
  }
  if (format != kFormatUnsigned && format != kFormatUndefined)
    return NotDrawn("complex numbers", kAsWholeNumbers);
  if (bits == 1 || bits == 8) return found;
  if (bits != 10 && bits != 12 && bits != 14 && bits != 16)
    return NotDrawn(fmt::format("{}-bit whole numbers", bits), kAsWholeNumbers);
  if (channels == 1 && (photometric == kZeroIsBlack || photometric == kZeroIsWhite)) {
    found.kind = SampleKind::kLevels;
    return found;
  }
  if (channels >= 3 && photometric == kRgb) {
    found.kind = SampleKind::kColourLevels;
    return found;
  }
  if (channels == 1 || photometric > kRgb) return found;  // palettes and such, which the decoder knows
  return NotDrawn(fmt::format("{} bands of {} bits in one file that are no colours", channels, bits),
                  "Give each band as a file of its own, as the camera wrote it.");
}

SampleKind SampleKindOfPng(std::span<const std::uint8_t> start) {
  constexpr std::size_t kDepthAt = 24, kColourAt = 25;
  constexpr int kGrey = 0, kColour = 2, kColourAndAlpha = 6;
  if (start.size() <= kColourAt || start[kDepthAt] != 16) return SampleKind::kBytes;
  if (start[kColourAt] == kGrey) return SampleKind::kLevels;
  return start[kColourAt] == kColour || start[kColourAt] == kColourAndAlpha ? SampleKind::kColourLevels
                                                                            : SampleKind::kBytes;
}

namespace {

constexpr std::size_t kPicturesLookedAt = 16;

// The depth of a sensor whose levels reach `high`.
SampleRange RangeOfDepth(double high) {
  for (const double levels : {1024.0, 4096.0, 16384.0}) {
    if (high < levels) return {0.0, levels};
  }
  return {};
}

}  // namespace

std::optional<SampleRange> RangeOf(std::vector<float> values, SampleKind kind) {
  std::erase_if(values, [](float value) { return !std::isfinite(value); });
  if (values.empty()) return std::nullopt;
  constexpr std::size_t kRareShare = 1000;
  const auto rare = static_cast<std::ptrdiff_t>(values.size() / kRareShare);
  std::nth_element(values.begin(), values.begin() + rare, values.end());
  const double low = values[static_cast<std::size_t>(rare)];
  std::nth_element(values.begin() + rare, values.end() - 1 - rare, values.end());
  const double high = *(values.end() - 1 - rare);
  if (kind == SampleKind::kColourLevels) return RangeOfDepth(high);
  constexpr double kNarrow = 4096.0;
  if (kind == SampleKind::kLevels) {
    if (high - low < 1.0) return SampleRange{};
    if (high - low >= kNarrow) return RangeOfDepth(high);
  }
  if (!(high > low)) return SampleRange{low - 1.0, low + 1.0};
  return SampleRange{low, high};
}

void ChooseSampleRanges(std::vector<Photo>& photos, const PhotoSource& source, int threads) {
  std::map<std::pair<std::string, SampleKind>, std::vector<std::size_t>> cameras;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    if (photos[i].sample_kind != SampleKind::kBytes && !photos[i].sample_range)
      cameras[{photos[i].camera_key, photos[i].sample_kind}].push_back(i);
  }
  for (const auto& [camera, of_camera] : cameras) {
    const std::vector<std::size_t>& own = of_camera;  // a binding may not be captured by every compiler
    const std::size_t count = std::min(kPicturesLookedAt, own.size());
    std::vector<std::vector<float>> found(count);
    ParallelFor(count, threads, [&](std::size_t k) {
      // From the first to the last of the flight.
      const std::size_t photo = own[count == 1 ? 0 : k * (own.size() - 1) / (count - 1)];
      if (Result<std::vector<float>> values = source.SampleValues(photos[photo], kSampleValues))
        found[k] = *std::move(values);
    });
    std::vector<float> all;
    for (const std::vector<float>& values : found) all.insert(all.end(), values.begin(), values.end());
    const std::optional<SampleRange> range = RangeOf(std::move(all), camera.second);
    for (const std::size_t i : of_camera) photos[i].sample_range = range;
  }
}

}  // namespace skyquilt::flight
