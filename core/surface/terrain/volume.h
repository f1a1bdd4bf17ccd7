// VolumeOver: what lies above and below a base within an area of heights: what would be taken away to level
// it (cut) and what would be filled up. The base is a given height, a horizontal plane at the lowest height
// of the area's edge, the plane through the edge by least squares, or (VolumeSince) the heights of another
// flight. Metres; cells row by row, NaN where no height is known: nothing is counted there. Its standard
// deviation is of three parts that are taken as independent: steps lie half a cell off, all to the same side;
// the base is as unsure as the edge is rough about it, of which places kCorrelatedM apart tell anew; cells
// that were not measured lie as far off as the heights vary. That all heights are off by the same share (the
// calibration) is not in it. Over a given height there is none: how far off its zero the map's heights are,
// they do not tell. Pure; any thread. Absent: no height is known within the area, or none along its edge
// where the base is taken from that.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace skyquilt::surface {

enum class VolumeBase : std::uint8_t { kLowest, kPlane, kGiven };

// Of an earlier flight, on the same cells.
struct EarlierHeights {
  std::span<const float> heights_m;
  std::span<const std::uint8_t> is_measured;
  std::optional<double> sigma_m;  // of all of them together; without, that of the volume is not known either
  double own_cell_m = 0.0;        // that they were measured in, where that is larger
};

struct AreaHeights {
  int columns = 0, rows = 0;
  double cell_m = 1.0;
  std::span<const float> heights_m;
  std::span<const std::uint8_t> is_measured, is_inside;
};

// A height on the area's edge; the place counted in cells, the middle of the first at 0.5, 0.5.
struct EdgeHeight {
  Eigen::Vector2d place_in_cells = Eigen::Vector2d::Zero();
  double height_m = 0.0;
};

struct AreaVolume {
  double base_m = 0.0;  // of a plane: its mean within the area
  double cut_m3 = 0.0, fill_m3 = 0.0;
  std::optional<double> net_sigma_m3;  // of cut less fill; nothing: too little was measured, or a given base
  double area_m2 = 0.0;                // of the cells that have a height
  double measured_share = 0.0;         // of these
  double lowest_m = 0.0, highest_m = 0.0, mean_m = 0.0;
};

inline constexpr double kCorrelatedM = 5.0;
// Edges of roofs and heaps stand so far aside.
inline constexpr double kStepsOffCells = 0.5;
// Of less nobody can say how far off it is: a whole house may stand where nothing was measured.
inline constexpr double kMinMeasuredShare = 0.8;

// By how much heights rise or fall from a cell to those east and south of it; 0 to what is not known.
double RiseAt(std::span<const float> heights_m, int columns, std::size_t cell);

std::optional<AreaVolume> VolumeOver(const AreaHeights& area, const std::vector<EdgeHeight>& edge,
                                     VolumeBase base, double given_m);
// Above and below those. Cells that either does not know are not counted.
std::optional<AreaVolume> VolumeSince(const AreaHeights& area, const EarlierHeights& earlier);

}  // namespace skyquilt::surface
