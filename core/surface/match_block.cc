#include "core/surface/match_block.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "core/surface/paths/height_sheets.h"
#include "core/surface/paths/pick_heights.h"
#include "core/surface/refine/alike_heights.h"
#include "core/surface/refine/edge_heights.h"
#include "core/surface/refine/refine_heights.h"
#include "core/surface/views/match_tile.h"

namespace skyquilt::surface {
namespace {

// Cells of the finest level around a block that its heights depend on, by level from the finest: as far as
// paths of the semi-global matching carry something.
constexpr std::array<int, kSurfaceLevels> kAroundBlock = {24, 40, 64, 112};
constexpr int kTileCells = 64;
constexpr int kMaxCoarseHeights = 256;
// Bounds of the longest base over the height from which steps are reckoned.
constexpr double kMinBase = 0.12, kMaxBase = 0.7, kUsualBase = 0.3;
// A height is known where the sum of the next best one over eight paths lies above its own by this.
constexpr int kMinMargin = 12;
constexpr int kFullMargin = 240;  // and surely so by this
// And where the cost of the height lies below the mean of its heights by this, about the cell.
constexpr int kMinContrast = 6;
constexpr int kFullContrast = 24;
// And where what lies around it was measured alike. Of cells over crowns in the wind one in twenty has two
// thirds of those around it alike, of cells of a road nineteen.
constexpr float kAlikeSteps = 2.5f;
constexpr std::uint8_t kManyAlike = 33, kSomeAlike = 17, kNearlyAllAlike = 44;
constexpr float kSpeckleSteps = 2.0f;
constexpr std::size_t kMinCells = 48, kMinWeight = 400, kThirdPhoto = 10;
// A patch too small for that is looked at again in smaller cells where so many photos agree on it, and counts
// there where so many do: a narrow house is a few of the largest cells. Two photos agree by chance.
constexpr std::uint8_t kMinDoubtedPhotos = 3;
constexpr int kFillReach = 24;
constexpr float kFillSteps = 4.0f;
constexpr float kEdgeSteps = 4.0f;
constexpr int kEdgeRounds = 2;

int FloorShift(int value, int level) { return value >> level; }
int CeilShift(int value, int level) { return -((-value) >> level); }

// The cells of a level around a block, counted from the grid's corner.
CellBox LevelBox(const CellBox& block, int level) {
  const int around = kAroundBlock[static_cast<std::size_t>(level)];
  const int left = FloorShift(block.column - around, level), low = FloorShift(block.row - around, level);
  return {left, low, CeilShift(block.column + block.columns + around, level) - left,
          CeilShift(block.row + block.rows + around, level) - low};
}

LevelFrame FrameOf(const SurfaceGrid& grid, const CellBox& box, int level) {
  const double cells = 1 << level;
  const Eigen::Vector2d first =
      cells * Eigen::Vector2d(box.column, box.row) + 0.5 * (cells - 1.0) * Eigen::Vector2d::Ones();
  return {grid.south_west_in_enu + grid.cell_m * first, cells * grid.cell_m, box.columns, box.rows};
}

geo::Bounds2 BoundsOfCells(const LevelFrame& frame, const MatchedTile& tile) {
  geo::Bounds2 bounds;
  bounds.Include(Eigen::Vector2d(frame.first_in_enu + frame.cell_m * Eigen::Vector2d(tile.column, tile.row)));
  bounds.Include(
      Eigen::Vector2d(frame.first_in_enu + frame.cell_m * Eigen::Vector2d(tile.column + tile.columns - 1,
                                                                          tile.row + tile.rows - 1)));
  return bounds;
}

// By row: from the first to the last tile that two photos see.
std::vector<ColumnSpan> ComparedSpans(const std::vector<MatchedTile>& tiles, int rows) {
  std::vector<ColumnSpan> spans(static_cast<std::size_t>(rows));
  for (const MatchedTile& tile : tiles) {
    if (tile.cameras.size() < 2) continue;
    for (int row = tile.row; row < tile.row + tile.rows; ++row) {
      ColumnSpan& span = spans[static_cast<std::size_t>(row)];
      if (span.end == 0) span.first = tile.column;
      span.end = tile.column + tile.columns;
    }
  }
  return spans;
}

// A level's heights with what bears them out.
struct MatchedLevel {
  CellBox box;  // of the level's cells
  LevelHeights heights;
  std::vector<std::uint8_t> agreeing, confidence;
  // What may stand there: as heights, but where patches too small to be borne out lie higher.
  std::vector<float> highest_m;
};

class BlockMatcher {
 public:
  BlockMatcher(const MatchContext& context, const CellBox& box, BlockMemory& memory)
      : context_(context),
        box_(box),
        memory_(memory),
        photos_(context.flight, context.cameras, context.photos, context.grid.cell_m) {
    const CellBox widest = LevelBox(box, kSurfaceLevels - 1);
    const LevelFrame frame = FrameOf(context.grid, widest, kSurfaceLevels - 1);
    const geo::Bounds2 bounds = BoundsOfCells(frame, {0, 0, widest.columns, widest.rows, {}});
    for (std::size_t i = 0; i < context.cameras.size(); ++i) {
      if (context.cameras[i].seen_in_enu.Intersects(bounds)) near_.push_back(i);
    }
    const LevelFrame finest = FrameOf(context.grid, box, 0);
    const MatchedTile all{0, 0, box.columns, box.rows, {}};
    const geo::Bounds2 inner = BoundsOfCells(finest, all);
    const double ground_m = context.ground.HeightAt(0.5 * (inner.min + inner.max));
    const ChosenViews views =
        ChooseViews(context.cameras, near_, {inner, ground_m, ground_m}, context.options.most_views);
    const double base =
        views.cameras.size() < 2 ? kUsualBase : std::clamp(views.widest_base, kMinBase, kMaxBase);
    step_m_ = context.options.shift_of_step * context.grid.cell_m / base;
  }

  SurfaceBlock Match() {
    CellBox box = LevelBox(box_, kSurfaceLevels - 1);
    LevelFrame frame = FrameOf(context_.grid, box, kSurfaceLevels - 1);
    MatchedLevel matched = MatchLevel(box, frame, WholeRange(frame), nullptr, false);
    for (int level = kSurfaceLevels - 2; level >= 0; --level) {
      box = LevelBox(box_, level);
      frame = FrameOf(context_.grid, box, level);
      HeightSheets sheets = SheetsFollowing(matched.heights.heights_m, matched.highest_m, matched.box, box,
                                            step_m_ * (1 << level));
      const MatchedLevel coarser = std::move(matched);
      matched = MatchLevel(box, frame, std::move(sheets), &coarser, level == 0);
    }
    return Cut(frame, matched);
  }

 private:
  HeightSheets WholeRange(const LevelFrame& frame) {
    std::vector<float> ground_m;
    ground_m.reserve(static_cast<std::size_t>(frame.columns) * frame.rows);
    for (int row = 0; row < frame.rows; ++row) {
      for (int column = 0; column < frame.columns; ++column) {
        ground_m.push_back(static_cast<float>(
            context_.ground.HeightAt(frame.first_in_enu + frame.cell_m * Eigen::Vector2d(column, row))));
      }
    }
    const double range_m = context_.below_m + context_.above_m;
    const double step_m = std::max(step_m_ * (1 << (kSurfaceLevels - 1)), range_m / (kMaxCoarseHeights - 1));
    const int heights = static_cast<int>(range_m / step_m) + 2;
    return SheetsAbout(frame.columns, frame.rows, std::move(ground_m), context_.below_m, step_m,
                       (heights + kSheetHeights - 1) / kSheetHeights * kSheetHeights);
  }

  // The level cut into tiles of about kTileCells, each with its photos.
  std::vector<MatchedTile> Tiles(const LevelFrame& frame, const HeightSheets& sheets) const {
    const int across = (frame.columns + kTileCells - 1) / kTileCells,
              up = (frame.rows + kTileCells - 1) / kTileCells;
    std::vector<MatchedTile> tiles;
    for (int row = 0; row < up; ++row) {
      for (int column = 0; column < across; ++column) {
        MatchedTile tile;
        tile.column = frame.columns * column / across;
        tile.row = frame.rows * row / up;
        tile.columns = frame.columns * (column + 1) / across - tile.column;
        tile.rows = frame.rows * (row + 1) / up - tile.row;
        SeenBox seen{BoundsOfCells(frame, tile), 1e30, -1e30};
        for (int y = tile.row; y < tile.row + tile.rows; ++y) {
          const float* expected = sheets.expected_m.data() + frame.IndexOf(tile.column, y);
          const auto [low, high] = std::minmax_element(expected, expected + tile.columns);
          seen.low_z_m = std::min(seen.low_z_m, static_cast<double>(*low));
          seen.high_z_m = std::max(seen.high_z_m, static_cast<double>(*high));
        }
        tile.cameras = ChooseViews(context_.cameras, near_, seen, context_.options.most_views).cameras;
        tiles.push_back(std::move(tile));
      }
    }
    return tiles;
  }

  MatchedLevel MatchLevel(const CellBox& box, const LevelFrame& frame, HeightSheets sheets,
                          const MatchedLevel* coarser, bool is_finest) {
    const std::size_t cells = sheets.Cells();
    MatchedLevel matched{
        box, {frame.columns, frame.rows, {}, std::vector<std::uint8_t>(cells, 0)}, {}, {}, {}};
    LevelHeights& level = matched.heights;
    matched.agreeing.assign(cells, 0);
    matched.confidence.assign(cells, 0);
    const std::vector<MatchedTile> tiles = Tiles(frame, sheets);
    sheets.compared = ComparedSpans(tiles, frame.rows);
    if (std::all_of(sheets.compared.begin(), sheets.compared.end(),
                    [](const ColumnSpan& span) { return span.first >= span.end; })) {
      level.heights_m = matched.highest_m = std::move(sheets.expected_m);
      return matched;
    }
    TileMatcher matcher(photos_, frame);
    auto& [costs, sums, gray] = memory_;
    costs.first.resize(cells * static_cast<std::size_t>(sheets.heights));
    costs.second.resize(static_cast<std::size_t>(sheets.second_count) * kSheetHeights);
    gray.assign(cells, 0);
    for (const MatchedTile& tile : tiles) {
      const ColumnSpan span = sheets.compared[static_cast<std::size_t>(tile.row)];
      if (tile.column >= span.first && tile.column < span.end) matcher.FillCosts(tile, sheets, costs, gray);
    }
    SumAlongPaths(sheets, costs, gray, {}, sums);
    PickedHeights picked = PickHeights(sheets, costs, sums);
    level.heights_m = std::move(picked.heights_m);
    for (const MatchedTile& tile : tiles) matcher.FillAgreeing(tile, level.heights_m, matched.agreeing, gray);
    const std::vector<std::uint8_t> contrasts = MeansAround(picked.contrasts, frame.columns, frame.rows);
    for (std::size_t i = 0; i < cells; ++i) {
      const bool is_doubted =
          !sheets.doubted_above_m.empty() && level.heights_m[i] > sheets.doubted_above_m[i];
      level.is_known[i] = matched.agreeing[i] >= (is_doubted ? kMinDoubtedPhotos : 2) &&
                          picked.margins[i] >= kMinMargin && contrasts[i] >= kMinContrast;
      matched.confidence[i] = static_cast<std::uint8_t>(
          std::min({255, picked.margins[i] * 255 / kFullMargin, contrasts[i] * 255 / kFullContrast}));
    }
    const std::vector<std::uint8_t> alike = CountAlike(level, kAlikeSteps * sheets.step_m);
    const std::vector<float> doubted_m = is_finest ? std::vector<float>{} : level.heights_m;
    const std::vector<std::uint8_t> is_picked = level.is_known;
    DropSpeckles(level, alike, matched.agreeing,
                 {kSpeckleSteps * sheets.step_m, kManyAlike, kSomeAlike, kMinCells, kMinWeight, kThirdPhoto,
                  kNearlyAllAlike});
    if (coarser != nullptr) TakeCoarser(*coarser, contrasts, alike, sheets, matched);
    FillUnknown(level, sheets.expected_m, kFillReach, kFillSteps * sheets.step_m);
    TakeMedians(level);
    if (is_finest) {
      MoveSteps(tiles, kEdgeSteps * sheets.step_m, matcher, level);
      return matched;
    }
    matched.highest_m = level.heights_m;
    for (std::size_t i = 0; i < cells; ++i) {
      const bool may_stand = level.is_known[i] == 0 && is_picked[i] != 0 &&
                             matched.agreeing[i] >= kMinDoubtedPhotos && alike[i] >= kSomeAlike;
      if (may_stand) matched.highest_m[i] = std::max(matched.highest_m[i], doubted_m[i]);
    }
    return matched;
  }

  // What larger cells told, where these tell too little; not where they tell nothing (what larger ones knew
  // is what lies around) or each another thing.
  static void TakeCoarser(const MatchedLevel& coarser, const std::vector<std::uint8_t>& contrasts,
                          const std::vector<std::uint8_t>& alike, const HeightSheets& sheets,
                          MatchedLevel& matched) {
    std::size_t i = 0;
    for (int row = 0; row < matched.heights.rows; ++row) {
      const int from_row = FloorShift(matched.box.row + row, 1) - coarser.box.row;
      for (int column = 0; column < matched.heights.columns; ++column, ++i) {
        const int from_column = FloorShift(matched.box.column + column, 1) - coarser.box.column;
        const std::size_t from = coarser.heights.IndexOf(from_column, from_row);
        if (matched.heights.is_known[i] != 0 || coarser.heights.is_known[from] == 0) continue;
        if (contrasts[i] < kMinContrast || alike[i] < kSomeAlike) continue;
        matched.heights.is_known[i] = 1;
        matched.heights.heights_m[i] = sheets.expected_m[i];
        matched.agreeing[i] = coarser.agreeing[from];
        matched.confidence[i] = static_cast<std::uint8_t>(coarser.confidence[from] / 2);
      }
    }
  }

  void MoveSteps(const std::vector<MatchedTile>& tiles, float step_m, TileMatcher& matcher,
                 LevelHeights& level) {
    for (int round = 0; round < kEdgeRounds; ++round) {
      const OtherSides sides = FindOtherSides(level, memory_.gray, step_m);
      std::vector<std::int16_t> worse(level.heights_m.size(), 0);
      const float *own = level.heights_m.data(), *other = sides.heights_m.data();
      for (const MatchedTile& tile : tiles) {
        const MatchedTile part = PartWith(tile, [&](int column, int row) {
          const std::size_t cell = level.IndexOf(column, row);
          return own[cell] != other[cell];
        });
        if (part.columns > 0) matcher.CompareOthers(part, level.heights_m, sides.heights_m, worse);
      }
      TakeBetterSides(sides, worse, level);
      TakeMedians(level);
    }
  }

  // The block without what lies around it.
  SurfaceBlock Cut(const LevelFrame& frame, const MatchedLevel& matched) {
    const LevelHeights& level = matched.heights;
    std::vector<std::uint8_t> seen(level.heights_m.size(), 0);
    TileMatcher(photos_, frame).FillSeen({0, 0, frame.columns, frame.rows, {}}, near_, level.heights_m, seen);
    SurfaceBlock block{box_, {}};
    block.cells.heights_m.reserve(box_.Count());
    for (int row = 0; row < box_.rows; ++row) {
      for (int column = 0; column < box_.columns; ++column) {
        const std::size_t at =
            level.IndexOf(box_.column + column - matched.box.column, box_.row + row - matched.box.row);
        const bool is_seen = seen[at] != 0, is_known = is_seen && level.is_known[at] != 0;
        block.cells.heights_m.push_back(is_seen ? level.heights_m[at]
                                                : std::numeric_limits<float>::quiet_NaN());
        block.cells.confidence.push_back(is_known ? std::max<std::uint8_t>(1, matched.confidence[at]) : 0);
        block.cells.agreeing_photos.push_back(is_known ? matched.agreeing[at] : 0);
      }
    }
    return block;
  }

  const MatchContext& context_;
  const CellBox box_;
  BlockMemory& memory_;
  BlockPhotos photos_;
  std::vector<std::size_t> near_;  // cameras that may see the block and what lies around it
  double step_m_ = 1.0;            // of the finest level
};

}  // namespace

SurfaceBlock MatchBlock(const MatchContext& context, const CellBox& box, BlockMemory& memory) {
  return BlockMatcher(context, box, memory).Match();
}

}  // namespace skyquilt::surface
