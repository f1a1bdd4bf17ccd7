// ShiftBetween: how far the heights of one flight lie off those of another of the same ground, sideways and
// up, so that what is left between them is what has changed. Flights whose positions come from satellites
// alone lie metres apart; most of the ground is taken to have stayed as it was (alike_share says how much).
// Sideways it is tried cell by cell up to kMaxSidewaysM, and believed only where the heights agree clearly
// better there than anywhere else: level ground cannot tell. Up it is the median of what differs little from
// it. Two grids of the same cells, rows from the north, NaN where nothing is known or was measured; metres.
// Pure; any thread.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <variant>

namespace skyquilt::surface {

struct HeightGrid {
  int columns = 0, rows = 0;
  double cell_m = 1.0;
  std::span<const float> heights_m;
};

// What `then` shows at a place p, `now` shows at p + east_north_m, up_m higher.
struct HeightShift {
  std::optional<Eigen::Vector2d> east_north_m;  // absent: the ground does not tell
  double up_m = 0.0;
  // By how much patches of ground that stayed as it was still differ, one standard deviation: what a level
  // anywhere is unsure by. Absent of a shift that was not found but said.
  std::optional<double> sigma_m;
  double alike_share = 1.0;  // of what both measured: differs by less than kChangedM
};

enum class ShiftFault : std::uint8_t {
  kTooLittle,  // is measured in both
  kTooFar,     // apart sideways
};

inline constexpr double kMaxSidewaysM = 6.0;
// A difference beyond this is one that changed, however large it is.
inline constexpr double kChangedM = 0.5;
inline constexpr int kMinComparedCells = 400;

std::variant<HeightShift, ShiftFault> ShiftBetween(const HeightGrid& now, const HeightGrid& then);

}  // namespace skyquilt::surface
