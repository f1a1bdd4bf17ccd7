#include <fmt/core.h>

#include <cmath>

#include "tests/bench/poses/pose_metrics.h"
#include "tests/bench/poses/recorded_sensors.h"
#include "tests/bench/poses/tables.h"

namespace skyquilt::bench {
namespace {

FlightPlan HopPlan() {
  FlightPlan plan;
  plan.height_m = 20.0;
  plan.climb_mps = 2.0;
  plan.legs = 2;
  plan.leg_m = 45.0;
  plan.leg_spacing_m = 12.0;
  plan.speed_mps = 4.0;
  plan.still_s = 9.0;
  return plan;
}

// Each with what the one before has.
enum class Hop { kStart, kStartRange, kStartRangeRest, kStartEndRange, kStartEndRangeAttitude };

poses::SmootherInput Input(Hop hop, const AnalyticFlight& flight, const RecordedSensors& sensors) {
  poses::SmootherInput in;
  in.photo_times_s = flight.photo_times_s();
  in.imu = sensors.imu;
  in.options.imu.accel_white = SensorErrors{}.accel_white;
  const auto mark = [&](double t, bool with_yaw) {
    const FlightTruth truth = flight.At(t);
    poses::Marker marker;
    marker.t_s = t;
    marker.position_in_enu_m = truth.position;
    const Eigen::Vector3d nose = truth.enu_from_body * Eigen::Vector3d::UnitX();
    if (with_yaw) marker.yaw_rad = std::atan2(nose.x(), nose.y());
    in.markers.push_back(marker);
  };
  mark(0.0, true);
  in.still.push_back({0.0, 8.9});
  if (hop != Hop::kStart) in.ranges = sensors.ranges;
  if (hop >= Hop::kStartRangeRest) in.still.push_back({flight.landed_s() + 0.2, flight.duration_s() - 0.5});
  if (hop >= Hop::kStartEndRange) mark(flight.duration_s() - 0.5, false);
  if (hop == Hop::kStartEndRangeAttitude) in.attitudes = sensors.attitudes;
  return in;
}

}  // namespace

void PrintPaperHop(int seeds) {
  struct Row {
    Hop hop;
    const char* name;
    double reference_m;
  };
  const Row rows[] = {{Hop::kStart, "IMU, marker start", 14.0},
                      {Hop::kStartRange, "+ ultrasonic height", 14.0},
                      {Hop::kStartRangeRest, "+ rest after landing", 14.0},
                      {Hop::kStartEndRange, "+ end marker", 2.1},
                      {Hop::kStartEndRangeAttitude, "+ autopilot attitude", 1.5}};
  fmt::print("A hop of {:.0f} s at 20 m without GNSS (mean over {} flights of the RMS over photos)\n",
             AnalyticFlight(HopPlan(), 1).duration_s(), seeds);
  fmt::print("{:<24} {:>14} {:>10} {:>7} {:>9} {:>12}\n", "inputs", "position 2D m", "reference", "ratio",
             "height m", "NEES p/R");
  for (const Row& row : rows) {
    PoseMetrics mean;
    for (int seed = 1; seed <= seeds; ++seed) {
      const AnalyticFlight flight(HopPlan(), static_cast<std::uint64_t>(seed));
      const RecordedSensors sensors = RecordSensors(flight, SensorErrors{}, static_cast<std::uint64_t>(seed));
      const auto output = poses::SmoothChain(Input(row.hop, flight, sensors));
      if (!output.ok()) {
        fmt::print("{}: {}\n", row.name, output.error().message);
        continue;
      }
      const PoseMetrics m = Measure(flight, *output);
      mean.position_2d_m += m.position_2d_m / seeds;
      mean.height_m += m.height_m / seeds;
      mean.nees_position += m.nees_position / seeds;
      mean.nees_rotation += m.nees_rotation / seeds;
    }
    fmt::print("{:<24} {:>14.3g} {:>10.3g} {:>7.2f} {:>9.3g} {:>7.2f}/{:.2f}\n", row.name, mean.position_2d_m,
               row.reference_m, mean.position_2d_m / row.reference_m, mean.height_m, mean.nees_position,
               mean.nees_rotation);
  }
  fmt::print("\n");
}

}  // namespace skyquilt::bench
