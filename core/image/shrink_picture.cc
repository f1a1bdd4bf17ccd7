#include "core/image/shrink_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/check.h"

namespace skyquilt::image {
namespace {

// The pixels of one direction that a pixel of the smaller picture covers, and how much of the first and last.
struct Coverage {
  int first = 0, last = 0;
  double of_first = 0.0, of_last = 0.0;

  double Of(int at) const { return at == first ? of_first : at == last ? of_last : 1.0; }
};

std::vector<Coverage> CoverageOf(int from_px, int to_px) {
  std::vector<Coverage> coverage(static_cast<std::size_t>(to_px));
  const double step = static_cast<double>(from_px) / to_px;
  for (int i = 0; i < to_px; ++i) {
    const double begin = i * step;
    const double end = std::min<double>(from_px, (i + 1) * step);
    Coverage& one = coverage[static_cast<std::size_t>(i)];
    one.first = static_cast<int>(begin);
    one.last = std::max(one.first, static_cast<int>(std::ceil(end)) - 1);
    one.of_first = std::min<double>(one.first + 1, end) - begin;
    one.of_last = end - one.last;
  }
  return coverage;
}

}  // namespace

RgbaImage ShrinkPicture(RgbaImage image, int longer_side_px) {
  SKYQUILT_CHECK(longer_side_px > 0, "a picture without pixels");
  const int longer_px = std::max(image.width_px, image.height_px);
  if (longer_px <= longer_side_px) return image;
  const auto side = [&](int side_px) {
    return std::max(1,
                    static_cast<int>(std::lround(static_cast<double>(side_px) * longer_side_px / longer_px)));
  };
  RgbaImage small = RgbaImage::Transparent(side(image.width_px), side(image.height_px));
  const std::vector<Coverage> columns = CoverageOf(image.width_px, small.width_px);
  const std::vector<Coverage> rows = CoverageOf(image.height_px, small.height_px);
  for (int y = 0; y < small.height_px; ++y) {
    const Coverage& row = rows[static_cast<std::size_t>(y)];
    for (int x = 0; x < small.width_px; ++x) {
      const Coverage& column = columns[static_cast<std::size_t>(x)];
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
