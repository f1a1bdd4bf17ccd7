// FlightHeights: one height above the ground at take-off for every photo, by one rule for the whole flight,
// so that photos never differ by a zero point. Metres. Pure; any thread. Order of trust: relative height
// (barometer since take-off), measured height above ground, sea-level or ellipsoidal height against photos of
// this flight that have both, absolute height above an elevation model, and last a height guessed from the
// spacing of the photos. A take-off height that somebody gives counts instead of what the photos say of it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/flight/photo.h"
#include "core/geo/dem_source.h"
#include "core/poses/evidence/assumption.h"

namespace skyquilt::poses {

enum class HeightRule { kAboveTakeoff, kElevationModel, kSpacing };

struct FlightHeights {
  HeightRule rule = HeightRule::kAboveTakeoff;
  std::vector<std::optional<double>>
      above_ground_m;                    // one per photo; empty where the photo has no height at all
  double takeoff_ellipsoid_m = 0.0;      // of the flat ground, best knowledge
  bool is_above_ellipsoid = false;       // that is known; else all heights count from the take-off
  bool hangs_on_cameras = false;         // that height follows from the cameras' own absolute ones
  double sigma_m = 0.5;                  // of the heights above ground, common part
  std::string rule_in_words;             // for the report
  std::optional<Assumption> assumption;  // nothing: heights are recorded
};

// `dem` may be null. `takeoff_ellipsoid_m`: given by the user.
FlightHeights ChooseHeights(const std::vector<flight::Photo>& photos, const geo::DemSource* dem,
                            const std::optional<double>& takeoff_ellipsoid_m = {});

// The height at which photos spaced as these are would overlap as surveys usually do; within 5 to 500 m.
double GuessHeightFromSpacing(const std::vector<flight::Photo>& photos);

// The height above the ellipsoid that a record means, through the geoid where it counts from sea level.
std::optional<double> EllipsoidHeightM(const flight::RecordedPosition& position);

// Component by component, safe across the date line; of photos of several places the middle of most of them.
// Nothing without positions.
std::optional<geo::LatLon> MedianPosition(const std::vector<geo::LatLon>& positions);

}  // namespace skyquilt::poses
