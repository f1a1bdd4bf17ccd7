#include "core/render/thumbnail.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <utility>

#include "core/base/check.h"
#include "core/base/try.h"
#include "core/image/jpeg_decoder.h"
#include "core/image/picture_codec.h"

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
  const cv::Mat full(decoded.height_px, decoded.width_px, CV_8UC3,
                     const_cast<std::uint8_t*>(decoded.rgb.data()));
  const double scale = std::min(1.0, static_cast<double>(kThumbnailSidePx) / std::max(full.cols, full.rows));
  cv::Mat small;
  cv::resize(full, small, {std::max(1, cvRound(full.cols * scale)), std::max(1, cvRound(full.rows * scale))},
             0, 0, cv::INTER_AREA);
  const image::PixelRows rows{small.data, small.cols, small.rows, 3, static_cast<int>(small.step)};
  return {photo.name, small.cols, small.rows, image::EncodeJpeg(rows, kJpegQuality)};
}

image::DecodedImage Decode(const Thumbnail& thumbnail) {
  Result<image::DecodedPart> whole =
      image::DecodeJpeg(thumbnail.jpeg, thumbnail.width_px, thumbnail.height_px, 1, std::nullopt, {});
  SKYQUILT_CHECK(whole.ok(), "a thumbnail changed in memory");
  return std::move(whole->image);
}

}  // namespace skyquilt::render
