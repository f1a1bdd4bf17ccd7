// TileMatcher: what the photos say of the heights of one tile of cells: the cost of every height of its
// sheets, and how many photos agree on a height that was picked. Holds the memory that tiles share; one
// thread at a time. Frames: enu, cells of a level. Photos that cannot be decoded count as not there.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "core/surface/paths/height_sheets.h"
#include "core/surface/paths/semi_global.h"
#include "core/surface/views/census.h"
#include "core/surface/views/gray_photos.h"
#include "core/surface/views/surface_camera.h"
#include "core/surface/views/view_patch.h"

namespace skyquilt::surface {

// The photos that show a block, decoded when first wanted and held until it is done.
class BlockPhotos {
 public:
  BlockPhotos(const alignment::AlignedFlight& flight, const std::vector<SurfaceCamera>& cameras,
              GrayPhotos& photos, double finest_cell_m)
      : flight_(flight), cameras_(cameras), photos_(photos), finest_cell_m_(finest_cell_m) {}

  const SurfaceCamera& Camera(std::size_t camera) const { return cameras_[camera]; }
  const std::vector<SurfaceCamera>& Cameras() const { return cameras_; }
  // Nothing where it cannot be decoded.
  const GrayPyramid* Pyramid(std::size_t camera);

 private:
  const alignment::AlignedFlight& flight_;
  const std::vector<SurfaceCamera>& cameras_;
  GrayPhotos& photos_;
  double finest_cell_m_;
  std::map<std::size_t, std::shared_ptr<const GrayPyramid>> held_;
};

// A level's cells of one block.
struct LevelFrame {
  Eigen::Vector2d first_in_enu;  // the centre of the first cell
  double cell_m = 1.0;
  int columns = 0, rows = 0;

  std::size_t IndexOf(int column, int row) const { return static_cast<std::size_t>(row) * columns + column; }
};

// A rectangle of a level's cells and the photos that are compared over it.
struct MatchedTile {
  int column = 0, row = 0, columns = 0, rows = 0;
  std::vector<std::size_t> cameras;
};

// The least part of a tile that has all cells of the level that are wanted; no columns where none is.
template <typename IsWanted>
MatchedTile PartWith(const MatchedTile& tile, const IsWanted& is_wanted) {
  int left = tile.column + tile.columns, right = -1, low = tile.row + tile.rows, high = -1;
  for (int row = tile.row; row < tile.row + tile.rows; ++row) {
    for (int column = tile.column; column < tile.column + tile.columns; ++column) {
      if (!is_wanted(column, row)) continue;
      left = std::min(left, column);
      right = std::max(right, column);
      low = std::min(low, row);
      high = row;
    }
  }
  if (right < 0) return {};
  return {left, low, right - left + 1, high - low + 1, tile.cameras};
}

class TileMatcher {
 public:
  TileMatcher(BlockPhotos& photos, const LevelFrame& frame) : photos_(photos), frame_(frame) {}

  // Writes the tile's part of the costs, and of the gray that the first photo shows at the expected
  // height. Costs are all the same where fewer than two photos see the tile.
  void FillCosts(const MatchedTile& tile, const HeightSheets& sheets, SheetCosts& costs,
                 std::vector<std::uint8_t>& gray);
  // Writes the tile's part of how many photos agree at the heights, and of what they show there.
  void FillAgreeing(const MatchedTile& tile, const std::vector<float>& heights_m,
                    std::vector<std::uint8_t>& agreeing, std::vector<std::uint8_t>& gray);
  // Writes 1 where any of the block's photos sees the cell at its height, by squares of cells.
  void FillSeen(const MatchedTile& tile, const std::vector<std::size_t>& cameras,
                const std::vector<float>& heights_m, std::vector<std::uint8_t>& seen) const;
  // Writes the tile's part of by how much more it would cost if the cell alone lay at its other height and
  // those around it stayed.
  void CompareOthers(const MatchedTile& tile, const std::vector<float>& heights_m,
                     const std::vector<float>& others_m, std::vector<std::int16_t>& worse);

 private:
  // Lays the tile's photos at the heights, with `raised_m` added to each; false: fewer than two see it.
  bool Lay(const MatchedTile& tile, const std::vector<float>& low_m, double raised_m, double span_m,
           int heights);
  void SampleAll(int height);
  // Costs of kSheetHeights heights, one plane a height.
  void FillPlanes(const MatchedTile& tile, const std::vector<float>& low_m, double raised_m, double step_m,
                  int shown_height, std::vector<std::uint8_t>* gray);
  void TakeGray(const MatchedTile& tile, std::vector<std::uint8_t>& gray) const;

  BlockPhotos& photos_;
  const LevelFrame frame_;
  TileFrame laid_;
  CensusShape shape_;
  std::size_t plane_size_ = 0;  // of shape_
  std::vector<float> low_m_;
  std::vector<ViewPatch> patches_;
  std::size_t used_ = 0;  // of patches_
  std::vector<std::vector<std::uint8_t>> shown_, around_, census_;
  std::vector<CensusView> views_;
  std::vector<std::uint8_t> planes_, counted_;
};

}  // namespace skyquilt::surface
