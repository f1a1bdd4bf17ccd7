// Simulated flights with known truth, aligned, beside the pose-only way, and whether what is demanded holds:
//   alignment_simulated [case|all [seeds [photos [width_px [folder for rendered photos [threads]]]]]]
#include <fmt/core.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <utility>

#include "core/flight/remarks/remark_words.h"
#include "tests/bench/alignment/cpu_seconds.h"
#include "tests/bench/alignment/judge_alignment.h"

namespace {

using namespace skyquilt;
using namespace skyquilt::alignment;

simulate::SimulateOptions Options(const SimulatedCase& one, int seed, int photos, int width_px) {
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

struct Setup {
  int seeds = 3;
  int photos = 60;
  int width_px = 2000;
  std::string folder;
  int threads = 0;
};

struct Run {
  poses::PosedFlight posed;
  AlignedFlight aligned;
  ground::GroundSurface surface = ground::GroundSurface::Plane(0.0);
  AlignReport report;
  std::string ground_model;
  double cpu_s = 0.0;
};

Result<Run> Align(const simulate::SimulatedFlight& truth, const Lies& lies, bool has_control,
                  const Setup& setup) {
  Run run;
  run.posed = PosesOf(truth);
  AlignOptions options;
  options.threads = setup.threads;
  if (has_control) options.control = SurveyControl(truth);
  const RenderedSource source(truth, lies, setup.folder);
  SilentProgress progress;
  const double before = CpuSeconds();
  Result<AlignedFlight> aligned = AlignFlight(run.posed, source, options, run.report, progress);
  if (!aligned) return aligned.error();
  run.aligned = *std::move(aligned);
  ground::ModelGroundReport ground_report;
  run.surface = ground::ModelGround(run.aligned, ground_report);
  run.ground_model = ground_report.model;
  run.cpu_s = CpuSeconds() - before - source.cpu_s();
  return run;
}

// The photos nobody lies about must lie as well as if nobody lied.
void JudgeTheRest(const SimulatedCase& one, const Lies& lies, const Setup& setup, int seed,
                  const simulate::SimulatedFlight& truth, Judgement& judged) {
  constexpr double kMaxWorseGsds = 0.5;
  const Result<simulate::SimulatedFlight> honest =
      simulate::PlanSimulatedFlight(Options(one, seed, setup.photos, setup.width_px));
  if (!honest) return judged.faults.push_back(honest.error().message);
  const Result<Run> run = Align(*honest, {}, false, setup);
  if (!run) return judged.faults.push_back(run.error().message);
  const GroundError error = MeasureGroundError(*honest, run->aligned, run->surface, lies.All());
  if (judged.error.relative_ce90_m > error.relative_ce90_m + kMaxWorseGsds * truth.GsdM()) {
    judged.faults.push_back(fmt::format("the rest is worse than without lies ({:.2f} GSD)",
                                        error.relative_ce90_m / truth.GsdM()));
  }
}

void JudgeThreads(const Run& run, const simulate::SimulatedFlight& truth, Setup setup, Judgement& judged) {
  setup.threads = 1;
  const Result<Run> alone = Align(truth, {}, false, setup);
  if (!alone) return judged.faults.push_back(alone.error().message);
  const auto is_same = [](const AlignedPhoto& a, const AlignedPhoto& b) {
    return a.photo.name == b.photo.name && a.placement == b.placement &&
           a.cam_from_enu.rotation.coeffs() == b.cam_from_enu.rotation.coeffs() &&
           a.cam_from_enu.translation == b.cam_from_enu.translation && a.intrinsics == b.intrinsics &&
           a.error_radius_m == b.error_radius_m;
  };
  const std::vector<AlignedPhoto>& photos = run.aligned.photos;
  if (!std::equal(photos.begin(), photos.end(), alone->aligned.photos.begin(), alone->aligned.photos.end(),
                  is_same) ||
      run.aligned.tie_points_in_enu != alone->aligned.tie_points_in_enu ||
      run.surface.Heights() != alone->surface.Heights()) {
    judged.faults.push_back("one thread gives another result");
  }
}

void PrintFates(const Lies& lies, const Run& run) {
  const auto print = [&](const char* lie, const std::set<std::string>& names) {
    for (const std::string& name : names) {
      std::string fate = "not in the result";
      for (const AlignedPhoto& photo : run.aligned.photos) {
        if (photo.photo.name != name) continue;
        fate =
            fmt::format("{}: {}", PlacementName(photo.placement), flight::InOneLine(photo.placement_remarks));
      }
      for (const flight::LeftOutPhoto& out : run.aligned.left_out) {
        if (out.name == name) fate = "left out: " + flight::InWords(out.reason);
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

// One line of the table; whether everything held.
bool RunCase(const SimulatedCase& one, int seed, const Setup& setup) {
  Result<simulate::SimulatedFlight> truth =
      simulate::PlanSimulatedFlight(Options(one, seed, setup.photos, setup.width_px));
  if (!truth) return fmt::print(stderr, "{}\n", truth.error().message), false;
  const Lies lies = one.has_lies ? TellLies(*truth) : Lies{};
  const Result<Run> run = Align(*truth, lies, one.has_control, setup);
  if (!run) return fmt::print(stderr, "{}\n", run.error().message), false;
  Judgement judged =
      JudgeAlignment({&*truth, &lies, &run->posed, &run->aligned, &run->surface, &run->report}, one.demands);
  if (one.has_lies) JudgeTheRest(one, lies, setup, seed, *truth, judged);
  if (one.demands.is_same_on_one_thread) JudgeThreads(*run, *truth, setup, judged);
  const double gsd = truth->GsdM();
  fmt::print(
      "{:<12} {:>4} {:>4} {:>5.3f} {:>3}/{:<3} {:>3} {:>7.2f} {:>8.2f} {:>6.2f} {:>8.2f} {:>6.2f} {:>6} "
      "{:>5}/{:<5} "
      "{:>7.1f} {:>6.2f} {:>6.3f} {:>6}  {}\n",
      one.name, one.demands.show, seed, gsd, run->report.aligned, run->report.photos, run->report.components,
      judged.error.relative_ce90_m / gsd, judged.pose_error.relative_ce90_m / gsd,
      judged.error.absolute_ce90_m, judged.pose_error.absolute_ce90_m, judged.gnss.ce90_m,
      judged.worst_ratio > 0.0 ? fmt::format("{:.2f}", judged.worst_ratio) : "-", judged.false_pairs,
      judged.pairs, judged.worst_pair_px, run->report.residual_rms_px, run->cpu_s / run->report.photos,
      run->ground_model,
      !judged.faults.empty() ? "FAIL"
      : one.demands.show > 0 ? "PASS"
                             : "-");
  for (const ControlReport& point : run->report.control) {
    fmt::print("  {}: {} marks, off by {:.3f} {:.3f} {:.3f} m, {:.2f} px {}\n", point.name, point.sightings,
               point.miss_east_m, point.miss_north_m, point.miss_up_m, point.residual_px,
               point.reason ? flight::InWords(*point.reason) : "");
  }
  if (one.has_lies) {
    fmt::print("  {} of {} lies found\n", judged.lies_found, judged.lies_told);
    PrintFates(lies, *run);
  }
  for (const std::string& fault : judged.faults) fmt::print("  {}\n", fault);
  std::fflush(stdout);
  return judged.faults.empty() || one.demands.show == 0;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string wanted = argc > 1 ? argv[1] : "all";
  Setup setup;
  if (argc > 2) setup.seeds = std::atoi(argv[2]);
  if (argc > 3) setup.photos = std::atoi(argv[3]);
  if (argc > 4) setup.width_px = std::atoi(argv[4]);
  if (argc > 5) setup.folder = argv[5];
  if (argc > 6) setup.threads = std::atoi(argv[6]);
  fmt::print(
      "{:<12} {:>4} {:>4} {:>5} {:>7} {:>3} {:>7} {:>8} {:>6} {:>8} {:>6} {:>6} {:>11} {:>7} {:>6} {:>6} "
      "{:>6}\n",
      "case", "show", "seed", "gsd m", "aligned", "pcs", "rel GSD", "pose rel", "abs m", "pose abs", "gnss m",
      "worst", "false links", "link px", "rms px", "cpu/ph", "ground");
  std::map<int, std::pair<int, int>> held;  // by demand: how many held, of how many
  for (const SimulatedCase& one : SimulatedCases()) {
    if (wanted != "all" && wanted != one.name) continue;
    for (int seed = 1; seed <= setup.seeds; ++seed) {
      const bool holds = RunCase(one, seed, setup);
      held[one.demands.show].first += holds ? 1 : 0;
      ++held[one.demands.show].second;
    }
  }
  bool is_all_well = true;
  for (const auto& [show, of] : held) {
    if (show == 0) continue;
    fmt::print("show {}: {} ({} of {})\n", show, of.first == of.second ? "PASS" : "FAIL", of.first,
               of.second);
    is_all_well = is_all_well && of.first == of.second;
  }
  return is_all_well ? 0 : 1;
}
