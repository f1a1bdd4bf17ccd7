// The flights of known truth on which alignment is measured: what each is like, and what a spoilt one lies
// about.
#pragma once

#include <functional>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "core/simulate/simulate_flight.h"

namespace skyquilt::alignment {

struct SimulatedCase {
  std::string name;
  double demand_gsds = 0.0;           // of the relative error; 0: only reported
  double demand_absolute_gsds = 0.0;  // 0: none but that of the recorded positions
  bool has_lies = false;
  bool has_control = false;  // five surveyed points
  std::function<void(simulate::SimulateOptions&)> set;
};

const std::vector<SimulatedCase>& SimulatedCases();

struct Lies {
  std::set<std::string> gnss, yaw, elsewhere, duplicate, blurred;
  std::set<std::string> Pictures() const;  // photos whose place the pictures cannot tell: of another place
};

// Ten positions 50 m off, five yaws turned by 90 degrees, two photos of another place (one says so, one
// claims to be here), one duplicate and one blurred.
Lies TellLies(simulate::SimulatedFlight& flight);

// Renders each photo once into `folder` (none: every time), so that repeated runs measure alignment and not
// rendering. Keeps account of its own cost.
class RenderedSource final : public pipeline::PhotoSource {
 public:
  RenderedSource(const simulate::SimulatedFlight& flight, const Lies& lies, std::string folder);
  Result<pipeline::DecodedImage> Decode(const flight::Photo& photo, int denominator) const override;
  double cpu_s() const { return cpu_s_; }

 private:
  Result<pipeline::DecodedImage> Render(const flight::Photo& photo, int denominator) const;

  simulate::SimulatedPhotoSource source_;
  simulate::SimulatedFlight elsewhere_;
  std::set<std::string> of_elsewhere_;
  std::string folder_;
  mutable std::mutex mutex_;
  mutable double cpu_s_ = 0.0;
};

}  // namespace skyquilt::alignment
