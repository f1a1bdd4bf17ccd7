// Flights of the simulated multirotor that several tests look at, and the camera both are meant for.
#pragma once

#include <cstdint>

#include "core/geo/lat_lon.h"
#include "core/simulate/sensors/logged_survey.h"

namespace skyquilt::simulate {

// 4000 x 3000 pixels, 1.64 cm a pixel at 60 m.
inline camera::Intrinsics ReferenceCamera() { return camera::Intrinsics::Centered(4000, 3000, 3665.0); }

// 60 m high, five lines of 250 m at 8 m/s, 95 photos, about 330 s.
inline SurveyOptions ReferenceSurvey(std::uint32_t seed) {
  SurveyOptions options;
  options.plan.photos = 95;
  options.plan.photos_per_line = 19;
  options.plan.height_m = 60.0;
  options.plan.speed_mps = 8.0;
  // 250 m in 18 steps over 49.1 m of footprint; lines 25 m apart over 65.5 m.
  options.plan.front_overlap = 1.0 - 250.0 / 18.0 / (60.0 * 3000.0 / 3665.0);
  options.plan.side_overlap = 1.0 - 25.0 / (60.0 * 4000.0 / 3665.0);
  options.plan.heading_rad = geo::DegToRad(20.0);
  options.plan.seed = seed;
  return options;
}

// 20 m high, one short hop of about 75 s with a marker at take-off and a range finder: the source paper's
// case.
inline SurveyOptions PaperHop(std::uint32_t seed) {
  SurveyOptions options;
  options.plan.photos = 10;
  options.plan.photos_per_line = 5;
  options.plan.height_m = 20.0;
  options.plan.speed_mps = 4.0;
  options.plan.front_overlap = 0.7;
  options.plan.side_overlap = 0.6;
  options.plan.seed = seed;
  options.still_before_s = 5.0;
  options.run_in_m = 4.0;
  options.sensors.has_gnss = false;
  options.sensors.has_range = true;
  return options;
}

}  // namespace skyquilt::simulate
