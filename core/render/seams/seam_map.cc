#include "core/render/seams/seam_map.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <set>

#include "core/base/median.h"
#include "core/base/parallel_for.h"
#include "core/geo/web_mercator.h"
#include "core/render/seams/label_seams.h"
#include "core/render/seams/low_res_view.h"
#include "core/render/seams/moving_objects.h"

namespace skyquilt::render {
namespace {

// Half the width of the low band's transition, cells.
constexpr int kReach = 12;
// The difference of two photos is read off a patch of this many cells around.
constexpr int kAgreementCells = 7;
// What differs by more from what its surroundings do is another thing, not another light.
constexpr float kMaxDifference = 28.0f;
// Grass and water against the sun or with it differ by this much, all alike.
constexpr float kMaxLight = 48.0f;
constexpr int kLightSurroundings = 15;  // cells
constexpr float kMaxLevels = 0.5f * kMaxLight;
// With less than this share of a patch in agreement the correction fades out.
constexpr float kMinShare = 0.08f;

cv::Mat1f Spread(const cv::Mat1f& in, int reach) {
  cv::Mat1f out;
  const int side = reach | 1;
  cv::blur(in, out, {side, side}, {-1, -1}, cv::BORDER_REPLICATE);
  cv::blur(out, out, {side, side}, {-1, -1}, cv::BORDER_REPLICATE);
  return out;
}

// Calls `visit(photo, share)`, rising, for each photo that reaches into the `needed` cells of the view: where
// it shows the map, spread out. One share at a time: a photo from high above sees the cells of hundreds.
template <typename Visit>
void ForEachNeighbour(const LowResView& view, const SeamLabels& labels, const cv::Mat1b& needed,
                      const Visit& visit) {
  cv::Mat1b reached;
  cv::dilate(needed, reached, cv::Mat::ones(2 * kReach + 1, 2 * kReach + 1, CV_8U));
  cv::Mat1i shown(view.rows, view.columns);
  std::set<std::int32_t> photos;
  for (int y = 0; y < view.rows; ++y) {
    for (int x = 0; x < view.columns; ++x) {
      shown(y, x) = labels.At(view.column + x, view.row + y);
      if (reached(y, x) != 0 && shown(y, x) != kNoPhoto) photos.insert(shown(y, x));
    }
  }
  for (const std::int32_t photo : photos) {
    cv::Mat1f share(view.rows, view.columns, 0.0f);
    share.setTo(1.0, shown == photo);
    share = Spread(share, kReach);
    double most = 0.0;
    cv::minMaxLoc(share, nullptr, &most, nullptr, nullptr, needed);
    if (most > 1e-3) visit(photo, share);
  }
}

// other - view where both see the same, smoothed; with how sure that is.
void AddDifference(const LowResView& view, const LowResView& other, const cv::Mat1f& share, cv::Mat3f& sum) {
  const auto most = [](const cv::Vec3f& step) {
    return std::max({std::abs(step[0]), std::abs(step[1]), std::abs(step[2])});
  };
  cv::Mat1f agree(view.rows, view.columns, 0.0f);
  cv::Mat3f difference(view.rows, view.columns, cv::Vec3f(0, 0, 0));
  for (int y = 0; y < view.rows; ++y) {
    for (int x = 0; x < view.columns; ++x) {
      const auto i = static_cast<std::size_t>(y) * view.columns + x;
      const int j = other.IndexOf(view.column + x, view.row + y);
      if (j < 0 || view.seen[i] == Seen::kNot || other.seen[static_cast<std::size_t>(j)] == Seen::kNot)
        continue;
      const auto& a = view.rgb[i];
      const auto& b = other.rgb[static_cast<std::size_t>(j)];
      const cv::Vec3f step = cv::Vec3i(b[0] - a[0], b[1] - a[1], b[2] - a[2]);
      if (most(step) > kMaxLight) continue;
      agree(y, x) = 1.0f;
      difference(y, x) = step;
    }
  }
  cv::Mat1f around_share;
  cv::Mat3f around;
  const cv::Size surroundings(kLightSurroundings, kLightSurroundings);
  cv::blur(agree, around_share, surroundings, {-1, -1}, cv::BORDER_CONSTANT);
  cv::blur(difference, around, surroundings, {-1, -1}, cv::BORDER_CONSTANT);
  for (int y = 0; y < view.rows; ++y) {
    for (int x = 0; x < view.columns; ++x) {
      if (agree(y, x) == 0.0f) continue;
      if (most(difference(y, x) - around(y, x) * (1.0f / around_share(y, x))) <= kMaxDifference) continue;
      agree(y, x) = 0.0f;
      difference(y, x) = cv::Vec3f(0, 0, 0);
    }
  }
  cv::blur(agree, agree, {kAgreementCells, kAgreementCells}, {-1, -1}, cv::BORDER_CONSTANT);
  cv::blur(difference, difference, {kAgreementCells, kAgreementCells}, {-1, -1}, cv::BORDER_CONSTANT);
  for (int y = 0; y < view.rows; ++y) {
    for (int x = 0; x < view.columns; ++x) {
      if (share(y, x) > 0.0f) sum(y, x) += difference(y, x) * (share(y, x) / (agree(y, x) + kMinShare));
    }
  }
}

PhotoLevels LevelsOf(std::int32_t photo, const std::vector<LowResView>& views, const SeamLabels& labels,
                     bool evens_light) {
  const LowResView& view = views[static_cast<std::size_t>(photo)];
  PhotoLevels levels{view, {}, {}};
  for (const Seen seen : view.seen) levels.sees_whole.push_back(seen == Seen::kFully);
  if (!evens_light) return levels;
  cv::Mat1b needed(view.rows, view.columns, static_cast<uchar>(0));
  bool any = false;
  for (int y = 0; y < view.rows; ++y) {
    for (int x = 0; x < view.columns; ++x) {
      if (labels.At(view.column + x, view.row + y) == photo) needed(y, x) = 1, any = true;
    }
  }
  if (!any) return levels;
  cv::dilate(needed, needed, cv::Mat(), {-1, -1}, 3);  // as far as the narrow transition mixes photos
  cv::Mat3f sum(view.rows, view.columns, cv::Vec3f(0, 0, 0));
  cv::Mat1f shares(view.rows, view.columns, 0.0f);
  int neighbours = 0;
  ForEachNeighbour(view, labels, needed, [&](std::int32_t other, const cv::Mat1f& share) {
    ++neighbours;
    shares += share;
    if (other != photo) AddDifference(view, views[static_cast<std::size_t>(other)], share, sum);
  });
  if (neighbours < 2) return levels;
  levels.eighths.assign(view.seen.size(), {});
  for (int y = 0; y < view.rows; ++y) {
    for (int x = 0; x < view.columns; ++x) {
      if (needed(y, x) == 0 || shares(y, x) < 1e-3f) continue;
      for (int c = 0; c < 3; ++c) {
        const float level = std::clamp(sum(y, x)[c] / shares(y, x), -kMaxLevels, kMaxLevels);
        levels.eighths[static_cast<std::size_t>(y) * view.columns + x][static_cast<std::size_t>(c)] =
            static_cast<std::int16_t>(std::lround(8.0f * level));
      }
    }
  }
  return levels;
}

// Without evens_light the corrections stay empty. `wanted`, by photo: the others get none; of those that
// share cells with the wanted ones the views must be there.
std::vector<PhotoLevels> LevelSeams(const std::vector<LowResView>& views, const SeamLabels& labels,
                                    bool evens_light, int threads, const std::vector<char>& wanted) {
  std::vector<PhotoLevels> levels(views.size());
  ParallelFor(views.size(), threads, [&](std::size_t i) {
    if (!wanted[i]) return;
    levels[i] = LevelsOf(static_cast<std::int32_t>(i), views, labels, evens_light);
  });
  return levels;
}

template <typename Read>
double MedianOf(const alignment::AlignedFlight& flight, Read read) {
  std::vector<double> values;
  for (const auto& photo : flight.photos) values.push_back(read(photo));
  if (values.empty()) return 1.0;
  return Median(std::move(values));
}

// An earlier run has labelled the very same cells for the very same photos.
bool IsDecided(const KnownLabels& known, const SeamGrid& grid, std::size_t photos) {
  const SeamGrid& before = known.grid;
  return known.photos == photos && before.zoom == grid.zoom && before.tile_size_px == grid.tile_size_px &&
         before.cell_px == grid.cell_px && before.first_column == grid.first_column &&
         before.first_row == grid.first_row && before.columns == grid.columns && before.rows == grid.rows;
}

// By photo: whether it may show some of the blocks, or blends into them; all without a choice of blocks.
std::vector<char> Wanted(const SeamMap& map, const MosaicPlan& plan, const std::vector<RenderBlock>* blocks,
                         std::size_t photos) {
  std::vector<char> wanted(photos, blocks == nullptr ? 1 : 0);
  if (blocks == nullptr) return wanted;
  for (const RenderBlock& block : *blocks) {
    for (const std::uint32_t photo : block.photos) wanted[photo] = 1;
    const Eigen::Vector2i corner = map.grid.CellOfBlock(block.tile, plan.block_levels);
    const int side = plan.BlockSizePx() / map.grid.cell_px;
    for (const std::uint32_t photo : map.PhotosIn(corner.x() - 1, corner.y() - 1, side + 2, side + 2))
      wanted[photo] = 1;
  }
  return wanted;
}

// By photo: whether it shows a cell that one of the wanted photos sees, and is none of those.
std::vector<char> Beside(const SeamLabels& labels, const std::vector<LowResView>& views,
                         const std::vector<char>& wanted) {
  std::vector<char> beside(views.size(), 0);
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!wanted[i]) continue;
    const LowResView& view = views[i];
    for (int y = 0; y < view.rows; ++y) {
      for (int x = 0; x < view.columns; ++x) {
        const std::int32_t label = labels.At(view.column + x, view.row + y);
        if (label != kNoPhoto && !wanted[static_cast<std::size_t>(label)])
          beside[static_cast<std::size_t>(label)] = 1;
      }
    }
  }
  return beside;
}

}  // namespace

std::vector<std::uint32_t> SeamMap::PhotosIn(int column, int row, int columns, int rows) const {
  std::vector<std::uint32_t> photos;
  std::int32_t last = kNoPhoto;
  for (int y = row; y < row + rows; ++y) {
    for (int x = column; x < column + columns; ++x) {
      const std::int32_t label = labels.At(x, y);
      if (label == kNoPhoto || label == last) continue;
      last = label;
      const auto photo = static_cast<std::uint32_t>(label);
      const auto at = std::lower_bound(photos.begin(), photos.end(), photo);
      if (at == photos.end() || *at != photo) photos.insert(at, photo);
    }
  }
  return photos;
}

SeamMap BuildSeamMap(const alignment::AlignedFlight& flight, const ground::GroundSurface& ground,
                     const MosaicPlan& plan, const ExposureModel& exposure,
                     const std::vector<Thumbnail>& thumbnails, const SeamOptions& options) {
  SeamMap map;
  const double ground_per_merc = geo::GroundMetresPerMercMetre(flight.frame.origin().lat_deg);
  map.grid = MakeSeamGrid(
      plan,
      MedianOf(flight, [](const auto& p) { return std::max(p.intrinsics.width_px, p.intrinsics.height_px); }),
      ground_per_merc);
  map.cell_m = map.grid.CellInMercM() * ground_per_merc;
  std::vector<LowResView> views(flight.photos.size());
  const auto look = [&](std::size_t i) {
    views[i] = MakeLowResView(flight.photos[i], plan.seen_in_merc[i], flight.frame, ground, exposure.tones[i],
                              thumbnails[i], map.grid, plan.gsd_m);
  };
  if (options.known != nullptr && IsDecided(*options.known, map.grid, views.size())) {
    map.labels = options.known->labels;
    const std::vector<char> wanted = Wanted(map, plan, options.only_blocks, views.size());
    ParallelFor(views.size(), options.threads, [&](std::size_t i) {
      if (wanted[i]) look(i);
    });
    const std::vector<char> beside = Beside(map.labels, views, wanted);
    ParallelFor(views.size(), options.threads, [&](std::size_t i) {
      if (beside[i]) look(i);
    });
    map.levels = LevelSeams(views, map.labels, options.evens_light, options.threads, wanted);
    return map;
  }
  ParallelFor(views.size(), options.threads, look);
  if (options.moves_seams) MarkMoving(views, map.cell_m, options.threads);
  const bool is_same_grid = options.known != nullptr && options.known->grid.zoom == map.grid.zoom &&
                            options.known->grid.tile_size_px == map.grid.tile_size_px &&
                            options.known->grid.cell_px == map.grid.cell_px;
  map.labels = LabelSeams(
      views, map.grid,
      {options.moves_seams, MedianOf(flight, [](const auto& p) { return p.height_above_ground_m; }),
       is_same_grid ? options.known : nullptr});
  map.levels =
      LevelSeams(views, map.labels, options.evens_light, options.threads, std::vector<char>(views.size(), 1));
  return map;
}

}  // namespace skyquilt::render
