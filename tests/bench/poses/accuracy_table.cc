#include <fmt/core.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <random>
#include <vector>

#include "tests/bench/poses/input_mixes.h"
#include "tests/bench/poses/pose_metrics.h"
#include "tests/bench/poses/tables.h"

namespace skyquilt::bench {
namespace {

struct Column {
  const char* name;
  double PoseMetrics::*value;
};
constexpr std::array<Column, 8> kColumns{{{"position 2D m", &PoseMetrics::position_2d_m},
                                          {"height m", &PoseMetrics::height_m},
                                          {"tilt deg", &PoseMetrics::tilt_deg},
                                          {"yaw deg", &PoseMetrics::yaw_deg},
                                          {"centre m", &PoseMetrics::center_m},
                                          {"corner m", &PoseMetrics::corner_m},
                                          {"next photo m", &PoseMetrics::next_m},
                                          {"window px", &PoseMetrics::window_px}}};
constexpr double PoseMetrics::*kRates[] = {&PoseMetrics::covered, &PoseMetrics::nees_position,
                                           &PoseMetrics::nees_rotation, &PoseMetrics::search_px};

// As stated, with its digits; empty: not stated. How far a figure was rounded is half its last digit.
struct Row {
  InputMix mix;
  const char* name;
  std::array<std::string_view, kColumns.size()> reference;
};

std::vector<Row> Rows() {
  return {
      {InputMix::kImuStart, "IMU, marker start", {"1450", "296", "0.7", "28", "1450", "1520", "76", ""}},
      {InputMix::kImuBaroStartEnd,
       "IMU+baro, start+end",
       {"72", "0.5", "0.16", "7", "72", "72", "4.2", "540"}},
      {InputMix::kGnssCourse, "GNSS only, course", {"1.1", "1.1", "13", "8", "14", "23", "13", "1670"}},
      {InputMix::kGnssAttitudeBaro,
       "GNSS+att+baro (XMP)",
       {"1.1", "0.7", "1.0", "2.6", "1.4", "3.7", "0.52", "68"}},
      {InputMix::kGnssPoorCompassBaro,
       "same, poor compass",
       {"1.1", "0.7", "1.5", "5.2", "1.4", "6.4", "0.52", "68"}},
      {InputMix::kGnssImuBaro, "GNSS+IMU+baro", {"1.0", "0.6", "0.04", "0.16", "1.0", "1.25", "0.15", "20"}},
      {InputMix::kGnssImuAttitudeBaro,
       "GNSS+IMU+att+baro",
       {"0.9", "0.6", "0.04", "0.09", "0.9", "1.15", "0.14", "18"}},
      {InputMix::kRtkAttitude, "RTK+att", {"0.02", "0.02", "0.9", "1.9", "0.95", "2.8", "0.47", "61"}},
      {InputMix::kRtkImu, "RTK+IMU", {"0.01", "0.02", "0.03", "0.04", "0.04", "0.08", "0.02", "3"}},
  };
}

double RoundedByUpTo(std::string_view figure) {
  const std::size_t point = figure.find('.');
  return point == std::string_view::npos
             ? 0.5
             : 0.5 * std::pow(10.0, -static_cast<double>(figure.size() - point - 1));
}

struct Mean {
  double value = 0.0;
  double sigma = 0.0;  // of the mean, by drawing the flights again with replacement
};

Mean MeanOf(const std::vector<PoseMetrics>& flights, double PoseMetrics::*column) {
  constexpr int kDraws = 1000;
  Mean mean;
  const double n = static_cast<double>(flights.size());
  for (const PoseMetrics& flight : flights) mean.value += flight.*column / n;
  std::mt19937_64 random(1);
  std::uniform_int_distribution<std::size_t> any(0, flights.size() - 1);
  for (int draw = 0; draw < kDraws; ++draw) {
    double drawn = 0.0;
    for (std::size_t k = 0; k < flights.size(); ++k) drawn += flights[any(random)].*column / n;
    mean.sigma += (drawn - mean.value) * (drawn - mean.value) / kDraws;
  }
  mean.sigma = std::sqrt(mean.sigma);
  return mean;
}

// Measured/reference xratio+-its sampling error, and a mark where the ratio is above 1.3: `!` plainly; `~`
// where the reference's rounding or two sampling errors explain it.
std::string Cell(const Mean& measured, std::string_view figure) {
  if (figure.empty()) return fmt::format("{:<25.3g}", measured.value);
  const double reference = std::strtod(std::string(figure).c_str(), nullptr);
  const double ratio = measured.value / reference;
  const double error = measured.sigma / reference;
  const bool is_explained =
      measured.value <= 1.3 * (reference + RoundedByUpTo(figure)) || ratio - 2.0 * error <= 1.3;
  const char* mark = ratio <= 1.3 ? "" : is_explained ? "~" : "!";
  return fmt::format("{:<25}",
                     fmt::format("{:.3g}/{} x{:.2f}+-{:.2f}{}", measured.value, figure, ratio, error, mark));
}

}  // namespace

void PrintAccuracyTable(int seeds, const std::string& only) {
  fmt::print(
      "Accuracy of poses, 60 m above ground, 5 legs of 250 m, mean over {} flights of the RMS over photos.\n"
      "Each cell: measured/reference xratio+-sampling error (bootstrap over flights). Above 1.3: ! plainly, "
      "~ where "
      "that error or\nthe reference's rounding explains it. Covered: true correspondences inside their 99 % "
      "windows.\n\n",
      seeds);
  fmt::print("{:<24}", "inputs");
  for (const Column& column : kColumns) fmt::print("{:<25}", column.name);
  fmt::print("{:>9} {:>8} {:>11} {:>5} {:>6}\n", "search px", "covered", "NEES p/R", "iter", "s");
  for (const Row& row : Rows()) {
    if (!std::string(row.name).starts_with(only)) continue;
    std::vector<PoseMetrics> flights;
    double seconds = 0.0, iterations = 0.0;
    for (int seed = 1; seed <= seeds; ++seed) {
      const AnalyticFlight flight(PlanOf(row.mix), static_cast<std::uint64_t>(seed));
      const RecordedSensors sensors =
          RecordSensors(flight, ErrorsOf(row.mix), static_cast<std::uint64_t>(seed));
      const poses::SmootherInput input = InputOf(row.mix, flight, sensors);
      const auto begin = std::chrono::steady_clock::now();
      const Result<poses::SmootherOutput> output = poses::SmoothChain(input);
      seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() / seeds;
      if (!output.ok()) continue;
      iterations += static_cast<double>(output->report.iterations) / seeds;
      flights.push_back(Measure(flight, *output));
    }
    fmt::print("{:<24}", row.name);
    if (flights.empty()) {
      fmt::print("FAILED\n");
      continue;
    }
    for (std::size_t c = 0; c < kColumns.size(); ++c) {
      fmt::print("{}", Cell(MeanOf(flights, kColumns[c].value), row.reference[c]));
    }
    PoseMetrics rates;
    for (const auto rate : kRates) rates.*rate = MeanOf(flights, rate).value;
    fmt::print("{:>9.3g} {:>7.2f}% {:>5.2f}/{:<5.2f} {:>5.1f} {:>6.2f}", rates.search_px,
               100.0 * rates.covered, rates.nees_position, rates.nees_rotation, iterations, seconds);
    const std::size_t failed = static_cast<std::size_t>(seeds) - flights.size();
    if (failed > 0) fmt::print("  FAILED {}", failed);
    fmt::print("\n");
    std::fflush(stdout);
  }
  fmt::print("\n");
}

}  // namespace skyquilt::bench
