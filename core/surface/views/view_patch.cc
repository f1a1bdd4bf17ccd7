#include "core/surface/views/view_patch.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <optional>

#include "core/base/vector_clones.h"
#include "core/surface/views/census.h"

namespace skyquilt::surface {
namespace {

constexpr int kExactStep = 16;  // cells
// A cell is seen where it lies so far within the picture at all of its heights. At the right one, amid them,
// what lies around it does, too, as a rule; where not, the picture's last row stands for it.
constexpr float kBorderPx = 1.0f;
constexpr double kMinDepthM = 0.5;
constexpr double kMaxHalfWay = 0.9;  // of the inverse depth; beyond, a camera looks up past the heights
constexpr float kParts = 64.0f;      // of a pixel, in bilinear weights
constexpr float kMinPart = 0.01f;    // of a pixel, that even numbers of ten thousands have

// Of a place of the ground: the pixel at height s is at + s * (linear + s * square), where s runs from 0 at
// the lowest height to 1 at the highest with the inverse of the depth.
struct Line {
  Eigen::Vector2f at, linear, square;
};

// How the depth of a cell in the camera changes with its place and height.
struct DepthPlane {
  float first = 0.0f, column = 0.0f, row = 0.0f, up = 0.0f;
};

std::optional<Line> LineAt(const SurfaceCamera& camera, const Eigen::Vector2d& east_north, double low_z_m,
                           double high_z_m, double picture_scale) {
  std::array<Eigen::Vector2d, 3> pixels;
  std::array<double, 3> depths;
  for (std::size_t i = 0; i < 3; ++i) {
    const double z_m = low_z_m + 0.5 * static_cast<double>(i) * (high_z_m - low_z_m);
    const Eigen::Vector3d point(east_north.x(), east_north.y(), z_m);
    depths[i] = camera.rotation.row(2).dot(point - camera.center_in_enu);
    if (depths[i] < kMinDepthM) return std::nullopt;
    const auto pixel = camera::ProjectRolling(camera.lens, camera.cam_from_enu, camera.motion, point);
    if (!pixel) return std::nullopt;
    pixels[i] = (pixel->array() + 0.5) * picture_scale - 0.5;
  }
  const double s = 0.5 * depths[2] / depths[1];
  if (s > kMaxHalfWay) return std::nullopt;
  const Eigen::Vector2d whole = pixels[2] - pixels[0];
  const Eigen::Vector2d square = ((pixels[1] - pixels[0]) / s - whole) / (s - 1.0);
  return Line{pixels[0].cast<float>(), (whole - square).cast<float>(), square.cast<float>()};
}

// Of `count` cells between two places, or of as many as are left of them.
struct LineSpan {
  Line from, to;
  DepthPlane depth;  // first: of the first of the cells at low_z_m
  float low_z_m = 0.0f, range_m = 1.0f, span_m = 0.0f, per_step = 1.0f;
};

// A span's lines number by number: the first and by how much the other differs from it.
struct SpanNumbers {
  float at_x, at_y, linear_x, linear_y, square_x, square_y;
  float to_at_x, to_at_y, to_linear_x, to_linear_y, to_square_x, to_square_y;

  explicit SpanNumbers(const LineSpan& span)
      : at_x(span.from.at.x()),
        at_y(span.from.at.y()),
        linear_x(span.from.linear.x()),
        linear_y(span.from.linear.y()),
        square_x(span.from.square.x()),
        square_y(span.from.square.y()),
        to_at_x(span.to.at.x() - at_x),
        to_at_y(span.to.at.y() - at_y),
        to_linear_x(span.to.linear.x() - linear_x),
        to_linear_y(span.to.linear.y() - linear_y),
        to_square_x(span.to.square.x() - square_x),
        to_square_y(span.to.square.y() - square_y) {}
};

// Pointers one by one: of those in a struct the compiler does not believe that they are apart.
SKYQUILT_VECTOR_CLONES void FollowLines(const LineSpan& span, const float* __restrict low_m, int count,
                                        float* __restrict x, float* __restrict y, float* __restrict step_x,
                                        float* __restrict step_y, float* __restrict bend_x,
                                        float* __restrict bend_y) {
  const SpanNumbers of(span);
  const float first = span.depth.first, column = span.depth.column, up = span.depth.up;
  const float low_z_m = span.low_z_m, per_range = 1.0f / span.range_m, span_m = span.span_m;
  const float range_m = span.range_m, per_step = span.per_step;
  for (int i = 0; i < count; ++i) {
    const float cells = static_cast<float>(i), t = cells * (1.0f / kExactStep);
    const float depth_low = first + cells * column;
    const float scale = (depth_low + range_m * up) * per_range;
    const float above = low_m[i] - low_z_m, above_half = above + 0.5f * span_m, above_end = above + span_m;
    const float s = above * scale / (depth_low + above * up);
    const float s_half = above_half * scale / (depth_low + above_half * up);
    const float s_end = above_end * scale / (depth_low + above_end * up);
    const float ax = of.at_x + t * of.to_at_x, ay = of.at_y + t * of.to_at_y;
    const float bx = of.linear_x + t * of.to_linear_x, by = of.linear_y + t * of.to_linear_y;
    const float cx = of.square_x + t * of.to_square_x, cy = of.square_y + t * of.to_square_y;
    const float start_x = ax + s * (bx + s * cx), start_y = ay + s * (by + s * cy);
    const float half_x = ax + s_half * (bx + s_half * cx) - start_x,
                half_y = ay + s_half * (by + s_half * cy) - start_y;
    const float end_x = ax + s_end * (bx + s_end * cx) - start_x,
                end_y = ay + s_end * (by + s_end * cy) - start_y;
    x[i] = start_x;
    y[i] = start_y;
    step_x[i] = (4.0f * half_x - end_x) * per_step;
    step_y[i] = (4.0f * half_y - end_y) * per_step;
    bend_x[i] = (2.0f * end_x - 4.0f * half_x) * per_step * per_step;
    bend_y[i] = (2.0f * end_y - 4.0f * half_y) * per_step * per_step;
  }
}

// As FollowLines, of one height.
SKYQUILT_VECTOR_CLONES void FollowLinesOnce(const LineSpan& span, const float* __restrict low_m, int count,
                                            float* __restrict x, float* __restrict y) {
  const SpanNumbers of(span);
  const float first = span.depth.first, column = span.depth.column, up = span.depth.up;
  const float low_z_m = span.low_z_m, range_m = span.range_m, per_range = 1.0f / range_m;
  for (int i = 0; i < count; ++i) {
    const float cells = static_cast<float>(i), t = cells * (1.0f / kExactStep);
    const float depth_low = first + cells * column;
    const float above = low_m[i] - low_z_m;
    const float s = above * (depth_low + range_m * up) * per_range / (depth_low + above * up);
    const float bx = of.linear_x + t * of.to_linear_x, by = of.linear_y + t * of.to_linear_y;
    const float cx = of.square_x + t * of.to_square_x, cy = of.square_y + t * of.to_square_y;
    x[i] = of.at_x + t * of.to_at_x + s * (bx + s * cx);
    y[i] = of.at_y + t * of.to_at_y + s * (by + s * cy);
  }
}

// Where the cells lie so many heights up.
SKYQUILT_VECTOR_CLONES void RaiseCells(const float* __restrict at, const float* __restrict step,
                                       const float* __restrict bend, float height, int count,
                                       float* __restrict raised) {
  for (int i = 0; i < count; ++i) raised[i] = at[i] + height * (step[i] + height * bend[i]);
}

// 0 where a cell lies within the picture at both ends of its heights, else kNotCompared.
SKYQUILT_VECTOR_CLONES void MarkUnseen(const float* __restrict low, const float* __restrict high, float last,
                                       int count, std::uint8_t* __restrict unseen) {
  for (int i = 0; i < count; ++i) {
    const float least = low[i] < high[i] ? low[i] : high[i], most = low[i] < high[i] ? high[i] : low[i];
    const bool is_seen = (least >= kBorderPx) & (most <= last);
    unseen[i] = static_cast<std::uint8_t>(unseen[i] | (is_seen ? 0 : kNotCompared));
  }
}

// Which pixel a cell lies right and below of, and how far between it and the next ones.
inline std::int32_t PlaceOf(float x, float y, float last_x, float last_y, std::int32_t stride,
                            std::int32_t& weights) {
  float u = x > 0.0f ? x : 0.0f, v = y > 0.0f ? y : 0.0f;
  u = u < last_x ? u : last_x;
  v = v < last_y ? v : last_y;
  const std::int32_t column = static_cast<std::int32_t>(u), row = static_cast<std::int32_t>(v);
  weights = static_cast<std::int32_t>((u - static_cast<float>(column)) * kParts) |
            (static_cast<std::int32_t>((v - static_cast<float>(row)) * kParts) << 8);
  return row * stride + column;
}

SKYQUILT_VECTOR_CLONES void PlaceCells(const float* __restrict x, const float* __restrict y, float last_x,
                                       float last_y, std::int32_t stride, int count,
                                       std::int32_t* __restrict index, std::int32_t* __restrict weights) {
  for (int i = 0; i < count; ++i) index[i] = PlaceOf(x[i], y[i], last_x, last_y, stride, weights[i]);
}

// So many heights up.
SKYQUILT_VECTOR_CLONES void PlaceRaised(const float* __restrict x, const float* __restrict y,
                                        const float* __restrict step_x, const float* __restrict step_y,
                                        const float* __restrict bend_x, const float* __restrict bend_y,
                                        float height, float last_x, float last_y, std::int32_t stride,
                                        int count, std::int32_t* __restrict index,
                                        std::int32_t* __restrict weights) {
  for (int i = 0; i < count; ++i) {
    index[i] = PlaceOf(x[i] + height * (step_x[i] + height * bend_x[i]),
                       y[i] + height * (step_y[i] + height * bend_y[i]), last_x, last_y, stride, weights[i]);
  }
}

// A pixel and those right, below and both of it, as one word. Alone: instructions that gather are slower than
// this on many processors.
static_assert(std::endian::native == std::endian::little, "two pixels side by side are read as one number");
void TakeFours(const std::uint8_t* gray, std::ptrdiff_t stride, const std::int32_t* index, int count,
               std::uint32_t* taken) {
  for (int i = 0; i < count; ++i) {
    std::uint16_t upper, lower;
    std::memcpy(&upper, gray + index[i], sizeof(upper));
    std::memcpy(&lower, gray + index[i] + stride, sizeof(lower));
    taken[i] = static_cast<std::uint32_t>(upper) | static_cast<std::uint32_t>(lower) << 16;
  }
}

SKYQUILT_VECTOR_CLONES void MixFours(const std::uint32_t* __restrict fours,
                                     const std::int32_t* __restrict weights, int count,
                                     std::uint8_t* __restrict gray) {
  for (int i = 0; i < count; ++i) {
    const auto four = static_cast<std::int32_t>(fours[i]);
    const std::int32_t u = weights[i] & 255, v = weights[i] >> 8;
    const std::int32_t a = four & 255, b = (four >> 8) & 255, c = (four >> 16) & 255, d = (four >> 24) & 255;
    const std::int32_t upper = a * 64 + (b - a) * u, lower = c * 64 + (d - c) * u;
    gray[i] = static_cast<std::uint8_t>((upper * 64 + (lower - upper) * v + 2048) >> 12);
  }
}

}  // namespace

bool ViewPatch::Prepare(const SurfaceCamera& camera, const GrayPyramid& pyramid, const TileFrame& frame,
                        const std::vector<float>& low_m, double span_m, int heights) {
  frame_ = frame;
  heights_ = heights;
  const std::size_t level = pyramid.LevelFor(camera.CellInPhotoPx(frame.cell_m));
  const GrayPicture& picture = pyramid.pictures[level];
  if (picture.width_px < 2 || picture.height_px < 2) return false;
  const double scale = 1.0 / (static_cast<double>(pyramid.denominator) * static_cast<double>(1U << level));
  const auto [lowest, highest] = std::minmax_element(low_m.begin(), low_m.end());
  const double low_z_m = *lowest;
  // Never nothing: the square is through three heights that differ.
  const double range_m = std::max(*highest - low_z_m + span_m, frame.cell_m);
  const int nodes_x = (frame.columns - 1) / kExactStep + 2, nodes_y = (frame.rows - 1) / kExactStep + 2;
  std::vector<Line> nodes;
  nodes.reserve(static_cast<std::size_t>(nodes_x) * nodes_y);
  for (int row = 0; row < nodes_y; ++row) {
    for (int column = 0; column < nodes_x; ++column) {
      const Eigen::Vector2d place =
          frame.first_in_enu + frame.cell_m * kExactStep * Eigen::Vector2d(column, row);
      const auto line = LineAt(camera, place, low_z_m, low_z_m + range_m, scale);
      if (!line) return false;
      nodes.push_back(*line);
    }
  }
  for (std::vector<float>* values : {&x_, &y_}) values->resize(frame.Count());
  if (heights > 1) {
    for (std::vector<float>* values : {&step_x_, &step_y_, &bend_x_, &bend_y_}) values->resize(frame.Count());
  }
  const Eigen::RowVector3d axis = camera.rotation.row(2);
  const Eigen::Vector3d first(frame.first_in_enu.x(), frame.first_in_enu.y(), low_z_m);
  const double first_depth = axis.dot(first - camera.center_in_enu);
  for (int row = 0; row < frame.rows; ++row) {
    const float t = static_cast<float>(row % kExactStep) / kExactStep;
    const Line* below = nodes.data() + static_cast<std::ptrdiff_t>(row / kExactStep) * nodes_x;
    const auto between = [&](int column) {
      const Line &a = below[column], &b = below[column + nodes_x];
      return Line{a.at + t * (b.at - a.at), a.linear + t * (b.linear - a.linear),
                  a.square + t * (b.square - a.square)};
    };
    for (int column = 0; column < frame.columns; column += kExactStep) {
      LineSpan span{between(column / kExactStep), between(column / kExactStep + 1), {}};
      span.depth.first =
          static_cast<float>(first_depth + frame.cell_m * (axis.x() * column + axis.y() * row));
      span.depth.column = static_cast<float>(axis.x() * frame.cell_m);
      span.depth.up = static_cast<float>(axis.z());
      span.low_z_m = static_cast<float>(low_z_m);
      span.range_m = static_cast<float>(range_m);
      span.span_m = static_cast<float>(span_m);
      span.per_step = heights > 1 ? 1.0f / static_cast<float>(heights - 1) : 0.0f;
      const std::size_t at = static_cast<std::size_t>(row) * frame.columns + column;
      const int count = std::min(kExactStep, frame.columns - column);
      if (heights == 1) {
        FollowLinesOnce(span, low_m.data() + at, count, x_.data() + at, y_.data() + at);
        continue;
      }
      FollowLines(span, low_m.data() + at, count, x_.data() + at, y_.data() + at, step_x_.data() + at,
                  step_y_.data() + at, bend_x_.data() + at, bend_y_.data() + at);
    }
  }
  picture_ = &picture;
  return MarkSeen();
}

bool ViewPatch::MarkSeen() {
  const CensusShape shape{frame_.columns - 2 * kCensusRadius, frame_.rows - 2 * kCensusRadius};
  unseen_.assign(shape.PlaneSize(), kNotCompared);
  const float last_x = static_cast<float>(picture_->width_px - 1) - kBorderPx,
              last_y = static_cast<float>(picture_->height_px - 1) - kBorderPx;
  const float steps = static_cast<float>(heights_ - 1);
  const auto columns = static_cast<std::size_t>(shape.columns);
  high_.resize(columns);
  bool sees_any = false;
  for (int row = 0; row < shape.rows; ++row) {
    const std::size_t at = static_cast<std::size_t>(row + kCensusRadius) * frame_.columns + kCensusRadius;
    std::uint8_t* unseen = unseen_.data() + shape.IndexOf(0, row);
    std::fill_n(unseen, columns, std::uint8_t{0});
    const auto mark = [&](const std::vector<float>& low, const std::vector<float>& step,
                          const std::vector<float>& bend, float last) {
      const float* high = low.data() + at;
      if (heights_ > 1) {
        RaiseCells(high, step.data() + at, bend.data() + at, steps, shape.columns, high_.data());
        high = high_.data();
      }
      MarkUnseen(low.data() + at, high, last, shape.columns, unseen);
    };
    mark(x_, step_x_, bend_x_, last_x);
    mark(y_, step_y_, bend_y_, last_y);
    sees_any = sees_any || std::find(unseen, unseen + columns, std::uint8_t{0}) != unseen + columns;
  }
  return sees_any;
}

void ViewPatch::Sample(int height, std::uint8_t* patch) {
  constexpr std::size_t kCellsAtOnce = 1024;  // cells that stay in the nearest cache
  std::array<std::int32_t, kCellsAtOnce> index, weights;
  std::array<std::uint32_t, kCellsAtOnce> fours;
  // Of the last but one pixel, which has others right and below.
  const float last_x = static_cast<float>(picture_->width_px - 1) - kMinPart,
              last_y = static_cast<float>(picture_->height_px - 1) - kMinPart;
  for (std::size_t at = 0; at < x_.size(); at += kCellsAtOnce) {
    const int count = static_cast<int>(std::min(kCellsAtOnce, x_.size() - at));
    const float *x = x_.data() + at, *y = y_.data() + at;
    if (height > 0) {
      PlaceRaised(x, y, step_x_.data() + at, step_y_.data() + at, bend_x_.data() + at, bend_y_.data() + at,
                  static_cast<float>(height), last_x, last_y, picture_->width_px, count, index.data(),
                  weights.data());
    } else {
      PlaceCells(x, y, last_x, last_y, picture_->width_px, count, index.data(), weights.data());
    }
    TakeFours(picture_->gray.data(), picture_->width_px, index.data(), count, fours.data());
    MixFours(fours.data(), weights.data(), count, patch + at);
  }
}

}  // namespace skyquilt::surface
