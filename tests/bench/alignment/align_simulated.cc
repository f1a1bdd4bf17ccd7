// Simulated flights with known truth, aligned, beside the pose-only way:
//   alignment_simulated [case|all [seeds [photos [width_px [folder for rendered photos [threads]]]]]]
#include <fmt/core.h>
#include <sys/resource.h>

#include <algorithm>
#include <cstdlib>
#include <string>

#include "core/alignment/align_by_pose.h"
#include "core/alignment/align_flight.h"
#include "core/ground/model_ground.h"
#include "tests/bench/alignment/simulated_cases.h"
#include "tests/core/alignment/simulated_case.h"

namespace {

using namespace skyquilt;

double CpuSeconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
         1e-6 * static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

simulate::SimulateOptions Options(const alignment::SimulatedCase& one, int seed, int photos, int width_px) {
  simulate::SimulateOptions options;
  options.seed = options.world.seed = static_cast<std::uint32_t>(seed);
  options.noise = simulate::NoiseClass::kXmpTypical;
  // 3 cm at 60 m when 2000 pixels wide.
  options.intrinsics = camera::Intrinsics::Centered(width_px, width_px * 3 / 4, width_px);
  options.intrinsics.k1 = -0.02;
  options.intrinsics.k2 = 0.01;
  options.trajectory.photos = photos;
  options.vignetting = 0.2;
  options.exposure_jitter = 0.05;
  one.set(options);
  return options;
}

void PrintFates(const alignment::Lies& lies, const alignment::AlignedFlight& flight,
                const std::vector<double>& errors_m) {
  const auto print = [&](const char* lie, const std::set<std::string>& names) {
    for (const std::string& name : names) {
      std::string fate = "not in the result";
      for (std::size_t i = 0; i < flight.photos.size(); ++i) {
        const alignment::AlignedPhoto& photo = flight.photos[i];
        if (photo.photo.name == name) {
          fate = fmt::format("{}, {:.2f} m off: {}", PlacementName(photo.placement), errors_m[i],
                             photo.placement_reason);
        }
      }
      for (const flight::LeftOutPhoto& out : flight.left_out) {
        if (out.name == name) fate = "left out: " + out.reason;
      }
      fmt::print("  {:<10} {}: {}\n", lie, name, fate);
    }
  };
  print("gnss", lies.gnss);
  print("yaw", lies.yaw);
  print("elsewhere", lies.elsewhere);
  print("duplicate", lies.duplicate);
  print("blurred", lies.blurred);
}

}  // namespace

int main(int argc, char** argv) {
  const std::string wanted = argc > 1 ? argv[1] : "all";
  const int seeds = argc > 2 ? std::atoi(argv[2]) : 3;
  const int photos = argc > 3 ? std::atoi(argv[3]) : 60;
  const int width_px = argc > 4 ? std::atoi(argv[4]) : 2000;
  const std::string folder = argc > 5 ? argv[5] : "";
  alignment::AlignOptions align_options;
  if (argc > 6) align_options.threads = std::atoi(argv[6]);
  fmt::print("{:<12} {:>4} {:>5} {:>7} {:>3} {:>7} {:>7} {:>6} {:>6} {:>8} {:>8} {:>7} {:>6} {:>6} {:>6}\n",
             "case", "seed", "gsd m", "aligned", "pcs", "rel GSD", "abs m", "gnss m", "shared", "pose rel",
             "pose abs", "worse m", "rms px", "cpu/ph", "ground");
  int missed = 0;
  for (const alignment::SimulatedCase& one : alignment::SimulatedCases()) {
    if (wanted != "all" && wanted != one.name) continue;
    for (int seed = 1; seed <= seeds; ++seed) {
      Result<simulate::SimulatedFlight> truth =
          simulate::PlanSimulatedFlight(Options(one, seed, photos, width_px));
      if (!truth) return fmt::print(stderr, "{}\n", truth.error().message), 1;
      const alignment::GnssError gnss = alignment::MeasureGnssError(*truth);
      alignment::Lies lies;
      if (one.has_lies) lies = alignment::TellLies(*truth);
      align_options.control =
          one.has_control ? alignment::SurveyControl(*truth) : std::vector<alignment::ControlPoint>{};
      const poses::PosedFlight posed = alignment::PosesOf(*truth);
      const alignment::RenderedSource source(*truth, lies, folder);
      alignment::AlignReport report;
      SilentProgress progress;
      const double before = CpuSeconds();
      const auto aligned = alignment::AlignFlight(posed, source, align_options, report, progress);
      if (!aligned) return fmt::print(stderr, "{}\n", aligned.error().message), 1;
      ground::ModelGroundReport ground_report;
      const ground::GroundSurface surface = ground::ModelGround(*aligned, ground_report);
      const double cpu = CpuSeconds() - before - source.cpu_s();
      const alignment::AlignedFlight by_pose = alignment::AlignByPoseOnly(posed);
      const ground::GroundSurface plane = ground::GroundSurface::Plane(posed.ground_z_in_enu_m);
      const alignment::GroundError error =
          alignment::MeasureGroundError(*truth, *aligned, surface, lies.Pictures());
      const alignment::GroundError pose_error =
          alignment::MeasureGroundError(*truth, by_pose, plane, lies.Pictures());
      const std::vector<double> now = alignment::PhotoErrorsM(*truth, *aligned, surface);
      const std::vector<double> prior = alignment::PhotoErrorsM(*truth, by_pose, plane);
      // By how much the worst photo lies further off than 1.1 times its recorded pose.
      double worst = 0.0;
      for (std::size_t i = 0; i < now.size(); ++i) {
        for (std::size_t k = 0; k < prior.size(); ++k) {
          if (by_pose.photos[k].photo.name != aligned->photos[i].photo.name) continue;
          if (!lies.Pictures().contains(aligned->photos[i].photo.name)) {
            worst = std::max(worst, now[i] - 1.1 * prior[k]);
          }
        }
      }
      const double gsd = truth->GsdM();
      const bool is_missed =
          (one.demand_gsds > 0.0 && error.relative_ce90_m > one.demand_gsds * gsd) ||
          (one.demand_absolute_gsds > 0.0 && error.absolute_ce90_m > one.demand_absolute_gsds * gsd) ||
          (one.demand_absolute_gsds == 0.0 && error.absolute_ce90_m > 1.1 * gnss.ce90_m);
      missed += is_missed ? 1 : 0;
      fmt::print(
          "{:<12} {:>4} {:>5.3f} {:>3}/{:<3} {:>3} {:>7.2f} {:>7.2f} {:>6.2f} {:>6.2f} {:>8.2f} {:>8.2f} "
          "{:>7.2f} {:>6.2f} {:>6.3f} {:>6}{}\n",
          one.name, seed, gsd, report.aligned, report.photos, report.pieces, error.relative_ce90_m / gsd,
          error.absolute_ce90_m, gnss.ce90_m, gnss.mean_m, pose_error.relative_ce90_m / gsd,
          pose_error.absolute_ce90_m, worst, report.residual_rms_px, cpu / report.photos, ground_report.model,
          is_missed ? "  MISSED" : "");
      for (const alignment::ControlReport& point : report.control) {
        fmt::print("  {}: {} marks, off by {:.3f} {:.3f} {:.3f} m, {:.2f} px {}\n", point.name,
                   point.sightings, point.miss_east_m, point.miss_north_m, point.miss_up_m, point.residual_px,
                   point.reason);
      }
      if (one.has_lies) PrintFates(lies, *aligned, now);
      std::fflush(stdout);
    }
  }
  return missed > 0 ? 1 : 0;
}
