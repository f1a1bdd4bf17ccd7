#include "core/simulate/world/parcels.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/simulate/world/random.h"

namespace skyquilt::simulate {
namespace {

constexpr double kColumnM = 66.0;
constexpr double kRowM = 46.0;
constexpr std::uint32_t kColumnSalt = 0x51ed270bu;
constexpr std::uint32_t kRowSalt = 0x2545f491u;
constexpr std::uint32_t kKindSalt = 0x94d049bbu;
constexpr std::uint32_t kBuildingSalt = 0xbf58476du;
constexpr double kBuildingClearanceM = 0.3;

}  // namespace

Parcels::Parcels(std::uint32_t seed, TextureLevel texture) : seed_(seed), texture_(texture) {
  const double turn =
      0.35 + 0.5 * Uniform(HashCell(0, 0, seed), 0);  // never along the axes: no lucky symmetry
  cos_ = std::cos(turn);
  sin_ = std::sin(turn);
}

double Parcels::ColumnBorder(std::int32_t column) const {
  return kColumnM * (column + 0.44 * (Uniform(HashCell(column, 0, seed_ ^ kColumnSalt), 0) - 0.5));
}

double Parcels::RowBorder(std::int32_t column, std::int32_t row) const {
  return kRowM * (row + 0.5 * (Uniform(HashCell(column, row, seed_ ^ kRowSalt), 0) - 0.5) +
                  0.5 * Uniform(HashCell(column, 0, seed_ ^ kRowSalt), 1));
}

ParcelKind Parcels::KindOf(std::uint32_t hash) const {
  if (texture_ == TextureLevel::kRows) return ParcelKind::kCrop;
  if (texture_ == TextureLevel::kBare) return ParcelKind::kSand;
  const float draw = Uniform(hash, 0);
  if (draw < 0.34f) return ParcelKind::kCrop;
  if (draw < 0.54f) return ParcelKind::kMeadow;
  if (draw < 0.66f) return ParcelKind::kPloughed;
  if (draw < 0.73f) return ParcelKind::kSand;
  if (draw < 0.78f) return ParcelKind::kPond;
  return ParcelKind::kFarmyard;
}

Parcel Parcels::At(double east, double north) const {
  Parcel parcel;
  const Eigen::Vector2d turned = ToTurned(east, north);
  parcel.u = turned.x();
  parcel.v = turned.y();
  auto column = FloorToInt(parcel.u / kColumnM);
  double left = ColumnBorder(column);
  double right = ColumnBorder(column + 1);
  if (parcel.u < left) {
    right = left;
    left = ColumnBorder(--column);
  } else if (parcel.u >= right) {
    left = right;
    right = ColumnBorder(++column + 1);
  }
  const bool nearer_left = parcel.u - left < right - parcel.u;
  parcel.to_column_border_m = nearer_left ? parcel.u - left : right - parcel.u;
  parcel.column_border_is_road = ((nearer_left ? column : column + 1) & 1) == 0;

  auto row = FloorToInt(parcel.v / kRowM);
  double low = RowBorder(column, row);
  while (parcel.v < low) low = RowBorder(column, --row);
  double high = RowBorder(column, row + 1);
  while (parcel.v >= high) {
    low = high;
    high = RowBorder(column, ++row + 1);
  }
  parcel.to_row_border_m = std::min(parcel.v - low, high - parcel.v);
  parcel.center_u = 0.5 * (left + right);
  parcel.center_v = 0.5 * (low + high);
  parcel.half_u = 0.5 * (right - left);
  parcel.half_v = 0.5 * (high - low);
  parcel.hash = HashCell(column, row, seed_ ^ kKindSalt);
  parcel.kind = KindOf(parcel.hash);
  return parcel;
}

std::optional<Building> Parcels::MakeBuilding(std::int32_t cell_u, std::int32_t cell_v) const {
  const std::uint32_t hash = HashCell(cell_u, cell_v, seed_ ^ kBuildingSalt);
  if (Uniform(hash, 0) > 0.85f) return std::nullopt;
  Building building;
  building.hash = hash;
  building.half_size_m = {4.0 + 3.5 * Uniform(hash, 1), 3.0 + 2.0 * Uniform(hash, 2)};
  building.height_m = 3.0 + (kTallestBuildingM - 3.0) * Uniform(hash, 3);
  const double reach = building.half_size_m.norm();
  const double play = 0.5 * kBuildingCellM - reach - 0.5;
  const double u = (cell_u + 0.5) * kBuildingCellM + play * (2.0 * Uniform(hash, 4) - 1.0);
  const double v = (cell_v + 0.5) * kBuildingCellM + play * (2.0 * Uniform(hash, 5) - 1.0);
  building.center_in_enu = {cos_ * u - sin_ * v, sin_ * u + cos_ * v};
  const Parcel parcel = At(building.center_in_enu.x(), building.center_in_enu.y());
  if (parcel.kind != ParcelKind::kFarmyard) return std::nullopt;
  const double clearance = std::min(parcel.to_column_border_m - 3.0, parcel.to_row_border_m - 0.9);
  if (clearance < reach + kBuildingClearanceM) return std::nullopt;
  const double turn = std::atan2(sin_, cos_) + 1.2 * (Uniform(hash, 6) - 0.5) + (hash & 1u ? 1.5707963 : 0.0);
  building.axis_in_enu = {std::cos(turn), std::sin(turn)};
  return building;
}

std::optional<Building> Parcels::BuildingOfCell(std::int32_t cell_u, std::int32_t cell_v) const {
  struct Remembered {
    std::uint32_t seed = 0;
    std::int32_t cell_u = 0, cell_v = 0;
    bool is_set = false;
    std::optional<Building> building;
  };
  if (texture_ != TextureLevel::kRich) return std::nullopt;  // only this landscape has any
  thread_local std::array<Remembered, 256> memory;
  Remembered& slot =
      memory[(static_cast<std::uint32_t>(cell_u) & 15u) * 16u + (static_cast<std::uint32_t>(cell_v) & 15u)];
  if (!slot.is_set || slot.seed != seed_ || slot.cell_u != cell_u || slot.cell_v != cell_v) {
    slot = {seed_, cell_u, cell_v, true, MakeBuilding(cell_u, cell_v)};
  }
  return slot.building;
}

}  // namespace skyquilt::simulate
