// A simulated flight, what alignment made of it, and how far that is from the truth. For tests and
// benchmarks; who calls Align links tests/support/rendered_once.cc.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "core/alignment/align_flight.h"
#include "core/ground/ground_surface.h"
#include "core/ground/model_ground.h"
#include "core/poses/posed_flight.h"
#include "core/simulate/simulate_flight.h"
#include "tests/support/rendered_once.h"
#include "tests/support/value_of.h"

namespace skyquilt::alignment {

struct GroundError {
  double relative_ce90_m = 0.0;  // after the best similarity of the plane
  double absolute_ce90_m = 0.0;
  double worst_photo_m = 0.0;  // largest median error of one photo, absolute
};

// Where every photo's pixels (a grid of them) fall on `surface` against where they truly lie. Photos named in
// `without` do not count.
GroundError MeasureGroundError(const simulate::SimulatedFlight& truth, const AlignedFlight& flight,
                               const ground::GroundSurface& surface,
                               const std::set<std::string>& without = {});
// Median absolute ground error of each photo.
std::vector<double> PhotoErrorsM(const simulate::SimulatedFlight& truth, const AlignedFlight& flight,
                                 const ground::GroundSurface& surface);

// The same after the best similarity of the plane: without what all photos share, which no picture shows.
std::vector<double> RelativePhotoErrorsM(const simulate::SimulatedFlight& truth, const AlignedFlight& flight,
                                         const ground::GroundSurface& surface);

struct GnssError {
  double ce90_m = 0.0;  // horizontal, of the recorded positions
  double mean_m = 0.0;  // what all photos share
};
GnssError MeasureGnssError(const simulate::SimulatedFlight& truth, const std::set<std::string>& without = {});

// Surveyed points in the corners and the middle of the flight, each marked in up to six photos by somebody
// whose hand is good to half a pixel, with heights above another zero than the photos'.
std::vector<ControlPoint> SurveyControl(const simulate::SimulatedFlight& truth);

// Small pictures, 8 cm on the ground and four to a line, so that a case takes seconds.
simulate::SimulatedFlight SmallTruth(int photos, double relief_m);

// Reads what the simulated photos record, as the product would.
poses::PosedFlight PosesOf(const simulate::SimulatedFlight& truth);

// What AlignFlight makes of such poses, on two threads unless asked otherwise; a failure ends the test.
struct Outcome {
  AlignedFlight flight;
  AlignReport report;
  GroundError error;  // on the ground as its tie points have it
};

inline Outcome Align(const simulate::SimulatedFlight& truth, const poses::PosedFlight& posed,
                     AlignOptions options = {}) {
  if (options.threads == 0) options.threads = 2;
  Outcome outcome;
  SilentProgress progress;
  outcome.flight =
      test::ValueOf(AlignFlight(posed, test::PhotosOf(truth), options, outcome.report, progress));
  ground::ModelGroundReport ground_report;
  outcome.error =
      MeasureGroundError(truth, outcome.flight, ground::ModelGround(outcome.flight, ground_report));
  return outcome;
}

}  // namespace skyquilt::alignment
