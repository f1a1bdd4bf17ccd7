// Simulated flights with known truth, aligned, beside the pose-only way: alignment_simulated [case [seeds]].
#include <fmt/core.h>
#include <sys/resource.h>

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <mutex>
#include <string>

#include "core/alignment/align_by_pose.h"
#include "core/alignment/align_flight.h"
#include "core/ground/model_ground.h"
#include "tests/core/alignment/simulated_case.h"

namespace {

using namespace skyquilt;

double CpuSeconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_utime.tv_sec + usage.ru_stime.tv_sec +
         1e-6 * (usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

// Renders, and keeps account of what that costs, for it is not the alignment's work.
class TimedSource final : public pipeline::PhotoSource {
 public:
  explicit TimedSource(const simulate::SimulatedFlight& flight) : source_(flight) {}
  Result<pipeline::DecodedImage> Decode(const flight::Photo& photo, int denominator) const override {
    rusage before{}, after{};
    getrusage(RUSAGE_THREAD, &before);
    auto decoded = source_.Decode(photo, denominator);
    getrusage(RUSAGE_THREAD, &after);
    const std::lock_guard lock(mutex_);
    cpu_s_ += static_cast<double>(after.ru_utime.tv_sec - before.ru_utime.tv_sec) +
              1e-6 * static_cast<double>(after.ru_utime.tv_usec - before.ru_utime.tv_usec);
    return decoded;
  }
  double cpu_s() const { return cpu_s_; }

 private:
  simulate::SimulatedPhotoSource source_;
  mutable std::mutex mutex_;
  mutable double cpu_s_ = 0.0;
};

struct Case {
  std::string name;
  double demand_gsds;  // of the relative error; 0: only reported
  std::function<void(simulate::SimulateOptions&)> set;
};

constexpr double kDeg = 3.14159265358979 / 180.0;

const Case kCases[] = {
    {"flat", 2.0, [](simulate::SimulateOptions&) {}},
    {"relief8", 5.0, [](simulate::SimulateOptions& o) { o.world.relief_m = 8.0; }},
    {"no_gimbal", 3.0,
     [](simulate::SimulateOptions& o) {
       o.trajectory.max_tilt_rad = 12.0 * kDeg;
       o.trajectory.height_wander_m = 0.05 * o.trajectory.height_m;
     }},
    {"no_attitude", 4.0, [](simulate::SimulateOptions& o) { o.noise = simulate::NoiseClass::kNoAttitude; }},
    {"rtk", 2.0, [](simulate::SimulateOptions& o) { o.noise = simulate::NoiseClass::kRtk; }},
    {"rows", 0.0, [](simulate::SimulateOptions& o) { o.world.texture = simulate::TextureLevel::kRows; }},
    {"bare", 0.0, [](simulate::SimulateOptions& o) { o.world.texture = simulate::TextureLevel::kBare; }},
    {"boxes", 0.0, [](simulate::SimulateOptions& o) { o.world.has_boxes = true; }},
};

}  // namespace

int main(int argc, char** argv) {
  const std::string wanted = argc > 1 ? argv[1] : "";
  const int seeds = argc > 2 ? std::atoi(argv[2]) : 1;
  const int photos = argc > 3 ? std::atoi(argv[3]) : 40;
  fmt::print("{:<12} {:>4} {:>5} {:>8} {:>7} {:>9} {:>9} {:>9} {:>9} {:>9} {:>7} {:>7} {:>6}\n", "case",
             "seed", "gsd", "aligned", "pieces", "rel GSD", "abs m", "pose rel", "pose abs", "worst/pri",
             "rms px", "cpu/ph", "ground");
  for (const Case& one : kCases) {
    if (!wanted.empty() && wanted != "all" && wanted != one.name) continue;
    for (int seed = 1; seed <= seeds; ++seed) {
      simulate::SimulateOptions options;
      options.seed = options.world.seed = static_cast<std::uint32_t>(seed);
      options.noise = simulate::NoiseClass::kXmpTypical;
      options.intrinsics = camera::Intrinsics::Centered(2000, 1500, 2000.0);  // 3 cm at 60 m
      options.intrinsics.k1 = -0.02;
      options.intrinsics.k2 = 0.01;
      options.trajectory.photos = photos;
      options.vignetting = 0.2;
      options.exposure_jitter = 0.05;
      one.set(options);
      const Result<simulate::SimulatedFlight> truth = simulate::PlanSimulatedFlight(options);
      if (!truth) return fmt::print(stderr, "{}\n", truth.error().message), 1;
      const poses::PosedFlight posed = alignment::PosesOf(*truth);
      const TimedSource source(*truth);
      alignment::AlignReport report;
      SilentProgress progress;
      const double before = CpuSeconds();
      const auto aligned = alignment::AlignFlight(posed, source, {}, report, progress);
      if (!aligned) return fmt::print(stderr, "{}\n", aligned.error().message), 1;
      ground::ModelGroundReport ground_report;
      const ground::GroundSurface surface = ground::ModelGround(*aligned, ground_report);
      const double cpu = CpuSeconds() - before - source.cpu_s();
      const alignment::AlignedFlight by_pose = alignment::AlignByPoseOnly(posed);
      const ground::GroundSurface plane = ground::GroundSurface::Plane(posed.ground_z_in_enu_m);
      const alignment::GroundError error = alignment::MeasureGroundError(*truth, *aligned, surface);
      const alignment::GroundError pose_error = alignment::MeasureGroundError(*truth, by_pose, plane);
      const std::vector<double> now = alignment::PhotoErrorsM(*truth, *aligned, surface);
      const std::vector<double> prior = alignment::PhotoErrorsM(*truth, by_pose, plane);
      double worst = 0.0;
      for (std::size_t i = 0; i < now.size(); ++i) worst = std::max(worst, now[i] - 1.1 * prior[i]);
      const double gsd = truth->GsdM();
      fmt::print(
          "{:<12} {:>4} {:>5.3f} {:>4}/{:<3} {:>7} {:>9.2f} {:>9.2f} {:>9.2f} {:>9.2f} {:>9.2f} {:>7.2f} "
          "{:>7.3f} "
          "{:>6}{}\n",
          one.name, seed, gsd, report.aligned, report.photos, report.pieces, error.relative_ce90_m / gsd,
          error.absolute_ce90_m, pose_error.relative_ce90_m / gsd, pose_error.absolute_ce90_m, worst,
          report.residual_rms_px, cpu / report.photos, ground_report.model,
          one.demand_gsds > 0.0 && error.relative_ce90_m > one.demand_gsds * gsd ? "  MISSED" : "");
      std::fflush(stdout);
    }
  }
  return 0;
}
