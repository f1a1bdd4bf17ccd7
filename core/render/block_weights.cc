#include "core/render/block_weights.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace skyquilt::render {
namespace {

// Seams keep off the outer part of a photo: lens fall-off and the worst of the distortion are there.
constexpr float kBorderShare = 0.06f;
// How far a photo gives way at its very border, in heights above ground.
constexpr float kBorderPenaltyHeights = 4.0f;
constexpr float kPoseOnlyPenaltyHeights = 0.3f;

struct ScoreRule {
  float width = 0.0f, height = 0.0f;  // of the image, px
  float taper_px = 1.0f;
  float border_penalty_m = 0.0f;
  float constant_m = 0.0f;

  float Margin(float x, float y) const {
    return std::min(std::min(x + 0.5f, width - 0.5f - x), std::min(y + 0.5f, height - 0.5f - y));
  }
  float Score(float nadir_distance_m, float margin_px) const {
    const float lack = std::max(0.0f, 1.0f - margin_px / taper_px);
    return nadir_distance_m + constant_m + border_penalty_m * lack * lack;
  }
};

ScoreRule RuleFor(const alignment::AlignedPhoto& photo) {
  ScoreRule rule;
  rule.width = static_cast<float>(photo.intrinsics.width_px);
  rule.height = static_cast<float>(photo.intrinsics.height_px);
  rule.taper_px = std::max(1.0f, kBorderShare * std::min(rule.width, rule.height));
  rule.border_penalty_m = kBorderPenaltyHeights * static_cast<float>(std::max(1.0, photo.height_above_ground_m));
  // Of two photos that see a point equally well, the one whose place is known better.
  rule.constant_m = static_cast<float>(std::min(photo.error_radius_m, photo.height_above_ground_m));
  // Every seam between an aligned photo and one that is not shows a step: let there be few.
  if (photo.placement == alignment::Placement::kPoseOnly) {
    rule.constant_m += kPoseOnlyPenaltyHeights * static_cast<float>(photo.height_above_ground_m);
  }
  return rule;
}

// A quantity at the four nodes of a cell, read between them.
struct Corners {
  float nw, ne, sw, se;
  float Min() const { return std::min(std::min(nw, ne), std::min(sw, se)); }
  float Max() const { return std::max(std::max(nw, ne), std::max(sw, se)); }
  float At(int x, int y) const {
    constexpr float kStep = 1.0f / kNodeStepPx;
    const float u = x * kStep;
    const float v = y * kStep;
    const float north = nw + u * (ne - nw);
    const float south = sw + u * (se - sw);
    return north + v * (south - north);
  }
};

struct CellView {
  Corners x, y, distance;
  bool is_valid = false;  // all four nodes are seen and the cell touches the image
};

CellView ViewOfCell(const PhotoView& view, const ScoreRule& rule, int nodes_per_side, int row, int column) {
  const std::size_t k = static_cast<std::size_t>(row) * nodes_per_side + column;
  const std::array<std::size_t, 4> nodes{k, k + 1, k + nodes_per_side, k + nodes_per_side + 1};
  CellView cell;
  for (const std::size_t node : nodes) {
    if (std::isnan(view.pixel_in_image[node].x())) return cell;
  }
  const auto corners = [&](auto&& read) { return Corners{read(nodes[0]), read(nodes[1]), read(nodes[2]), read(nodes[3])}; };
  cell.x = corners([&](std::size_t n) { return view.pixel_in_image[n].x(); });
  cell.y = corners([&](std::size_t n) { return view.pixel_in_image[n].y(); });
  cell.distance = corners([&](std::size_t n) { return view.nadir_distance_m[n]; });
  cell.is_valid = cell.x.Max() >= -0.5f && cell.y.Max() >= -0.5f && cell.x.Min() <= rule.width - 0.5f &&
                  cell.y.Min() <= rule.height - 0.5f;
  return cell;
}

float WorstScore(const CellView& cell, const ScoreRule& rule) {
  const float margin = std::min(std::min(rule.Margin(cell.x.nw, cell.y.nw), rule.Margin(cell.x.ne, cell.y.ne)),
                                std::min(rule.Margin(cell.x.sw, cell.y.sw), rule.Margin(cell.x.se, cell.y.se)));
  if (margin < 0.0f) return std::numeric_limits<float>::infinity();  // part of the cell is outside
  return rule.Score(cell.distance.Max(), margin);
}

float Smooth(float t) { return t * t * (3.0f - 2.0f * t); }

}  // namespace

std::vector<PhotoShare> WeighPhotos(const alignment::AlignedFlight& flight, const std::vector<std::uint32_t>& photos,
                                    const std::vector<PhotoView>& views, const BlockGeometry& block,
                                    const WeighOptions& options) {
  const int cells = block.nodes_per_side - 1;
  const float feather_m = static_cast<float>(options.feather_m);
  std::vector<ScoreRule> rules;
  rules.reserve(photos.size());
  for (const std::uint32_t photo : photos) rules.push_back(RuleFor(flight.photos[photo]));

  // First by cells: who can matter at all. Nearly every cell has one to three such photos.
  std::vector<std::vector<std::uint16_t>> candidates(static_cast<std::size_t>(cells) * cells);
  struct Box {
    int x0 = 1 << 30, y0 = 1 << 30, x1 = -1, y1 = -1;
  };
  std::vector<Box> boxes(photos.size());
  for (int row = 0; row < cells; ++row) {
    for (int column = 0; column < cells; ++column) {
      float best_worst = std::numeric_limits<float>::infinity();
      std::vector<std::pair<std::uint16_t, float>> seeing;
      for (std::size_t i = 0; i < photos.size(); ++i) {
        if (!views[i].sees_block) continue;
        const CellView cell = ViewOfCell(views[i], rules[i], block.nodes_per_side, row, column);
        if (!cell.is_valid) continue;
        best_worst = std::min(best_worst, WorstScore(cell, rules[i]));
        seeing.emplace_back(static_cast<std::uint16_t>(i), cell.distance.Min() + rules[i].constant_m);
      }
      auto& kept = candidates[static_cast<std::size_t>(row) * cells + column];
      for (const auto& [i, least_score] : seeing) {
        if (least_score > best_worst + feather_m) continue;
        kept.push_back(i);
        Box& box = boxes[i];
        box.x0 = std::min(box.x0, column), box.y0 = std::min(box.y0, row);
        box.x1 = std::max(box.x1, column), box.y1 = std::max(box.y1, row);
      }
    }
  }

  std::vector<PhotoShare> shares;
  std::vector<int> share_of(photos.size(), -1);
  for (std::size_t i = 0; i < photos.size(); ++i) {
    if (boxes[i].x1 < 0) continue;
    PhotoShare share;
    share.photo = photos[i];
    share.x = boxes[i].x0 * kNodeStepPx;
    share.y = boxes[i].y0 * kNodeStepPx;
    share.width = (boxes[i].x1 - boxes[i].x0 + 1) * kNodeStepPx;
    share.height = (boxes[i].y1 - boxes[i].y0 + 1) * kNodeStepPx;
    share.weight.assign(static_cast<std::size_t>(share.width) * share.height, 0.0f);
    share_of[i] = static_cast<int>(shares.size());
    shares.push_back(std::move(share));
  }

  std::vector<CellView> cell_views;
  std::vector<float> scores;
  for (int row = 0; row < cells; ++row) {
    for (int column = 0; column < cells; ++column) {
      const auto& kept = candidates[static_cast<std::size_t>(row) * cells + column];
      if (kept.empty()) continue;
      cell_views.clear();
      for (const std::uint16_t i : kept) {
        cell_views.push_back(ViewOfCell(views[i], rules[i], block.nodes_per_side, row, column));
      }
      scores.resize(kept.size());
      for (int dy = 0; dy < kNodeStepPx; ++dy) {
        for (int dx = 0; dx < kNodeStepPx; ++dx) {
          float best = std::numeric_limits<float>::infinity();
          for (std::size_t c = 0; c < kept.size(); ++c) {
            const ScoreRule& rule = rules[kept[c]];
            const float margin = rule.Margin(cell_views[c].x.At(dx, dy), cell_views[c].y.At(dx, dy));
            scores[c] = margin < 0.0f ? std::numeric_limits<float>::infinity()
                                      : rule.Score(cell_views[c].distance.At(dx, dy), margin);
            best = std::min(best, scores[c]);
          }
          if (std::isinf(best)) continue;
          float sum = 0.0f;
          for (float& score : scores) {
            score = Smooth(std::clamp(1.0f - (score - best) / feather_m, 0.0f, 1.0f));
            sum += score;
          }
          for (std::size_t c = 0; c < kept.size(); ++c) {
            if (scores[c] <= 0.0f) continue;
            PhotoShare& share = shares[static_cast<std::size_t>(share_of[kept[c]])];
            const int x = column * kNodeStepPx + dx - share.x;
            const int y = row * kNodeStepPx + dy - share.y;
            share.weight[static_cast<std::size_t>(y) * share.width + x] = scores[c] / sum;
          }
        }
      }
    }
  }
  return shares;
}

}  // namespace skyquilt::render
