#include "core/image/shrink/shrink_picture.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/check.h"
#include "core/base/vector_clones.h"

namespace skyquilt::image {

namespace {

// What of the pixels of one direction each pixel of a smaller picture covers.
struct AreaCoverage {
  int first = 0, last = 0;               // pixels of the larger picture
  double of_first = 0.0, of_last = 0.0;  // how much of these two is covered; of those between, all

  double Of(int at) const { return at == first ? of_first : at == last ? of_last : 1.0; }
};

// By pixel of the smaller picture; 1 <= to_px <= from_px.
std::vector<AreaCoverage> AreaCoverageOf(int from_px, int to_px) {
  std::vector<AreaCoverage> coverage(static_cast<std::size_t>(to_px));
  const double step = static_cast<double>(from_px) / to_px;
  for (int i = 0; i < to_px; ++i) {
    const double begin = i * step;
    const double end = std::min<double>(from_px, (i + 1) * step);
    AreaCoverage& one = coverage[static_cast<std::size_t>(i)];
    one.first = static_cast<int>(begin);
    one.last = std::max(one.first, static_cast<int>(std::ceil(end)) - 1);
    one.of_first = std::min<double>(one.first + 1, end) - begin;
    one.of_last = end - one.last;
  }
  return coverage;
}

SKYQUILT_VECTOR_CLONES void SetRow(const std::uint8_t* row, float weight, std::size_t count,
                                   float* __restrict sums) {
  for (std::size_t i = 0; i < count; ++i) sums[i] = weight * static_cast<float>(row[i]);
}

SKYQUILT_VECTOR_CLONES void AddRow(const std::uint8_t* row, float weight, std::size_t count,
                                   float* __restrict sums) {
  for (std::size_t i = 0; i < count; ++i) sums[i] += weight * static_cast<float>(row[i]);
}

// A column of the smaller picture; the weights hold the division by the whole area.
struct Column {
  std::size_t first = 0, count = 0;  // numbers of the sums
  float of_first = 0.0F, of_inner = 0.0F, of_last = 0.0F;
};

std::vector<Column> ColumnsOf(int from_px, int to_px, int channels, double area) {
  std::vector<Column> columns;
  columns.reserve(static_cast<std::size_t>(to_px));
  for (const AreaCoverage& covered : AreaCoverageOf(from_px, to_px)) {
    columns.push_back({static_cast<std::size_t>(covered.first) * static_cast<std::size_t>(channels),
                       static_cast<std::size_t>(covered.last - covered.first) + 1,
                       static_cast<float>(covered.of_first / area), static_cast<float>(1.0 / area),
                       static_cast<float>(covered.of_last / area)});
  }
  return columns;
}

template <std::size_t kChannels>
void AddColumns(const float* sums, const std::vector<Column>& columns, std::uint8_t* to) {
  for (const Column& column : columns) {
    const float* const first = sums + column.first;
    for (std::size_t c = 0; c < kChannels; ++c) {
      float inner = 0.0F;
      for (std::size_t k = 1; k + 1 < column.count; ++k) inner += first[k * kChannels + c];
      float mean = column.of_first * first[c] + column.of_inner * inner;
      if (column.count > 1) mean += column.of_last * first[(column.count - 1) * kChannels + c];
      *to++ = static_cast<std::uint8_t>(mean < 255.0F ? mean + 0.5F : 255.0F);
    }
  }
}

}  // namespace

void ShrinkByArea(const ChannelRows& picture, int to_width_px, int to_height_px, std::uint8_t* to) {
  SKYQUILT_CHECK(to_width_px > 0 && to_height_px > 0 && to_width_px <= picture.width_px &&
                     to_height_px <= picture.height_px && (picture.channels == 1 || picture.channels == 3),
                 "a picture is made smaller, of one channel or three");
  const double area = static_cast<double>(picture.width_px) / to_width_px *
                      (static_cast<double>(picture.height_px) / to_height_px);
  const std::vector<Column> columns = ColumnsOf(picture.width_px, to_width_px, picture.channels, area);
  const std::size_t numbers =
      static_cast<std::size_t>(picture.width_px) * static_cast<std::size_t>(picture.channels);
  std::vector<float> sums(numbers);
  const std::size_t to_row_bytes =
      static_cast<std::size_t>(to_width_px) * static_cast<std::size_t>(picture.channels);
  for (const AreaCoverage& rows : AreaCoverageOf(picture.height_px, to_height_px)) {
    for (int y = rows.first; y <= rows.last; ++y) {
      const std::uint8_t* const row = picture.first + static_cast<std::size_t>(y) * picture.row_bytes;
      const auto weight = static_cast<float>(rows.Of(y));
      if (y == rows.first) {
        SetRow(row, weight, numbers, sums.data());
      } else {
        AddRow(row, weight, numbers, sums.data());
      }
    }
    if (picture.channels == 1) {
      AddColumns<1>(sums.data(), columns, to);
    } else {
      AddColumns<3>(sums.data(), columns, to);
    }
    to += to_row_bytes;
  }
}

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
