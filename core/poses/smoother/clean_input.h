// What the smoother may rely on: every series finite, in rising order, without repeats, and cut to the part
// of the flight that the photos need. Seconds. Pure; any thread.
#pragma once

#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/poses/smoother/smoother.h"

namespace skyquilt::poses {

struct CleanInput {
  SmootherInput input;
  double begin_s =
      0.0;  // the chain's span: photos, markers and stillness, and half a minute more where data is
  double end_s = 0.0;
  std::vector<std::string> warnings;
};

// Fails with kUnprocessable without photos, with photo times that do not rise or are not finite, and where
// nothing at all says where the flight was.
Result<CleanInput> CleanSmootherInput(const SmootherInput& raw);

// Attitudes carried to the knots where no inertial samples do it: between two fixes close in time the
// shortest turn is far nearer to the truth than any turn between knots a second apart. Fixes too sparse for
// that stay as they are.
std::vector<AttitudeFix> AttitudesAtKnots(const std::vector<AttitudeFix>& fixes,
                                          const std::vector<double>& knot_times_s);

}  // namespace skyquilt::poses
