#include "core/image/shrink/shrink_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/check.h"
#include "core/image/shrink/area_coverage.h"

namespace skyquilt::image {

RgbaImage ShrinkPicture(RgbaImage image, int longer_side_px) {
  SKYQUILT_CHECK(longer_side_px > 0, "a picture without pixels");
  const int longer_px = std::max(image.width_px, image.height_px);
  if (longer_px <= longer_side_px) return image;
  const auto side = [&](int side_px) {
    return std::max(1,
                    static_cast<int>(std::lround(static_cast<double>(side_px) * longer_side_px / longer_px)));
  };
  RgbaImage small = RgbaImage::Transparent(side(image.width_px), side(image.height_px));
  const std::vector<AreaCoverage> columns = AreaCoverageOf(image.width_px, small.width_px);
  const std::vector<AreaCoverage> rows = AreaCoverageOf(image.height_px, small.height_px);
  for (int y = 0; y < small.height_px; ++y) {
    const AreaCoverage& row = rows[static_cast<std::size_t>(y)];
    for (int x = 0; x < small.width_px; ++x) {
      const AreaCoverage& column = columns[static_cast<std::size_t>(x)];
      std::array<double, 3> colour{};
      double alpha = 0.0;
      double area = 0.0;
      for (int from_y = row.first; from_y <= row.last; ++from_y) {
        for (int from_x = column.first; from_x <= column.last; ++from_x) {
          const double covered = row.Of(from_y) * column.Of(from_x);
          const std::uint8_t* const pixel = image.Pixel(from_x, from_y);
          const double weight = covered * pixel[3];
          for (std::size_t c = 0; c < 3; ++c) colour[c] += weight * pixel[c];
          alpha += weight;
          area += covered;
        }
      }
      if (alpha <= 0.0) continue;
      std::uint8_t* const pixel = small.Pixel(x, y);
      for (std::size_t c = 0; c < 3; ++c)
        pixel[c] = static_cast<std::uint8_t>(std::lround(colour[c] / alpha));
      pixel[3] = static_cast<std::uint8_t>(std::lround(alpha / area));
    }
  }
  return small;
}

}  // namespace skyquilt::image
