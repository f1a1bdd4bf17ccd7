#include "core/render/thumbnail.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace skyquilt::render {

Result<Thumbnail> MakeThumbnail(const pipeline::PhotoSource& source, const flight::Photo& photo) {
  const int long_side = std::max(photo.intrinsics.width_px, photo.intrinsics.height_px);
  const int denominator = long_side >= 8 * kThumbnailSidePx ? 8 : long_side >= 4 * kThumbnailSidePx ? 4 : 1;
  Result<pipeline::DecodedImage> decoded = source.Decode(photo, denominator);
  if (!decoded) return decoded.error();
  const cv::Mat3b full(decoded->height_px, decoded->width_px, reinterpret_cast<cv::Vec3b*>(decoded->rgb.data()));
  const double scale = std::min(1.0, static_cast<double>(kThumbnailSidePx) / std::max(full.cols, full.rows));
  cv::Mat3b small;
  cv::resize(full, small, {std::max(1, cvRound(full.cols * scale)), std::max(1, cvRound(full.rows * scale))}, 0, 0,
             cv::INTER_AREA);
  Thumbnail thumbnail{photo.name, small.cols, small.rows, {}};
  thumbnail.rgb.assign(small.data, small.data + small.total() * 3);
  return thumbnail;
}

}  // namespace skyquilt::render
