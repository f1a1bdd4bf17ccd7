#include "core/render/seams/label_seams.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "core/render/seams/graph_cut.h"

namespace skyquilt::render {
namespace {

// Costs in quarters of a grey level, a cell or an edge between cells.
constexpr int kQuarters = 4;
// A view that is one height above ground farther from nadir than the best.
constexpr double kNadirCost = 12.0;
// Any seam, however well it fits: keeps them short.
constexpr int kSeamCost = 2 * kQuarters;
// What a grey level of difference costs, cell by cell of the seam.
constexpr int kMisfitCost = 3 * kQuarters;
// A view whose edge lies within the cell: only where there is no other.
constexpr int kPartlyCost = 400 * kQuarters;
// Cells of a seam that only one of the two photos sees say nothing of how well they fit.
constexpr int kUnknownSeamCost = 40 * kQuarters;
// A view of a thing that is soon gone, where another view shows the ground without it.
constexpr int kMovingCost = 30 * kQuarters;
constexpr int kSweeps = 2;
// A view this much worse than the best (in heights above ground) never gets a cell.
constexpr float kMaxWorseHeights = 0.75f;

class Labeller {
 public:
  Labeller(const std::vector<LowResView>& views, const SeamGrid& grid, const LabelOptions& options)
      : views_(views),
        labels_(grid.columns, grid.rows),
        height_m_(static_cast<float>(std::max(1.0, options.height_m))) {
    TakeBest();
    if (options.known != nullptr) TakeKnown(*options.known, grid);
    if (!options.moves_seams) return;
    const std::size_t first = options.known != nullptr ? options.known->photos : 0;
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      bool changed = false;
      for (std::size_t photo = first; photo < views_.size(); ++photo)
        changed |= Expand(static_cast<std::int32_t>(photo));
      if (!changed) break;
    }
  }
  SeamLabels Take() { return std::move(labels_); }

 private:
  struct Node {
    int column, row;
    std::int32_t label;
  };

  const LowResView& View(std::int32_t photo) const { return views_[static_cast<std::size_t>(photo)]; }

  void TakeBest() {
    for (std::size_t photo = 0; photo < views_.size(); ++photo) {
      const LowResView& view = views_[photo];
      for (int y = 0; y < view.rows; ++y) {
        for (int x = 0; x < view.columns; ++x) {
          const int column = view.column + x, row = view.row + y;
          if (view.seen[static_cast<std::size_t>(y * view.columns + x)] == Seen::kNot || column < 0 ||
              row < 0 || column >= labels_.columns() || row >= labels_.rows()) {
            continue;
          }
          const std::int32_t best = labels_.At(column, row);
          if (best == kNoPhoto || IsBetter(view, View(best), column, row)) {
            labels_.Set(column, row, static_cast<std::int32_t>(photo));
          }
        }
      }
    }
    best_ = labels_;
  }

  // Cells that an earlier run decided, as long as their photo still sees them.
  void TakeKnown(const KnownLabels& known, const SeamGrid& grid) {
    for (int row = 0; row < labels_.rows(); ++row) {
      for (int column = 0, alike = 1; column < labels_.columns(); column += alike) {
        alike = labels_.AlikeFrom(column, row);
        const std::int32_t label = known.AtWorld(grid.first_column + column, grid.first_row + row);
        if (label == kNoPhoto || labels_.At(column, row) == kNoPhoto) continue;
        const int index = View(label).IndexOf(column, row);
        if (index < 0 || View(label).seen[static_cast<std::size_t>(index)] == Seen::kNot) continue;
        labels_.Set(column, row, label);
      }
    }
  }

  static bool IsBetter(const LowResView& view, const LowResView& than, int column, int row) {
    const auto i = static_cast<std::size_t>(view.IndexOf(column, row));
    const auto j = static_cast<std::size_t>(than.IndexOf(column, row));
    if (view.seen[i] != than.seen[j]) return view.seen[i] > than.seen[j];
    return view.score_m[i] < than.score_m[j];
  }

  // What it costs that a photo shows a cell.
  int CellCost(std::int32_t photo, int column, int row) const {
    const LowResView& view = View(photo);
    const auto i = static_cast<std::size_t>(view.IndexOf(column, row));
    const LowResView& best = View(best_.At(column, row));
    const float worse_m = view.score_m[i] - best.score_m[static_cast<std::size_t>(best.IndexOf(column, row))];
    const double nadir = kQuarters * kNadirCost * std::max(0.0f, worse_m) / height_m_;
    return static_cast<int>(std::lround(nadir)) + (view.seen[i] == Seen::kPartly ? kPartlyCost : 0) +
           (!view.is_moving.empty() && view.is_moving[i] ? kMovingCost : 0);
  }

  // Colour difference of two photos at a cell, the sum of three channels; -1 where one does not see it.
  static int Difference(const LowResView& a, const LowResView& b, int column, int row) {
    const int i = a.IndexOf(column, row), j = b.IndexOf(column, row);
    if (i < 0 || j < 0 || a.seen[static_cast<std::size_t>(i)] == Seen::kNot ||
        b.seen[static_cast<std::size_t>(j)] == Seen::kNot) {
      return -1;
    }
    const auto& p = a.rgb[static_cast<std::size_t>(i)];
    const auto& q = b.rgb[static_cast<std::size_t>(j)];
    return std::abs(p[0] - q[0]) + std::abs(p[1] - q[1]) + std::abs(p[2] - q[2]);
  }

  // The worst difference of a cell and those around it: a seam keeps a cell away from whatever disagrees, and
  // the outlines of a thing count although its inside may be plain.
  int Misfit(std::int32_t a, std::int32_t b, int column, int row) const {
    if (Difference(View(a), View(b), column, row) < 0) return -1;
    int worst = 0;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx)
        worst = std::max(worst, Difference(View(a), View(b), column + dx, row + dy));
    }
    return worst;
  }

  // Misfit of one photo against others, over all its view at once; made when first asked for.
  class MisfitsOf {
   public:
    MisfitsOf(const std::vector<LowResView>& views, std::int32_t photo)
        : views_(views), view_(views[static_cast<std::size_t>(photo)]) {}
    int At(std::int32_t other, int column, int row) {
      const int index = view_.IndexOf(column, row);
      if (index < 0) return -1;
      cv::Mat1s& misfit = by_photo_[other];
      if (misfit.empty()) misfit = Make(views_[static_cast<std::size_t>(other)]);
      return misfit(index / view_.columns, index % view_.columns);
    }

   private:
    cv::Mat1s Make(const LowResView& other) const {
      cv::Mat1s difference(view_.rows, view_.columns);
      for (int y = 0; y < view_.rows; ++y) {
        for (int x = 0; x < view_.columns; ++x) {
          difference(y, x) = static_cast<short>(Difference(view_, other, view_.column + x, view_.row + y));
        }
      }
      cv::Mat1s worst;
      cv::dilate(difference, worst, cv::Mat::ones(3, 3, CV_8U));
      worst.setTo(-1, difference < 0);
      return worst;
    }
    const std::vector<LowResView>& views_;
    const LowResView& view_;
    std::map<std::int32_t, cv::Mat1s> by_photo_;
  };

  // What a seam costs on the edge between two neighbouring cells with these misfits.
  static int SeamCost(int here, int there) {
    if (here < 0 && there < 0) return kSeamCost + kUnknownSeamCost;
    const int sum = here < 0 ? 2 * there : there < 0 ? 2 * here : here + there;
    return kSeamCost + sum * kMisfitCost / 6;  // the mean of two cells and three channels
  }

  bool MayTake(std::int32_t photo, int index, int column, int row, std::int32_t present) const {
    const LowResView& view = View(photo);
    const auto i = static_cast<std::size_t>(index);
    if (view.seen[i] == Seen::kNot) return false;
    const LowResView& best = View(best_.At(column, row));
    const auto j = static_cast<std::size_t>(best.IndexOf(column, row));
    if (view.seen[i] < best.seen[j]) return false;
    return view.score_m[i] - best.score_m[j] <= kMaxWorseHeights * height_m_ && present != photo;
  }

  // Every cell that gains by it takes this photo, all at once. True: some did.
  bool Expand(std::int32_t photo) {
    const LowResView& view = View(photo);
    std::vector<int> node_of(view.seen.size(), -1);
    std::vector<Node> nodes;
    for (int y = 0; y < view.rows; ++y) {
      for (int x = 0; x < view.columns; ++x) {
        const int index = y * view.columns + x;
        const int column = view.column + x, row = view.row + y;
        const std::int32_t present = labels_.At(column, row);
        if (present == kNoPhoto || !MayTake(photo, index, column, row, present)) continue;
        node_of[static_cast<std::size_t>(index)] = static_cast<int>(nodes.size());
        nodes.push_back({column, row, present});
      }
    }
    if (nodes.empty()) return false;
    GraphCut cut(nodes.size(), 2 * nodes.size());
    std::vector<int> keeps(nodes.size()), takes(nodes.size());
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      keeps[i] = CellCost(nodes[i].label, nodes[i].column, nodes[i].row);
      takes[i] = CellCost(photo, nodes[i].column, nodes[i].row);
    }
    MisfitsOf misfits(views_, photo);
    constexpr int kNeighbours[4][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const Node& node = nodes[i];
      for (int direction = 0; direction < 4; ++direction) {
        const int column = node.column + kNeighbours[direction][0],
                  row = node.row + kNeighbours[direction][1];
        const std::int32_t other = labels_.At(column, row);
        if (other == kNoPhoto) continue;
        const int index = view.IndexOf(column, row);
        const int j = index < 0 ? -1 : node_of[static_cast<std::size_t>(index)];
        // A seam between this photo and another, or between two others.
        const auto cost_to = [&](std::int32_t a) {
          return a == photo ? 0 : SeamCost(misfits.At(a, node.column, node.row), misfits.At(a, column, row));
        };
        const auto cost_between = [&](std::int32_t a, std::int32_t b) {
          if (a == b) return 0;
          if (a == photo) return cost_to(b);
          if (b == photo) return cost_to(a);
          return SeamCost(Misfit(a, b, node.column, node.row), Misfit(a, b, column, row));
        };
        if (j < 0) {  // the neighbour stays as it is
          keeps[i] += cost_between(node.label, other);
          takes[i] += cost_to(other);
          continue;
        }
        if (direction > 1) continue;  // counted from the other side
        const int keep_keep = cost_between(node.label, other);
        const int keep_take = cost_to(node.label);
        const int take_keep = cost_to(other);
        // keep_keep + (take_keep - keep_keep) take_i - take_keep take_j + (keep_take + take_keep - keep_keep)
        // keep_i take_j
        keeps[i] += keep_keep;
        takes[i] += take_keep;
        keeps[static_cast<std::size_t>(j)] += take_keep;
        cut.AddEdge(i, static_cast<std::size_t>(j), std::max(0, keep_take + take_keep - keep_keep));
      }
    }
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const int least = std::min(keeps[i], takes[i]);
      cut.AddTerminals(i, takes[i] - least, keeps[i] - least);
    }
    cut.Solve();
    bool changed = false;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      if (!cut.IsOnSinkSide(i)) continue;  // nor where both cost the same
      labels_.Set(nodes[i].column, nodes[i].row, photo);
      changed = true;
    }
    return changed;
  }

  const std::vector<LowResView>& views_;
  SeamLabels labels_;
  SeamLabels best_;
  const float height_m_;
};

}  // namespace

SeamLabels LabelSeams(const std::vector<LowResView>& views, const SeamGrid& grid,
                      const LabelOptions& options) {
  return Labeller(views, grid, options).Take();
}

}  // namespace skyquilt::render
