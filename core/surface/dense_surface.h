// DenseSurface: a height for every cell of a regular grid of the flight's enu frame, with how sure it is and
// how many photos agree. Heights in metres of enu (z), of the cells' centres, row by row from the south-west;
// every cell that a photo shows has one, the others NaN. Values; any thread.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace skyquilt::surface {

struct SurfaceGrid {
  Eigen::Vector2d south_west_in_enu = Eigen::Vector2d::Zero();  // the centre of the first cell
  double cell_m = 1.0;
  int columns = 0;
  int rows = 0;
};

// Of the cells of a grid or of a part of it.
struct CellHeights {
  std::vector<float> heights_m;
  // From 0 to 255: how far the costs of all other heights lie above that of the one taken; 0 where filled.
  std::vector<std::uint8_t> confidence;
  // How many photos show the same at this height; 0: not measured but filled from around or from the smooth
  // ground (water, what moved, what one photo alone shows).
  std::vector<std::uint8_t> agreeing_photos;
};

struct DenseSurface {
  SurfaceGrid grid;
  CellHeights cells;
};

// A rectangle of the grid's cells.
struct CellBox {
  int column = 0, row = 0;  // of its south-west cell
  int columns = 0, rows = 0;

  std::size_t Count() const { return static_cast<std::size_t>(columns) * rows; }
};

struct SurfaceBlock {
  CellBox box;
  CellHeights cells;
};

}  // namespace skyquilt::surface
