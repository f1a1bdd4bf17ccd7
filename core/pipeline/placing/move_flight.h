// MoveFlight: everything that a finished flight knows in its local frame (cameras, ground) turned, scaled and
// shifted as one, without a look at any photo; and what one must know of a flight to move it: where the marks
// of surveyed points meet, how wide it is. Frame `enu` before and after. Pure; any thread.
#pragma once

#include <string>
#include <vector>

#include "core/alignment/estimators/similarity.h"
#include "core/alignment/scene/ground_control.h"
#include "core/alignment/scene/matches.h"
#include "core/base/result.h"
#include "core/flight/remarks/remark.h"
#include "core/geo/local_frame.h"
#include "core/pipeline/placing/place_request.h"
#include "core/pipeline/report/flight_facts.h"

namespace skyquilt::pipeline {

// A similarity of the plane in space: about the vertical through the origin, and stretched about this height.
alignment::Similarity3 AboutVertical(const alignment::GroundSimilarity& move, double z_m);

// The frame stays: `facts.flight.frame` is the caller's to change with it. The appearance goes, and what
// its seams showed: they lie elsewhere on the map now.
void MoveFlight(const alignment::Similarity3& new_from_old, FlightFacts& facts);

// Where the marks of a surveyed point meet, in the flight's frame, and where it was surveyed.
struct MarkedPoint {
  Eigen::Vector3d seen_in_enu = Eigen::Vector3d::Zero();
  alignment::ControlPoint point;
  std::size_t report = 0;  // number of its report
};

// The points that two or more aligned photos show; every point has a report, which says why one is not.
std::vector<MarkedPoint> MarkedPointsOf(const FlightFacts& known,
                                        const std::vector<alignment::ControlPoint>& control,
                                        std::vector<alignment::ControlReport>& reports);

// By point, how far its marks lie from where its survey and the flight put it. Of a flight that has its
// place. A point's height is where its marks meet, else the ground's: survey and flight seldom share their
// zero.
std::vector<std::vector<alignment::ControlMarkReport>> MarkResiduals(
    const FlightFacts& placed, const std::vector<alignment::ControlPoint>& control);

// Of the flight's photos, straight down, in the median; 0 of a flight without photos.
double MedianGsdM(const FlightFacts& known);

// Between the outermost cameras, along the diagonal.
double ExtentM(const FlightFacts& known);

// What became of surveyed points, and how far the flight moved for them from where it was placed before,
// among the alignment's figures, where the flight has any. A flight that lay nowhere did not move.
void TellOfControl(const std::vector<alignment::ControlReport>& control, const Eigen::Vector3d& moved_m,
                   FlightFacts& facts);

// Is it of whoever placed the map by hand?
bool IsOfHand(const flight::Remark& said);

// Is it of what a survey had the map say?
bool IsOfControl(const flight::Remark& said);

struct MoveOfPairs {
  alignment::Similarity3 new_from_old;
  geo::LocalFrame frame;
  double miss_m = 0.0;  // what the worst pair is missed by; 0 of one or two, which fit anything
};

// By what turn, scale and shift a finished map comes to where things that it shows really are. One pair
// shifts it; two or more also turn and scale it, by least squares. Heights stay as they are above the ground.
// Frame `enu` of the flight before, a frame at the first true place after. pairs: one or more. Errors, whole
// sentences for the user: kUnprocessable (pairs that lie too near together, or contradict each other).
Result<MoveOfPairs> MoveByPairs(const FlightFacts& known, const std::vector<ShownPair>& pairs);

}  // namespace skyquilt::pipeline
