#include "core/render/thumbnail.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "core/base/check.h"
#include "core/base/try.h"
#include "core/image/jpeg_decoder.h"
#include "core/image/picture_codec.h"
#include "core/image/shrink/shrink_picture.h"

namespace skyquilt::render {
namespace {

constexpr int kJpegQuality = 92;

}  // namespace

int ThumbnailDenominator(const flight::Photo& photo) {
  const int long_side = std::max(photo.intrinsics.width_px, photo.intrinsics.height_px);
  return long_side >= 8 * kThumbnailSidePx ? 8 : long_side >= 4 * kThumbnailSidePx ? 4 : 1;
}

Result<Thumbnail> MakeThumbnail(const flight::PhotoSource& source, const flight::Photo& photo) {
  SKYQUILT_TRY_ASSIGN(const image::DecodedImage decoded, source.Decode(photo, ThumbnailDenominator(photo)));
  return MakeThumbnail(photo, decoded);
}

Thumbnail MakeThumbnail(const flight::Photo& photo, const image::DecodedImage& decoded) {
  constexpr int kChannels = 3;
  const double scale =
      std::min(1.0, static_cast<double>(kThumbnailSidePx) / std::max(decoded.width_px, decoded.height_px));
  const auto side = [&](int side_px) { return std::max(1, static_cast<int>(std::lrint(side_px * scale))); };
  const int width_px = side(decoded.width_px), height_px = side(decoded.height_px);
  const int row_bytes = kChannels * width_px;
  std::vector<std::uint8_t> small(static_cast<std::size_t>(row_bytes) * static_cast<std::size_t>(height_px));
  image::ShrinkByArea({decoded.rgb.data(), decoded.width_px, decoded.height_px, kChannels,
                       kChannels * static_cast<std::size_t>(decoded.width_px)},
                      width_px, height_px, small.data());
  const image::PixelRows rows{small.data(), width_px, height_px, kChannels, row_bytes};
  return {photo.name, width_px, height_px, image::EncodeJpeg(rows, kJpegQuality)};
}

image::DecodedImage Decode(const Thumbnail& thumbnail) {
  Result<image::DecodedPart> whole =
      image::DecodeJpeg(thumbnail.jpeg, thumbnail.width_px, thumbnail.height_px, 1, std::nullopt, {});
  SKYQUILT_CHECK(whole.ok(), "a thumbnail changed in memory");
  return std::move(whole->image);
}

}  // namespace skyquilt::render
