#include "tests/bench/poses/accuracy_table.h"

#include <fmt/core.h>

#include <chrono>
#include <string>
#include <vector>

#include "tests/bench/poses/input_mixes.h"
#include "tests/bench/poses/pose_metrics.h"

namespace skyquilt::bench {
namespace {

// A reference of zero is one that was not stated.
struct Row {
  InputMix mix;
  const char* name;
  PoseMetrics reference;
};

PoseMetrics Reference(double p, double z, double tilt, double yaw, double center, double corner, double next,
                      double window) {
  PoseMetrics m;
  m.position_2d_m = p;
  m.height_m = z;
  m.tilt_deg = tilt;
  m.yaw_deg = yaw;
  m.center_m = center;
  m.corner_m = corner;
  m.next_m = next;
  m.window_px = window;
  return m;
}

std::vector<Row> Rows() {
  return {
      {InputMix::kImuStart, "IMU, marker start", Reference(1450, 296, 0.7, 28, 1450, 1520, 76, 0)},
      {InputMix::kImuBaroStartEnd, "IMU+baro, start+end", Reference(72, 0.5, 0.16, 7, 72, 72, 4.2, 540)},
      {InputMix::kImuBaroLinksStart, "IMU+baro+links, start",
       Reference(6.7, 0.23, 0.04, 2.1, 6.8, 7.3, 0.8, 100)},
      {InputMix::kBaroAttitudeLinksStart, "baro+att+links, start", Reference(6.6, 0, 0, 0, 0, 0, 0, 0)},
      {InputMix::kGnssCourse, "GNSS only, course", Reference(1.1, 1.1, 13, 8, 14, 23, 13, 1670)},
      {InputMix::kGnssAttitudeBaro, "GNSS+att+baro (XMP)", Reference(1.1, 0.7, 1.0, 2.6, 1.4, 3.7, 0.52, 68)},
      {InputMix::kGnssPoorCompassBaro, "same, poor compass",
       Reference(1.1, 0.7, 1.5, 5.2, 1.4, 6.4, 0.52, 68)},
      {InputMix::kGnssImuBaro, "GNSS+IMU+baro", Reference(1.0, 0.6, 0.04, 0.16, 1.0, 1.25, 0.15, 20)},
      {InputMix::kGnssImuAttitudeBaro, "GNSS+IMU+att+baro",
       Reference(0.9, 0.6, 0.04, 0.09, 0.9, 1.15, 0.14, 18)},
      {InputMix::kRtkAttitude, "RTK+att", Reference(0.02, 0.02, 0.9, 1.9, 0.95, 2.8, 0.47, 61)},
      {InputMix::kRtkImu, "RTK+IMU", Reference(0.01, 0.02, 0.03, 0.04, 0.04, 0.08, 0.02, 3)},
      {InputMix::kGnssAttitudeBaroLinks, "GNSS+att+baro+links",
       Reference(1.3, 0.2, 0.2, 0.14, 1.3, 1.3, 0.18, 23)},
      {InputMix::kGnssImuAttitudeBaroLinks, "GNSS+IMU+att+baro+links",
       Reference(1.1, 0.13, 0.03, 0.09, 1.1, 1.1, 0.07, 9)},
  };
}

constexpr double PoseMetrics::*kColumns[] = {
    &PoseMetrics::position_2d_m, &PoseMetrics::height_m, &PoseMetrics::tilt_deg, &PoseMetrics::yaw_deg,
    &PoseMetrics::center_m,      &PoseMetrics::corner_m, &PoseMetrics::next_m,   &PoseMetrics::window_px};
constexpr double PoseMetrics::*kRates[] = {&PoseMetrics::covered, &PoseMetrics::nees_position,
                                           &PoseMetrics::nees_rotation, &PoseMetrics::search_px};

std::string Cell(double measured, double reference) {
  if (reference <= 0.0) return fmt::format("{:>7.3g}             ", measured);
  return fmt::format("{:>7.3g}/{:<5.4g}x{:<5.2f} ", measured, reference, measured / reference);
}

}  // namespace

void PrintAccuracyTable(int seeds, const std::string& only) {
  fmt::print(
      "Accuracy of poses, 60 m above ground, 5 legs of 250 m, mean over {} flights of the RMS over photos.\n"
      "Each cell: measured/reference xratio. Covered: true correspondences inside their 99 % windows.\n\n",
      seeds);
  fmt::print("{:<24}{:<20}{:<20}{:<20}{:<20}{:<20}{:<20}{:<20}{:<20}{:>9} {:>8} {:>11} {:>5} {:>6}\n",
             "inputs", "position 2D m", "height m", "tilt deg", "yaw deg", "centre m", "corner m",
             "next photo m", "window px", "search px", "covered", "NEES p/R", "iter", "s");
  for (const Row& row : Rows()) {
    if (!std::string(row.name).starts_with(only)) continue;
    PoseMetrics mean;
    double seconds = 0.0, iterations = 0.0;
    int failed = 0;
    for (int seed = 1; seed <= seeds; ++seed) {
      const AnalyticFlight flight(PlanOf(row.mix), static_cast<std::uint64_t>(seed));
      const RecordedSensors sensors =
          RecordSensors(flight, ErrorsOf(row.mix), static_cast<std::uint64_t>(seed));
      const poses::SmootherInput input = InputOf(row.mix, flight, sensors);
      const auto begin = std::chrono::steady_clock::now();
      const Result<poses::SmootherOutput> output = poses::SmoothChain(input);
      seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() / seeds;
      if (!output.ok()) {
        ++failed;
        continue;
      }
      iterations += static_cast<double>(output->report.iterations) / seeds;
      const PoseMetrics m = Measure(flight, *output);
      for (const auto column : kColumns) mean.*column += m.*column / seeds;
      for (const auto rate : kRates) mean.*rate += m.*rate / seeds;
    }
    fmt::print("{:<24}", row.name);
    for (const auto column : kColumns) fmt::print("{}", Cell(mean.*column, row.reference.*column));
    fmt::print("{:>9.3g} {:>7.2f}% {:>5.2f}/{:<5.2f} {:>5.1f} {:>6.2f}", mean.search_px, 100.0 * mean.covered,
               mean.nees_position, mean.nees_rotation, iterations, seconds);
    if (failed > 0) fmt::print("  FAILED {}", failed);
    fmt::print("\n");
    std::fflush(stdout);
  }
  fmt::print("\n");
}

}  // namespace skyquilt::bench
