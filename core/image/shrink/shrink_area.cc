#include "core/image/shrink/shrink_area.h"

#include <vector>

#include "core/base/check.h"
#include "core/base/vector_clones.h"
#include "core/image/shrink/area_coverage.h"

namespace skyquilt::image {
namespace {

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

}  // namespace skyquilt::image
