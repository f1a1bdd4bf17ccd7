// What recorded positions, of photos or of a log, say of how far off a map may be, and whether the pictures
// contradict them.
//
// Of each horizontal axis: sigma^2 = common^2 + noise^2 (1/n + spread of the map / spread of the n positions)
// + lean^2 (of positions on one line: open_lean.h), where `common` is what all positions of a flight share
// (core/poses/evidence/common_error.h: assumed, since no comparison among them shows it; with what an older
// datum's place on Earth is not known to) and `noise` what the adjusted cameras miss them by, with the four
// degrees of freedom of a similarity taken off. Fewer than three positions say nothing of turn and scale, and
// among five or fewer a wrong one is hardly told from the others: fewer than half of the photos, they place
// nothing. Positions that the pictures refute place nothing either; but where many are refuted, or several by
// one shift, what the map misses all of them by counts whole, where most are missed by far more than they
// claim, the radius is no less than that, nor less than what positions jump by
// (core/poses/evidence/position_jump.h). All of these limit the map, as does a jump of corrected heights
// alone, which leaves the radius as it is. Frame `enu` of the flight, metres. Pure.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/flight/photo.h"
#include "core/pipeline/report/map_quality.h"
#include "core/pipeline/report/open_lean.h"

namespace skyquilt::pipeline {

struct JudgedMap;  // judge_map.h

inline constexpr double kCircleSigmas = 1.515;  // sqrt(-2 ln(1 - 0.683)): the stated radius of an axis' sigma
inline constexpr int kFreedomOfMove = 4;        // shift, turn and scale
inline constexpr std::size_t kFewestPositions = 3;  // for turn and scale, and a miss that shows

bool IsAnyAligned(const JudgedMap& map);

// Of a receiver with corrections: barometers drift.
struct SupportingHeight {
  const flight::Photo* photo = nullptr;
  Eigen::Vector3d camera_in_enu = Eigen::Vector3d::Zero();  // as the map has it
  double miss_m = 0.0;                                      // recorded minus that
};

struct SupportingPositions {
  std::vector<Eigen::Vector2d> places;  // of the cameras, as the map has them
  std::vector<Eigen::Vector2d> misses;  // recorded minus that
  std::vector<const flight::Photo*> photos;
  std::vector<const flight::RecordedPosition*> records;
  std::vector<Eigen::Vector2d> refuted;  // as `misses`, of those that place nothing
  std::vector<SupportingHeight> heights;
};

// Of photos that count; a position that the pictures refute places nothing.
SupportingPositions PositionsOf(const JudgedMap& map);

// 1/n + how much more than the places' own the map spreads about their middle.
double LeverOf(const JudgedMap& map, const std::vector<Eigen::Vector2d>& places);

// Between two photos in the order of their times.
struct JumpOfPositions {
  std::string before, after;  // their names
  double by_m = 0.0;
};

// Of the positions of photos or of a log.
struct PositionsError {
  double common_m = 0.0;  // with what their scatter and a jump leave
  double shape_m = 0.0;   // what these leave alone: of the map's turn, scale and bends
  bool is_corrected = false;
  OpenLean lean;  // beside it; photos that lie by their records count their angles already
  std::optional<JumpOfPositions> jump, height_jump;
};

PositionsError ErrorOfPositions(const JudgedMap& map, const SupportingPositions& positions);

AbsoluteAccuracy StatedRadius(double sigma_of_axis_m, AbsoluteSupport by, std::size_t count);

// What is stated of a map that positions place; without a number where they are too few, or none.
AbsoluteAccuracy ByPositions(const JudgedMap& map);

bool IsByReceiver(const AbsoluteAccuracy& absolute);

// The photos contradict what claims to say how far off the map is.
bool AreContradicted(const JudgedMap& map, const AbsoluteAccuracy& absolute);

}  // namespace skyquilt::pipeline
