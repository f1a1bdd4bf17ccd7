#include "core/render/thumbnail.h"

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "core/base/check.h"
#include "core/base/try.h"

namespace skyquilt::render {

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
  Thumbnail thumbnail{photo.name, small.cols, small.rows, {}};
  cv::cvtColor(small, small, cv::COLOR_RGB2BGR);
  if (!cv::imencode(".jpg", small, thumbnail.jpeg, {cv::IMWRITE_JPEG_QUALITY, 92})) {
    throw std::runtime_error("no encoder for thumbnails");
  }
  return thumbnail;
}

DecodedThumbnail Decode(const Thumbnail& thumbnail) {
  cv::Mat image = cv::imdecode(thumbnail.jpeg, cv::IMREAD_COLOR);
  SKYQUILT_CHECK(image.cols == thumbnail.width_px && image.rows == thumbnail.height_px,
                 "a thumbnail changed in memory");
  cv::cvtColor(image, image, cv::COLOR_BGR2RGB);
  return {image.cols, image.rows, {image.data, image.data + image.total() * 3}};
}

}  // namespace skyquilt::render
