// TieToControl: turns ground control points into observations of the adjustment and moves the block to them,
// so that the adjustment starts near. ReportControl says how well each fits afterwards. Heights count
// relative to each other: survey and drone seldom share their zero. Pure; any thread.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/alignment/adjustment/bundle_adjustment.h"
#include "core/alignment/adjustment/ground_control.h"
#include "core/poses/posed_flight.h"

namespace skyquilt::alignment {

// The photos of a flight by the names under which lists of control points know them: in any case, with or
// without their ending.
class MarkedPhotos {
 public:
  // `is_tied`: held by others; marks in the rest tell nothing of the block.
  MarkedPhotos(const std::vector<std::string>& names, const std::vector<View>& views,
               const std::vector<char>& is_tied);  // keeps references to the latter two

  // The point's marks, and where they meet; nothing, and the reason in `told`, when they do not.
  std::optional<Track> TrackOf(const ControlPoint& point, ControlReport& told) const;

 private:
  const std::vector<View>& views_;
  const std::vector<char>& is_tied_;
  std::map<std::string, int> number_of_;
};

// `problem` has been adjusted without control. A point needs two sightings in photos that are tied to others.
// One that lies far off where the others put the block is not used, and its report says so.
void TieToControl(const poses::PosedFlight& posed, const std::vector<ControlPoint>& control,
                  BundleProblem& problem, std::vector<ControlReport>& reports);

void ReportControl(const BundleProblem& problem, std::vector<ControlReport>& reports);

}  // namespace skyquilt::alignment
