#include "core/render/block_weights.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/render/view_score.h"

namespace skyquilt::render {
namespace {

// Neighbouring cells of a pixel's cell and itself: what the quadratic B-spline reaches.
constexpr int kTaps = 3;
constexpr double kTransitionPx = 16.0;  // narrow: misfits of a pixel or two must not show as blur
constexpr float kLeastWeight = 1.0f / 512.0f;

// A quantity at the four nodes of a cell of the block's geometry, read between them.
struct Corners {
  float nw, ne, sw, se;
  float At(int x, int y) const {
    constexpr float kStep = 1.0f / kNodeStepPx;
    const float u = x * kStep;
    const float v = y * kStep;
    const float north = nw + u * (ne - nw);
    const float south = sw + u * (se - sw);
    return north + v * (south - north);
  }
};

struct NodeCell {
  Corners x, y, distance;
  bool is_valid = false;  // all four nodes are seen
};

NodeCell NodeCellOf(const PhotoView& view, int nodes_per_side, int row, int column) {
  const std::size_t k = static_cast<std::size_t>(row) * nodes_per_side + column;
  const std::array<std::size_t, 4> nodes{k, k + 1, k + nodes_per_side, k + nodes_per_side + 1};
  NodeCell cell;
  for (const std::size_t node : nodes) {
    if (std::isnan(view.pixel_in_image[node].x())) return cell;
  }
  const auto corners = [&](auto&& read) {
    return Corners{read(nodes[0]), read(nodes[1]), read(nodes[2]), read(nodes[3])};
  };
  cell.x = corners([&](std::size_t n) { return view.pixel_in_image[n].x(); });
  cell.y = corners([&](std::size_t n) { return view.pixel_in_image[n].y(); });
  cell.distance = corners([&](std::size_t n) { return view.nadir_distance_m[n]; });
  cell.is_valid = true;
  return cell;
}

// The labels of a cell and its neighbours.
struct Neighbourhood {
  std::array<std::int32_t, kTaps * kTaps> distinct{};
  std::array<int, kTaps * kTaps> slot{};  // of each label among the distinct ones; -1: no photo
  int count = 0;                          // of distinct photos
  bool is_whole = true;                   // no cell without a photo, no photo whose edge is near

  Neighbourhood(const BlockCells& cells, int column, int row) {
    const SeamMap& seams = cells.seams;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const std::int32_t label =
            seams.labels.At(cells.corner.x() + column + dx, cells.corner.y() + row + dy);
        int& own_slot = slot[static_cast<std::size_t>((dy + 1) * kTaps + dx + 1)];
        own_slot = -1;
        if (label == kNoPhoto) {
          is_whole = false;
          continue;
        }
        own_slot =
            static_cast<int>(std::find(distinct.begin(), distinct.begin() + count, label) - distinct.begin());
        if (own_slot < count) continue;
        distinct[static_cast<std::size_t>(count++)] = label;
        is_whole &= seams.levels[static_cast<std::size_t>(label)].SeesWhole(cells.corner.x() + column,
                                                                            cells.corner.y() + row);
      }
    }
  }
};

class Weigher {
 public:
  Weigher(const alignment::AlignedFlight& flight, const std::vector<std::uint32_t>& photos,
          const std::vector<PhotoView>& views, const BlockGeometry& block, const BlockCells& cells,
          double transition_m)
      : photos_(photos),
        views_(views),
        block_(block),
        cells_(cells),
        cell_px_(cells.seams.grid.cell_px),
        unit_px_(std::min(cell_px_, kNodeStepPx)) {
    for (const std::uint32_t photo : photos) scores_.push_back(ViewScore::Of(flight.photos[photo]));
    // Weights to this power: the B-spline's own width is about 1.5 cells.
    const double wanted =
        1.5 * (transition_m > 0.0 ? cells.seams.cell_m / transition_m : cell_px_ / kTransitionPx);
    sharpness_ = static_cast<int>(std::clamp(std::lround(wanted), 1L, 8L));
    spline_.resize(static_cast<std::size_t>(cell_px_));
    for (int i = 0; i < cell_px_; ++i) {
      const float t = (static_cast<float>(i) + 0.5f) / static_cast<float>(cell_px_) - 0.5f;
      spline_[static_cast<std::size_t>(i)] = {0.5f * (0.5f - t) * (0.5f - t), 0.75f - t * t,
                                              0.5f * (0.5f + t) * (0.5f + t)};
    }
    boxes_.resize(photos.size());
    share_of_.assign(photos.size(), -1);
  }

  std::vector<PhotoShare> Weigh() {
    for (int pass = 0; pass < 2; ++pass) {
      const bool is_writing = pass == 1;
      if (is_writing) MakeShares();
      for (int row = 0; row < cells_.side; ++row) {
        for (int column = 0; column < cells_.side; ++column) WeighCell(column, row, is_writing);
      }
    }
    return std::move(shares_);
  }

 private:
  struct Box {
    int x0 = 1 << 30, y0 = 1 << 30, x1 = -1, y1 = -1;  // pixels, last excluded
    void Include(int x, int y, int side) {
      x0 = std::min(x0, x), y0 = std::min(y0, y);
      x1 = std::max(x1, x + side), y1 = std::max(y1, y + side);
    }
  };

  int PlaceOf(std::int32_t label) const {
    const auto at = std::lower_bound(photos_.begin(), photos_.end(), static_cast<std::uint32_t>(label));
    return at != photos_.end() && *at == static_cast<std::uint32_t>(label)
               ? static_cast<int>(at - photos_.begin())
               : -1;
  }

  void MakeShares() {
    for (std::size_t i = 0; i < photos_.size(); ++i) {
      Box box = boxes_[i];
      if (box.x1 < 0) continue;
      // Whole cells of the geometry: the renderer maps them one at a time.
      box.x0 = box.x0 / kNodeStepPx * kNodeStepPx, box.y0 = box.y0 / kNodeStepPx * kNodeStepPx;
      box.x1 = (box.x1 + kNodeStepPx - 1) / kNodeStepPx * kNodeStepPx;
      box.y1 = (box.y1 + kNodeStepPx - 1) / kNodeStepPx * kNodeStepPx;
      PhotoShare share{photos_[i], box.x0, box.y0, box.x1 - box.x0, box.y1 - box.y0, {}};
      share.weight.assign(static_cast<std::size_t>(share.width) * share.height, 0.0f);
      share_of_[i] = static_cast<int>(shares_.size());
      shares_.push_back(std::move(share));
    }
  }

  float& WeightAt(int place, int x, int y) {
    PhotoShare& share = shares_[static_cast<std::size_t>(share_of_[static_cast<std::size_t>(place)])];
    return share
        .weight[static_cast<std::size_t>(y - share.y) * share.width + static_cast<std::size_t>(x - share.x)];
  }

  void WeighCell(int column, int row, bool is_writing) {
    const Neighbourhood around(cells_, column, row);
    if (around.is_whole) {
      std::array<int, kTaps * kTaps> places{};
      for (int i = 0; i < around.count; ++i)
        places[static_cast<std::size_t>(i)] = PlaceOf(around.distinct[static_cast<std::size_t>(i)]);
      if (!is_writing) {
        for (int i = 0; i < around.count; ++i) {
          boxes_[static_cast<std::size_t>(places[static_cast<std::size_t>(i)])].Include(
              column * cell_px_, row * cell_px_, cell_px_);
        }
        return;
      }
      if (around.count == 1) {
        for (int dy = 0; dy < cell_px_; ++dy) {
          std::fill_n(&WeightAt(places[0], column * cell_px_, row * cell_px_ + dy), cell_px_, 1.0f);
        }
        return;
      }
      for (int dy = 0; dy < cell_px_; ++dy) {
        for (int dx = 0; dx < cell_px_; ++dx) {
          const auto weights = LabelWeights(around, dx, dy);
          float sum = 0.0f;
          for (int i = 0; i < around.count; ++i) sum += weights[static_cast<std::size_t>(i)];
          for (int i = 0; i < around.count; ++i) {
            const float weight = weights[static_cast<std::size_t>(i)];
            if (weight > 0.0f)
              WeightAt(places[static_cast<std::size_t>(i)], column * cell_px_ + dx, row * cell_px_ + dy) =
                  weight / sum;
          }
        }
      }
      return;
    }
    for (int y = 0; y < cell_px_; y += unit_px_) {
      for (int x = 0; x < cell_px_; x += unit_px_) WeighEdgeUnit(around, column, row, x, y, is_writing);
    }
  }

  // By distinct label, sharpened; those too small to be seen are 0.
  std::array<float, kTaps * kTaps> LabelWeights(const Neighbourhood& around, int dx, int dy) const {
    std::array<float, kTaps * kTaps> weights{};
    if (around.count == 1) {
      weights[0] = 1.0f;
      return weights;
    }
    const auto& across = spline_[static_cast<std::size_t>(dx)];
    const auto& down = spline_[static_cast<std::size_t>(dy)];
    for (int tap = 0; tap < kTaps * kTaps; ++tap) {
      const int at = around.slot[static_cast<std::size_t>(tap)];
      if (at < 0) continue;
      weights[static_cast<std::size_t>(at)] +=
          across[static_cast<std::size_t>(tap % kTaps)] * down[static_cast<std::size_t>(tap / kTaps)];
    }
    float most = 0.0f;
    for (int i = 0; i < around.count; ++i) {
      float& weight = weights[static_cast<std::size_t>(i)];
      const float base = weight;
      for (int power = 1; power < sharpness_; ++power) weight *= base;
      most = std::max(most, weight);
    }
    for (int i = 0; i < around.count; ++i) {
      float& weight = weights[static_cast<std::size_t>(i)];
      if (weight < kLeastWeight * most) weight = 0.0f;
    }
    return weights;
  }

  // At the edge of the map or of a photo every pixel is asked who sees it.
  void WeighEdgeUnit(const Neighbourhood& around, int column, int row, int x, int y, bool is_writing) {
    const int first_x = column * cell_px_ + x, first_y = row * cell_px_ + y;
    std::vector<int> candidates;
    std::vector<NodeCell> nodes;
    for (std::size_t i = 0; i < photos_.size(); ++i) {
      if (!views_[i].sees_block) continue;
      const NodeCell cell =
          NodeCellOf(views_[i], block_.nodes_per_side, first_y / kNodeStepPx, first_x / kNodeStepPx);
      if (!cell.is_valid) continue;
      candidates.push_back(static_cast<int>(i));
      nodes.push_back(cell);
    }
    if (!is_writing) {
      for (std::size_t c = 0; c < candidates.size(); ++c) {
        if (IsNear(nodes[c], scores_[static_cast<std::size_t>(candidates[c])])) {
          boxes_[static_cast<std::size_t>(candidates[c])].Include(first_x, first_y, unit_px_);
        }
      }
      return;
    }
    std::array<int, kTaps * kTaps> label_place{};
    for (int i = 0; i < around.count; ++i)
      label_place[static_cast<std::size_t>(i)] = PlaceOf(around.distinct[static_cast<std::size_t>(i)]);
    std::vector<float> weights(candidates.size());
    for (int dy = 0; dy < unit_px_; ++dy) {
      for (int dx = 0; dx < unit_px_; ++dx) {
        const auto by_label = LabelWeights(around, x + dx, y + dy);
        const int node_x = (first_x + dx) % kNodeStepPx, node_y = (first_y + dy) % kNodeStepPx;
        float sum = 0.0f, best = std::numeric_limits<float>::infinity();
        int best_candidate = -1;
        for (std::size_t c = 0; c < candidates.size(); ++c) {
          weights[c] = 0.0f;
          const ViewScore& score = scores_[static_cast<std::size_t>(candidates[c])];
          const float margin = score.Margin(nodes[c].x.At(node_x, node_y), nodes[c].y.At(node_x, node_y));
          if (margin < 0.0f) continue;
          const float value = score.Score(nodes[c].distance.At(node_x, node_y), margin);
          if (value < best) best = value, best_candidate = static_cast<int>(c);
          for (int i = 0; i < around.count; ++i) {
            if (label_place[static_cast<std::size_t>(i)] == candidates[c])
              weights[c] = by_label[static_cast<std::size_t>(i)];
          }
          sum += weights[c];
        }
        if (best_candidate < 0) continue;
        if (sum <= 0.0f) weights[static_cast<std::size_t>(best_candidate)] = sum = 1.0f;
        for (std::size_t c = 0; c < candidates.size(); ++c) {
          if (weights[c] > 0.0f) WeightAt(candidates[c], first_x + dx, first_y + dy) = weights[c] / sum;
        }
      }
    }
  }

  // Whether some pixel between the nodes may lie in the image.
  static bool IsNear(const NodeCell& cell, const ViewScore& score) {
    const auto [x0, x1] = std::minmax({cell.x.nw, cell.x.ne, cell.x.sw, cell.x.se});
    const auto [y0, y1] = std::minmax({cell.y.nw, cell.y.ne, cell.y.sw, cell.y.se});
    return x1 >= -0.5f && y1 >= -0.5f && x0 <= score.width_px - 0.5f && y0 <= score.height_px - 0.5f;
  }

  const std::vector<std::uint32_t>& photos_;
  const std::vector<PhotoView>& views_;
  const BlockGeometry& block_;
  const BlockCells& cells_;
  const int cell_px_;
  const int unit_px_;  // pixels that share a cell and four nodes
  int sharpness_ = 3;
  std::vector<ViewScore> scores_;
  std::vector<std::array<float, kTaps>> spline_;
  std::vector<Box> boxes_;
  std::vector<int> share_of_;
  std::vector<PhotoShare> shares_;
};

}  // namespace

BlockCells::BlockCells(const SeamMap& map, const geo::TileId& block_tile, int block_levels)
    : seams(map),
      corner(map.grid.CellOfBlock(block_tile, block_levels)),
      side((map.grid.tile_size_px << block_levels) / map.grid.cell_px) {}

bool BlockCells::IsInner() const {
  for (int row = 0; row < side; ++row) {
    for (int column = 0; column < side; ++column) {
      if (!Neighbourhood(*this, column, row).is_whole) return false;
    }
  }
  return true;
}

std::vector<PhotoShare> WeighPhotos(const alignment::AlignedFlight& flight,
                                    const std::vector<std::uint32_t>& photos,
                                    const std::vector<PhotoView>& views, const BlockGeometry& block,
                                    const BlockCells& cells, double transition_m) {
  return Weigher(flight, photos, views, block, cells, transition_m).Weigh();
}

}  // namespace skyquilt::render
