#include "core/render/seams/moving_objects.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <opencv2/imgproc.hpp>

#include "core/base/parallel_for.h"

namespace skyquilt::render {
namespace {

// Grey levels of the channel that differs most, against what the surroundings differ by: where a spot is
// suspected, and how far it reaches from there.
constexpr int kSurelyDiffers = 36, kDiffers = 24;
constexpr int kSurroundings = 15;  // cells
constexpr int kMinCells = 2;
// The longest thing that passes: a lorry with a trailer, with its shadow.
constexpr double kLongestM = 25.0;
// Cells around a spot that may differ too.
constexpr double kMaxClutter = 0.25;
// How much of the spot's outline must be in one view and not in the other: 1 is all, 0 says that both views
// have as much of their own.
constexpr double kMinOutline = 0.4;
// Cells around a spot that may look like it.
constexpr double kMaxAlike = 0.05;
// A leaning thing is taken for the same where it matches up to this share of the spot's difference.
constexpr double kMaxDifferenceOfAlike = 0.5;
// How far a leaning thing may stand out, in distances between the cameras: a third of the flying height high.
constexpr double kMaxLean = 0.5;

struct Mark {
  std::size_t view, index;
};

// One view beside others, one after the other.
class Comparison {
 public:
  Comparison(const std::vector<LowResView>& views, std::size_t view, double cell_m)
      : views_(views),
        index_{view, view},
        view_{&views[view], &views[view]},
        cell_m_(cell_m),
        longest_(static_cast<int>(kLongestM / cell_m) + 2) {}

  void With(std::size_t other, std::vector<Mark>& marks) {
    const LowResView& a = *view_[0];
    const LowResView& b = views_[other];
    column_ = std::max(a.column, b.column);
    row_ = std::max(a.row, b.row);
    columns_ = std::min(a.column + a.columns, b.column + b.columns) - column_;
    rows_ = std::min(a.row + a.rows, b.row + b.rows) - row_;
    if (columns_ < kSurroundings || rows_ < kSurroundings) return;
    index_[1] = other;
    view_[1] = &b;
    ++pair_;
    Compare();
    for (const cv::Point seed : seeds_) {
      if (visited_(seed) != pair_ && Gather(seed) && Surround()) Judge(marks);
    }
  }

 private:
  const std::uint8_t* At(int side, int x, int y) const {
    const LowResView& view = *view_[static_cast<std::size_t>(side)];
    return view.rgb[static_cast<std::size_t>(view.IndexOf(column_ + x, row_ + y))].data();
  }

  // How the views differ, cell by cell, against the mean of the surroundings: those differ by light alone.
  void Compare() {
    if (all_seen_.empty()) {
      const cv::Size size(view_[0]->columns, view_[0]->rows);
      all_seen_.create(size), all_steps_.create(size), all_around_.create(size), all_differs_.create(size);
      visited_ = cv::Mat1i(size, 0), order_ = cv::Mat1i(size, 0);
    }
    const cv::Rect both(0, 0, columns_, rows_);
    seen_ = all_seen_(both), differs_ = all_differs_(both);
    cv::Mat3s step = all_steps_(both), around = all_around_(both);
    for (int y = 0; y < rows_; ++y) {
      const auto i = static_cast<std::size_t>(view_[0]->IndexOf(column_, row_ + y));
      const auto j = static_cast<std::size_t>(view_[1]->IndexOf(column_, row_ + y));
      for (int x = 0; x < columns_; ++x) {
        const auto at = static_cast<std::size_t>(x);
        const bool is_seen = view_[0]->seen[i + at] == Seen::kFully && view_[1]->seen[j + at] == Seen::kFully;
        seen_(y, x) = is_seen ? 1 : 0;
        const auto& p = view_[0]->rgb[i + at];
        const auto& q = view_[1]->rgb[j + at];
        for (int c = 0; c < 3; ++c) {
          const auto channel = static_cast<std::size_t>(c);
          step(y, x)[c] = is_seen ? static_cast<short>(p[channel] - q[channel]) : short{0};
        }
      }
    }
    cv::blur(step, around, {kSurroundings, kSurroundings}, {-1, -1},
             cv::BORDER_REPLICATE | cv::BORDER_ISOLATED);
    seeds_.clear();
    for (int y = 0; y < rows_; ++y) {
      for (int x = 0; x < columns_; ++x) {
        const cv::Vec3s d = step(y, x) - around(y, x);
        const int most = std::max({std::abs(d[0]), std::abs(d[1]), std::abs(d[2])});
        differs_(y, x) = static_cast<short>(seen_(y, x) == 0 ? 0 : most);
        if (differs_(y, x) >= kSurelyDiffers) seeds_.emplace_back(x, y);
      }
    }
  }

  // The spot around a cell; false: too large or too small for a thing that passes.
  bool Gather(cv::Point first) {
    spot_.assign(1, first);
    visited_(first) = pair_;
    cv::Point least = first, most = first;
    for (std::size_t i = 0; i < spot_.size(); ++i) {
      const cv::Point at = spot_[i];
      least = {std::min(least.x, at.x), std::min(least.y, at.y)};
      most = {std::max(most.x, at.x), std::max(most.y, at.y)};
      for (int y = std::max(0, at.y - 1); y <= std::min(rows_ - 1, at.y + 1); ++y) {
        for (int x = std::max(0, at.x - 1); x <= std::min(columns_ - 1, at.x + 1); ++x) {
          if (visited_(y, x) == pair_ || differs_(y, x) < kDiffers) continue;
          visited_(y, x) = pair_;
          spot_.emplace_back(x, y);
        }
      }
    }
    spot_cells_ = spot_.size();
    return spot_cells_ >= kMinCells && std::max(most.x - least.x, most.y - least.y) < longest_;
  }

  // Adds two rings of cells to the spot; false: they are not all seen, or differ as well.
  bool Surround() {
    ++spots_;
    for (const cv::Point at : spot_) order_(at) = spots_;
    std::size_t begin = 0;
    for (int ring = 0; ring < 2; ++ring) {
      const std::size_t end = spot_.size();
      for (std::size_t i = begin; i < end; ++i) {
        const cv::Point at = spot_[i];
        for (int y = at.y - 1; y <= at.y + 1; ++y) {
          for (int x = at.x - 1; x <= at.x + 1; ++x) {
            if (x < 0 || y < 0 || x >= columns_ || y >= rows_ || seen_(y, x) == 0) return false;
            if (order_(y, x) == spots_) continue;
            order_(y, x) = spots_;
            spot_.emplace_back(x, y);
          }
        }
      }
      begin = end;
      if (ring == 0) with_rim_ = spot_.size();
    }
    const auto clutter = std::count_if(spot_.begin() + static_cast<std::ptrdiff_t>(spot_cells_), spot_.end(),
                                       [&](cv::Point at) { return differs_(at) >= kDiffers; });
    return static_cast<double>(clutter) <= kMaxClutter * static_cast<double>(spot_.size() - spot_cells_);
  }

  // All the steps from cell to neighbouring cell within the spot and its rings, of either view, and of the
  // difference of both.
  struct Outline {
    std::array<int, 2> of_view{};
    int of_difference = 0;
  };
  Outline Measure() const {
    Outline sum;
    for (const cv::Point at : spot_) {
      for (const cv::Point next : {cv::Point(at.x + 1, at.y), cv::Point(at.x, at.y + 1)}) {
        if (next.x >= columns_ || next.y >= rows_ || order_(next) != spots_) continue;
        for (int c = 0; c < 3; ++c) {
          const int a = At(0, at.x, at.y)[c] - At(0, next.x, next.y)[c];
          const int b = At(1, at.x, at.y)[c] - At(1, next.x, next.y)[c];
          sum.of_view[0] += std::abs(a), sum.of_view[1] += std::abs(b), sum.of_difference += std::abs(a - b);
        }
      }
    }
    return sum;
  }

  void Judge(std::vector<Mark>& marks) const {
    const Outline outline = Measure();
    const int more = outline.of_view[0] - outline.of_view[1];
    if (std::abs(more) < kMinOutline * outline.of_difference) return;
    const int side = more > 0 ? 0 : 1;
    if (GoesOn(side) || Leans(side)) return;
    const LowResView& view = *view_[static_cast<std::size_t>(side)];
    for (std::size_t i = 0; i < with_rim_; ++i) {
      marks.push_back({index_[static_cast<std::size_t>(side)],
                       static_cast<std::size_t>(view.IndexOf(column_ + spot_[i].x, row_ + spot_[i].y))});
    }
  }

  // Whether the thing reaches out of the spot, as where both views show it a little apart: what lies around
  // the spot looks like it rather than like the ground that the other view has there.
  bool GoesOn(int side) const {
    cv::Vec3d thing, ground;
    for (std::size_t i = 0; i < spot_cells_; ++i) {
      for (int c = 0; c < 3; ++c) {
        thing[c] += At(side, spot_[i].x, spot_[i].y)[c];
        ground[c] += At(1 - side, spot_[i].x, spot_[i].y)[c];
      }
    }
    thing *= 1.0 / static_cast<double>(spot_cells_);
    ground *= 1.0 / static_cast<double>(spot_cells_);
    const auto alike = std::count_if(
        spot_.begin() + static_cast<std::ptrdiff_t>(spot_cells_), spot_.end(), [&](cv::Point at) {
          const std::uint8_t* rgb = At(side, at.x, at.y);
          const cv::Vec3d colour(rgb[0], rgb[1], rgb[2]);
          return cv::norm(colour - thing, cv::NORM_L1) < cv::norm(colour - ground, cv::NORM_L1);
        });
    return static_cast<double>(alike) > kMaxAlike * static_cast<double>(spot_.size() - spot_cells_);
  }

  // Whether the other view shows the same thing where a high one would stand out to.
  bool Leans(int side) const {
    const LowResView& here = *view_[static_cast<std::size_t>(side)];
    const LowResView& there = *view_[static_cast<std::size_t>(1 - side)];
    const cv::Point2d lean((here.camera_east_m - there.camera_east_m) / cell_m_,
                           (there.camera_north_m - here.camera_north_m) / cell_m_);
    const double length = cv::norm(lean);
    double apart = 0.0;
    for (std::size_t i = 0; i < spot_cells_; ++i) apart += Apart(here, there, spot_[i], {0, 0});
    for (double way = 1.0; way < kMaxLean * length; way += 1.0) {
      const cv::Point shift(cvRound(lean.x * way / length), cvRound(lean.y * way / length));
      double sum = 0.0;
      for (std::size_t i = 0; i < spot_cells_; ++i) sum += Apart(here, there, spot_[i], shift);
      if (sum < kMaxDifferenceOfAlike * apart) return true;
    }
    return false;
  }
  double Apart(const LowResView& here, const LowResView& there, cv::Point at, cv::Point shift) const {
    const auto i = static_cast<std::size_t>(here.IndexOf(column_ + at.x, row_ + at.y));
    const int j = there.IndexOf(column_ + at.x + shift.x, row_ + at.y + shift.y);
    if (j < 0 || there.seen[static_cast<std::size_t>(j)] == Seen::kNot) return 255.0;
    int most = 0;
    for (std::size_t c = 0; c < 3; ++c)
      most = std::max(most, std::abs(here.rgb[i][c] - there.rgb[static_cast<std::size_t>(j)][c]));
    return most;
  }

  const std::vector<LowResView>& views_;
  std::array<std::size_t, 2> index_;
  std::array<const LowResView*, 2> view_;
  const double cell_m_;
  const int longest_;                                  // cells
  int column_ = 0, row_ = 0, columns_ = 0, rows_ = 0;  // what both views' rectangles cover
  cv::Mat1b all_seen_, seen_;                          // by both; the memory, and the part in use
  cv::Mat1s all_differs_, differs_;
  cv::Mat3s all_steps_, all_around_;
  int pair_ = 0, spots_ = 0;  // counted from 1
  cv::Mat1i visited_;         // the last pair for which a cell was looked at
  cv::Mat1i order_;           // the last spot that a cell belonged to or surrounded
  std::vector<cv::Point> seeds_;
  std::vector<cv::Point> spot_;  // its cells, then those around
  std::size_t spot_cells_ = 0, with_rim_ = 0;
};

}  // namespace

void MarkMoving(std::vector<LowResView>& views, double cell_m, int threads) {
  std::vector<std::vector<Mark>> marks(views.size());
  ParallelFor(views.size(), threads, [&](std::size_t a) {
    Comparison comparison(views, a, cell_m);
    for (std::size_t b = a + 1; b < views.size(); ++b) comparison.With(b, marks[a]);
  });
  for (LowResView& view : views) view.is_moving.assign(view.seen.size(), false);
  for (const auto& found : marks) {
    for (const Mark& mark : found) views[mark.view].is_moving[mark.index] = true;
  }
}

}  // namespace skyquilt::render
