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

// What must hold; 0 or false: is not asked.
struct Demands {
  int show = 0;                       // the line of the product's demands this case stands for
  double relative_gsds = 0.0;         // of nine of ten pixels, after the best similarity
  double absolute_gsds = 0.0;         // 0: at most a tenth more than the recorded positions are off
  bool improves_every_photo = false;  // or makes it worse by a tenth at most
  bool has_no_false_pairs = true;
  bool is_same_on_one_thread = false;  // to the last bit
};

struct SimulatedCase {
  std::string name;
  Demands demands;
  bool has_lies = false;
  bool has_control = false;  // five surveyed points
  std::function<void(simulate::SimulateOptions&)> set;
};

const std::vector<SimulatedCase>& SimulatedCases();

struct Lies {
  std::set<std::string> gnss, yaw, elsewhere, duplicate, blurred;
  std::set<std::string> All() const;
};

// Ten positions 50 m off, five yaws turned by 90 degrees, two photos of another place (one says so, one
// claims to be here), one duplicate and one blurred.
Lies TellLies(simulate::SimulatedFlight& flight);

// Renders each photo once into `folder` (none: every time), so that repeated runs measure alignment and not
// rendering. Keeps account of its own cost.
class RenderedSource final : public flight::PhotoSource {
 public:
  RenderedSource(const simulate::SimulatedFlight& flight, const Lies& lies, std::string folder);
  Result<image::DecodedImage> Decode(const flight::Photo& photo, int denominator) const override;
  double cpu_s() const { return cpu_s_; }

 private:
  Result<image::DecodedImage> Render(const flight::Photo& photo, int denominator) const;

  simulate::SimulatedPhotoSource source_;
  simulate::SimulatedFlight elsewhere_;
  Lies lies_;
  std::string folder_;
  mutable std::mutex mutex_;
  mutable double cpu_s_ = 0.0;
};

}  // namespace skyquilt::alignment
