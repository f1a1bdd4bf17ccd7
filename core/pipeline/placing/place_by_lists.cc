#include "core/pipeline/placing/place_by_lists.h"

#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <string_view>
#include <utility>

#include "core/pipeline/control_points.h"
#include "core/pipeline/placing/move_flight.h"
#include "core/pipeline/placing/move_to_control.h"
#include "core/pipeline/placing/place_known.h"

namespace skyquilt::pipeline {
namespace {

// How the sentences begin that control points are told in, here and by alignment::ControlInWords.
constexpr std::array<std::string_view, 3> kWordsOfControl = {"Ground control point ",
                                                             "The finished map was placed by ",
                                                             "The finished flight was moved as a whole to "};

void EraseWordsOfControl(std::vector<std::string>& warnings) {
  std::erase_if(warnings, [](const std::string& warning) {
    return std::any_of(kWordsOfControl.begin(), kWordsOfControl.end(),
                       [&](std::string_view begin) { return warning.starts_with(begin); });
  });
}

bool IsAnyUsed(const FlightFacts& facts) {
  if (!facts.align_report) return true;  // who was moved without figures was moved
  const auto& control = facts.align_report->control;
  return std::any_of(control.begin(), control.end(),
                     [](const alignment::ControlReport& point) { return point.is_used; });
}

}  // namespace

Result<FlightFacts> PlaceByLists(FlightFacts known, const std::vector<flight::GcpList>& lists) {
  if (ControlPointsOf(lists).empty()) {
    return Error{
        ErrorCode::kUnprocessable,
        "No surveyed point is marked in a photo yet. Mark each in two or more photos, and three points "
        "or more, spread over the map.",
        ""};
  }
  EraseWordsOfControl(known.flight.warnings);
  if (known.is_placed) {
    std::optional<FlightFacts> moved = MoveToControl(known, lists);
    if (moved && IsAnyUsed(*moved)) return *std::move(moved);
  }
  PlaceRequest request;
  request.control = lists;
  request.is_again = true;
  return PlaceKnown(known, request);
}

void TellMarks(const std::vector<flight::GcpList>& lists, FlightFacts& facts) {
  if (!facts.is_placed || !facts.align_report) return;
  std::map<std::string, std::vector<alignment::ControlMarkReport>> marks_of;
  for (MarksOfPoint& point : MarkResiduals(facts, ControlPointsOf(lists))) {
    marks_of.emplace(std::move(point.name), std::move(point.marks));
  }
  for (alignment::ControlReport& point : facts.align_report->control) {
    const auto found = marks_of.find(point.name);
    point.marks = found == marks_of.end() ? std::vector<alignment::ControlMarkReport>() : found->second;
  }
}

}  // namespace skyquilt::pipeline
