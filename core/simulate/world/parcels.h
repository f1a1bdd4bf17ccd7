// Parcels: how the simulated land is cut into fields, roads, ponds and farmyards. A pure function of the
// seed; unbounded; any thread. Frame enu (E, N), metres.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

namespace skyquilt::simulate {

enum class TextureLevel {
  kRich,  // fields, roads, roofs, ponds; texture at every scale, some places poor on purpose
  kRows,  // crop rows everywhere: repetitive, little else to match
  kBare,  // pale sand almost without texture
};

enum class ParcelKind { kCrop, kMeadow, kPloughed, kSand, kPond, kFarmyard };

struct Parcel {
  ParcelKind kind = ParcelKind::kMeadow;
  std::uint32_t hash = 0;           // differs from parcel to parcel
  double u = 0.0, v = 0.0;          // the point in the parcels' own turned axes
  double to_column_border_m = 0.0;  // distance to the nearer border with another column: a road or a track
  bool column_border_is_road = false;
  double to_row_border_m = 0.0;  // distance to the nearer border inside the column: a grass strip
  double center_u = 0.0, center_v = 0.0, half_u = 0.0, half_v = 0.0;
};

// A building: a box with a flat roof, standing in a farmyard.
struct Building {
  Eigen::Vector2d center_in_enu = Eigen::Vector2d::Zero();
  Eigen::Vector2d axis_in_enu = Eigen::Vector2d::UnitX();  // unit vector along the length
  Eigen::Vector2d half_size_m = Eigen::Vector2d::Zero();
  double height_m = 0.0;
  std::uint32_t hash = 0;

  // The point in the building's own axes, from its centre.
  Eigen::Vector2d ToAxes(const Eigen::Vector2d& east_north) const {
    const Eigen::Vector2d d = east_north - center_in_enu;
    return {d.dot(axis_in_enu), d.y() * axis_in_enu.x() - d.x() * axis_in_enu.y()};
  }
};

inline constexpr double kBuildingCellM = 26.0;
inline constexpr double kTallestBuildingM = 7.5;

class Parcels {
 public:
  Parcels(std::uint32_t seed, TextureLevel texture);

  Parcel At(double east, double north) const;
  // The building of one cell of the building grid (kBuildingCellM, in the turned axes); most have none. Each
  // thread remembers the last ones: neighbouring rays ask for the same.
  std::optional<Building> BuildingOfCell(std::int32_t cell_u, std::int32_t cell_v) const;
  // The turned axes of a point: the grid of buildings and of trees lies along them.
  Eigen::Vector2d ToTurned(double east, double north) const {
    return {cos_ * east + sin_ * north, cos_ * north - sin_ * east};
  }

 private:
  double ColumnBorder(std::int32_t column) const;
  double RowBorder(std::int32_t column, std::int32_t row) const;
  std::optional<Building> MakeBuilding(std::int32_t cell_u, std::int32_t cell_v) const;
  ParcelKind KindOf(std::uint32_t hash) const;

  std::uint32_t seed_;
  TextureLevel texture_;
  double cos_, sin_;
};

}  // namespace skyquilt::simulate
