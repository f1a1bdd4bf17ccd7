#include "core/pipeline/placing/place_by_lists.h"

#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <utility>

#include "core/flight/remarks/because.h"
#include "core/pipeline/placing/control_points.h"
#include "core/pipeline/placing/move_flight.h"
#include "core/pipeline/placing/move_to_control.h"
#include "core/pipeline/placing/place_known.h"

namespace skyquilt::pipeline {
namespace {

// What an earlier survey had the map say.
bool IsOfControl(const flight::Remark& said) {
  using flight::RemarkCode;
  constexpr std::array kCodes = {RemarkCode::kControlNotUsed,        RemarkCode::kControlFarOff,
                                 RemarkCode::kControlFarOffAndNoted, RemarkCode::kControlNoted,
                                 RemarkCode::kPlacedByControl,       RemarkCode::kMovedToControl};
  return std::find(kCodes.begin(), kCodes.end(), said.code) != kCodes.end();
}

// Where the finished map has points that did not place it, against where they were surveyed; east and north
// alone, since survey and flight seldom share their zero of heights.
std::vector<alignment::ControlReport> CompareWithSurvey(const FlightFacts& facts,
                                                        const std::vector<alignment::ControlPoint>& checks) {
  std::vector<alignment::ControlReport> reports;
  const double gsd_m = MedianGsdM(facts);
  for (const MarkedPoint& marked : MarkedPointsOf(facts, checks, reports)) {
    const Eigen::Vector3d miss =
        marked.seen_in_enu - facts.flight.frame.EnuAtHeight(marked.point.position, marked.seen_in_enu.z());
    alignment::ControlReport& told = reports[marked.report];
    told.is_used = true;
    told.miss_east_m = miss.x();
    told.miss_north_m = miss.y();
    told.residual_px = gsd_m > 0.0 ? miss.head<2>().norm() / gsd_m : 0.0;
  }
  for (alignment::ControlReport& told : reports) told.is_check = true;
  return reports;
}

bool IsAnyUsed(const FlightFacts& facts) {
  if (!facts.align_report) return true;  // who was moved without figures was moved
  const auto& control = facts.align_report->control;
  return std::any_of(control.begin(), control.end(),
                     [](const alignment::ControlReport& point) { return point.is_used && !point.is_check; });
}

}  // namespace

Result<FlightFacts> PlaceByLists(FlightFacts known, const std::vector<flight::GcpList>& lists,
                                 bool* contradict) {
  if (ControlPointsOf(lists).empty()) {
    return flight::Because(ErrorCode::kUnprocessable, flight::RemarkCode::kFailNoPointMarked);
  }
  std::erase_if(known.flight.warnings, IsOfControl);
  if (known.is_placed) {
    std::optional<FlightFacts> moved = MoveToControl(known, lists);
    if (moved && IsAnyUsed(*moved)) return *std::move(moved);
  }
  PlaceRequest request;
  request.control = lists;
  request.is_again = true;
  return PlaceKnown(known, request, contradict);
}

void TellMarks(const std::vector<flight::GcpList>& lists, FlightFacts& facts) {
  if (!facts.is_placed || !facts.align_report) return;
  std::vector<alignment::ControlReport>& told = facts.align_report->control;
  std::erase_if(told, [](const alignment::ControlReport& point) { return point.is_check; });
  std::vector<alignment::ControlPoint> all = ControlPointsOf(lists);
  const std::vector<alignment::ControlPoint> checks = CheckPointsOf(lists);
  const std::vector<alignment::ControlReport> compared = CompareWithSurvey(facts, checks);
  told.insert(told.end(), compared.begin(), compared.end());
  all.insert(all.end(), checks.begin(), checks.end());
  std::map<std::string, std::vector<alignment::ControlMarkReport>> marks_of;
  for (MarksOfPoint& point : MarkResiduals(facts, all)) {
    marks_of.emplace(std::move(point.name), std::move(point.marks));
  }
  for (alignment::ControlReport& point : told) {
    const auto found = marks_of.find(point.name);
    point.marks = found == marks_of.end() ? std::vector<alignment::ControlMarkReport>() : found->second;
  }
}

}  // namespace skyquilt::pipeline
