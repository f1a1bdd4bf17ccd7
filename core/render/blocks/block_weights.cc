#include "core/render/blocks/block_weights.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "core/render/seams/low_res_view.h"

namespace skyquilt::render {
namespace {

// Neighbouring cells of a pixel's cell and itself: what the quadratic B-spline reaches.
constexpr int kTaps = 3;
constexpr double kTransitionPx = 16.0;  // narrow: misfits of a pixel or two must not show as blur
constexpr float kMinWeight = 1.0f / 512.0f;

// A quantity at the four nodes of a cell of the block's geometry, read between them: u and v go from 0 to 1.
struct Corners {
  float nw, ne, sw, se;
  float At(float u, float v) const {
    const float north = nw + u * (ne - nw);
    const float south = sw + u * (se - sw);
    return north + v * (south - north);
  }
};

struct NodeCell {
  Corners x, y, distance;
  bool is_valid = false;  // all four nodes are seen, and nothing stands before them that matters
};

NodeCell NodeCellOf(const PhotoView& view, int nodes_per_side, int row, int column, bool past_things) {
  const std::size_t k = static_cast<std::size_t>(row) * nodes_per_side + column;
  const std::array<std::size_t, 4> nodes{k, k + 1, k + nodes_per_side, k + nodes_per_side + 1};
  NodeCell cell;
  for (const std::size_t node : nodes) {
    if (std::isnan(view.pixel_in_image[node].x())) return cell;
    if (!past_things && !view.is_hidden.empty() && view.is_hidden[node]) return cell;
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
          const std::vector<PhotoView>& views, const BlockGeometry& block, const BlockCells& cells)
      : photos_(photos),
        views_(views),
        block_(block),
        cells_(cells),
        cell_px_(cells.seams.grid.cell_px),
        square_px_(std::min(cell_px_ / 2, kNodeStepPx)) {
    for (const std::uint32_t photo : photos) scores_.push_back(ViewScore::Of(flight.photos[photo]));
    // Weights to this power: the B-spline's own width is about 1.5 cells.
    const double wanted = 1.5 * cell_px_ / kTransitionPx;
    sharpness_ = static_cast<int>(std::clamp(std::lround(wanted), 1L, 8L));
    for (auto& tap : spline_) tap.resize(static_cast<std::size_t>(cell_px_));
    for (int i = 0; i < cell_px_; ++i) {
      const float t = (static_cast<float>(i) + 0.5f) / static_cast<float>(cell_px_) - 0.5f;
      spline_[0][static_cast<std::size_t>(i)] = 0.5f * (0.5f - t) * (0.5f - t);
      spline_[1][static_cast<std::size_t>(i)] = 0.75f - t * t;
      spline_[2][static_cast<std::size_t>(i)] = 0.5f * (0.5f + t) * (0.5f + t);
    }
    shares_.resize(photos.size());
    at_edge_.resize(photos.size());
    hides_ = std::any_of(views.begin(), views.end(),
                         [](const PhotoView& view) { return !view.is_hidden.empty(); });
    for (std::size_t i = 0; i < photos.size(); ++i) shares_[i].photo = photos[i];
  }

  BlockShares Weigh() {
    for (int row = 0; row < cells_.side; ++row) {
      for (int column = 0; column < cells_.side; ++column) WeighCell(column, row);
    }
    std::erase_if(shares_, [](const PhotoShare& share) { return share.squares.empty(); });
    return {square_px_, std::move(shares_)};
  }

 private:
  // Weights of a square by its pixels, row by row.
  using Square = std::array<float, static_cast<std::size_t>(kNodeStepPx) * kNodeStepPx>;
  using LabelSquares = std::array<Square, kTaps * kTaps>;

  int PlaceOf(std::int32_t label) const {
    const auto at = std::lower_bound(photos_.begin(), photos_.end(), static_cast<std::uint32_t>(label));
    return at != photos_.end() && *at == static_cast<std::uint32_t>(label)
               ? static_cast<int>(at - photos_.begin())
               : -1;
  }

  int PixelsOfSquare() const { return square_px_ * square_px_; }

  // What a photo has of the square at (x, y); nothing is added where it has nothing.
  void Add(int place, int x, int y, const Square& weights) {
    const auto end = weights.begin() + PixelsOfSquare();
    if (std::none_of(weights.begin(), end, [](float weight) { return weight > 0.0f; })) return;
    PhotoShare& share = shares_[static_cast<std::size_t>(place)];
    if (std::all_of(weights.begin(), end, [](float weight) { return weight == 1.0f; })) {
      share.squares.push_back({x, y});
      return;
    }
    share.squares.push_back({x, y, static_cast<std::int32_t>(share.weights.size())});
    share.weights.insert(share.weights.end(), weights.begin(), end);
  }

  // Whether these photos see all nodes around a square: the seam map knows of a cell's middle alone, and what
  // is near the horizon, or further off the vertical than is shown, may begin within the cell.
  bool AreSeen(const std::array<int, kTaps * kTaps>& places, int count, int x, int y) const {
    const int step = block_.node_step_px;
    for (int i = 0; i < count; ++i) {
      const PhotoView& view = views_[static_cast<std::size_t>(places[static_cast<std::size_t>(i)])];
      for (int row = y / step; row * step < y + square_px_ + step; ++row) {
        for (int column = x / step; column * step < x + square_px_ + step; ++column) {
          const auto node = static_cast<std::size_t>(row) * block_.nodes_per_side + column;
          if (std::isnan(view.pixel_in_image[node].x())) return false;
        }
      }
    }
    return true;
  }

  void WeighCell(int column, int row) {
    const Neighbourhood around(cells_, column, row);
    std::array<int, kTaps * kTaps> places{};
    for (int i = 0; i < around.count; ++i)
      places[static_cast<std::size_t>(i)] = PlaceOf(around.distinct[static_cast<std::size_t>(i)]);
    for (int y = 0; y < cell_px_; y += square_px_) {
      for (int x = 0; x < cell_px_; x += square_px_) {
        const int block_x = column * cell_px_ + x, block_y = row * cell_px_ + y;
        if (!around.is_whole || !AreSeen(places, around.count, block_x, block_y)) {
          WeighAtEdge(around, places, x, y, block_x, block_y);
        } else if (around.count == 1) {
          shares_[static_cast<std::size_t>(places[0])].squares.push_back({block_x, block_y});
        } else {
          WeighLabels(around, x, y);
          Normalise(around.count);
          for (int i = 0; i < around.count; ++i)
            Add(places[static_cast<std::size_t>(i)], block_x, block_y,
                by_label_[static_cast<std::size_t>(i)]);
        }
      }
    }
  }

  // Into by_label_, of the square at (x, y) of the cell: by distinct label, sharpened; those too small to be
  // seen are 0.
  void WeighLabels(const Neighbourhood& around, int x, int y) {
    const auto count = static_cast<std::size_t>(around.count);
    const auto side = static_cast<std::size_t>(square_px_);
    if (count == 1) {
      by_label_[0].fill(1.0f);
      return;
    }
    for (std::size_t dy = 0; dy < side; ++dy) {
      std::array<std::array<float, kTaps>, kTaps * kTaps> columns{};  // by label: its weight in each column
      for (std::size_t tap = 0; tap < kTaps * kTaps; ++tap) {
        if (around.slot[tap] < 0) continue;
        columns[static_cast<std::size_t>(around.slot[tap])][tap % kTaps] +=
            spline_[tap / kTaps][static_cast<std::size_t>(y) + dy];
      }
      std::array<float, kNodeStepPx> most{};
      const float* west = spline_[0].data() + x;
      const float* middle = spline_[1].data() + x;
      const float* east = spline_[2].data() + x;
      for (std::size_t i = 0; i < count; ++i) {
        float* weights = by_label_[i].data() + dy * side;
        for (std::size_t dx = 0; dx < side; ++dx) {
          const float base = columns[i][0] * west[dx] + columns[i][1] * middle[dx] + columns[i][2] * east[dx];
          float weight = base;
          for (int power = 1; power < sharpness_; ++power) weight *= base;
          weights[dx] = weight;
          most[dx] = std::max(most[dx], weight);
        }
      }
      for (std::size_t i = 0; i < count; ++i) {
        float* weights = by_label_[i].data() + dy * side;
        for (std::size_t dx = 0; dx < side; ++dx)
          weights[dx] = weights[dx] < kMinWeight * most[dx] ? 0.0f : weights[dx];
      }
    }
  }

  void Normalise(int count) {
    const auto pixels = static_cast<std::size_t>(PixelsOfSquare());
    Square sum{};
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
      for (std::size_t p = 0; p < pixels; ++p) sum[p] += by_label_[i][p];
    }
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
      for (std::size_t p = 0; p < pixels; ++p) by_label_[i][p] /= sum[p];
    }
  }

  // At the edge of the map or of a photo every pixel is asked who sees it.
  void WeighAtEdge(const Neighbourhood& around, const std::array<int, kTaps * kTaps>& label_place, int x,
                   int y, int block_x, int block_y) {
    WeighLabels(around, x, y);
    const int part_px = std::min(square_px_, block_.node_step_px);
    for (int top = 0; top < square_px_; top += part_px) {
      for (int left = 0; left < square_px_; left += part_px)
        WeighPart(around, label_place, block_x, block_y, left, top, part_px);
    }
    for (std::size_t i = 0; i < at_edge_.size(); ++i) {
      if (!at_edge_[i]) continue;
      Add(static_cast<int>(i), block_x, block_y, *at_edge_[i]);
      at_edge_[i].reset();
    }
  }

  // A part of that square in one cell of nodes, `left` and `top` in the square. What lies between places that
  // are hidden from one photo each is shown by whoever looks there, so that the map has no holes.
  void WeighPart(const Neighbourhood& around, const std::array<int, kTaps * kTaps>& label_place, int block_x,
                 int block_y, int left, int top, int part_px) {
    for (int dy = top; dy < top + part_px; ++dy)
      std::fill_n(is_shown_.begin() + dy * square_px_ + left, part_px, false);
    FindCandidates(around, label_place, block_x + left, block_y + top, false);
    if (WeighPixels(block_x, block_y, left, top, part_px) || !hides_) return;
    FindCandidates(around, label_place, block_x + left, block_y + top, true);
    WeighPixels(block_x, block_y, left, top, part_px);
  }

  void FindCandidates(const Neighbourhood& around, const std::array<int, kTaps * kTaps>& label_place, int x,
                      int y, bool past_things) {
    candidates_.clear();
    for (std::size_t i = 0; i < photos_.size(); ++i) {
      if (!views_[i].sees_block) continue;
      const NodeCell nodes = NodeCellOf(views_[i], block_.nodes_per_side, y / block_.node_step_px,
                                        x / block_.node_step_px, past_things);
      if (!nodes.is_valid || !IsNear(nodes, scores_[i])) continue;
      const auto label =
          std::find(label_place.begin(), label_place.begin() + around.count, static_cast<int>(i)) -
          label_place.begin();
      if (!at_edge_[i]) at_edge_[i].emplace(Square{});
      candidates_.push_back(
          {&*at_edge_[i], &scores_[i],
           label < around.count ? by_label_[static_cast<std::size_t>(label)].data() : nullptr, nodes});
    }
  }

  // Of those that are not shown yet; whether all are now.
  bool WeighPixels(int block_x, int block_y, int left, int top, int part_px) {
    const int step_px = block_.node_step_px;
    const int west_px = (block_x + left) % step_px - left, north_px = (block_y + top) % step_px - top;
    const float per_px = 1.0f / static_cast<float>(step_px);
    bool all = true;
    for (int dy = top; dy < top + part_px; ++dy) {
      const float node_y = static_cast<float>(north_px + dy) * per_px;
      for (int dx = left; dx < left + part_px; ++dx) {
        const auto pixel = static_cast<std::size_t>(dy * square_px_ + dx);
        if (is_shown_[pixel]) continue;
        const float node_x = static_cast<float>(west_px + dx) * per_px;
        float sum = 0.0f, best = std::numeric_limits<float>::infinity();
        const Candidate* best_candidate = nullptr;
        for (const Candidate& candidate : candidates_) {
          const ViewScore& score = *candidate.score;
          const float margin =
              score.Margin(candidate.nodes.x.At(node_x, node_y), candidate.nodes.y.At(node_x, node_y));
          if (margin < 0.0f) continue;
          const float value = score.Score(candidate.nodes.distance.At(node_x, node_y), margin);
          if (value < best) best = value, best_candidate = &candidate;
          float& weight = (*candidate.weights)[pixel];
          if (candidate.label_weights != nullptr) weight = candidate.label_weights[pixel];
          sum += weight;
        }
        is_shown_[pixel] = best_candidate != nullptr;
        all = all && is_shown_[pixel];
        if (best_candidate == nullptr) continue;
        if (sum <= 0.0f) (*best_candidate->weights)[pixel] = sum = 1.0f;
        for (const Candidate& candidate : candidates_) (*candidate.weights)[pixel] /= sum;
      }
    }
    return all;
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
  const int square_px_;
  int sharpness_ = 3;
  std::vector<ViewScore> scores_;
  std::array<std::vector<float>, kTaps> spline_;  // by tap, then by pixel of a cell
  LabelSquares by_label_{};
  // Of the square at hand, where every pixel is asked: what each photo has of it, if it may see some.
  struct Candidate {
    Square* weights;
    const ViewScore* score;
    const float* label_weights;  // null: no photo of the cells around
    NodeCell nodes;
  };
  std::vector<std::optional<Square>> at_edge_;  // by photo
  std::vector<Candidate> candidates_;
  std::array<bool, static_cast<std::size_t>(kNodeStepPx) * kNodeStepPx> is_shown_{};  // by pixel
  bool hides_ = false;  // whether anything stands before some of the ground
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
      if (!IsWhole(column, row)) return false;
    }
  }
  return true;
}

bool BlockCells::IsWhole(int column, int row) const { return Neighbourhood(*this, column, row).is_whole; }

std::vector<std::uint32_t> BlockCells::PhotosAround(int column, int row) const {
  const Neighbourhood around(*this, column, row);
  return {around.distinct.begin(), around.distinct.begin() + around.count};
}

BlockShares WeighPhotos(const alignment::AlignedFlight& flight, const std::vector<std::uint32_t>& photos,
                        const std::vector<PhotoView>& views, const BlockGeometry& block,
                        const BlockCells& cells) {
  return Weigher(flight, photos, views, block, cells).Weigh();
}

}  // namespace skyquilt::render
