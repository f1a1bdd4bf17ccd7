// Aligns the photos of a folder and prints what came of it: alignment_folder DIR [threads].
#include <nlohmann/json.hpp>
#include <string>

#include "core/alignment/align_by_pose.h"
#include "core/alignment/align_flight.h"
#include "core/flight/photos/photo_decoder.h"
#include "core/flight/remarks/remark_words.h"
#include "core/ground/model_ground.h"
#include "core/pipeline/report/report_codec.h"
#include "core/poses/estimate_poses.h"
#include "core/render/blocks/measure_seams.h"
#include "tests/bench/alignment/cpu_seconds.h"
#include "tests/bench/alignment/read_folder.h"

namespace {

template <typename Report>
std::string TextOf(const Report& report) {
  using Json = nlohmann::ordered_json;
  return skyquilt::pipeline::JsonOf<Json>(report).dump(2, ' ', false, Json::error_handler_t::replace);
}

}  // namespace

int main(int argc, char** argv) {
  using namespace skyquilt;
  if (argc < 2) {
    fmt::print(stderr, "usage: {} DIR [threads]\n", argv[0]);
    return 2;
  }
  SilentProgress progress;
  const flight::Flight read = ReadFolder(argv[1], progress);
  const Result<poses::PosedFlight> posed = poses::EstimatePoses(read, {});
  if (!posed) return fmt::print(stderr, "{}\n", posed.error().message), 1;
  alignment::AlignOptions options;
  if (argc > 2) options.threads = std::atoi(argv[2]);
  alignment::AlignReport report;
  const double cpu_before = CpuSeconds();
  const Result<alignment::AlignedFlight> aligned =
      alignment::AlignFlight(*posed, flight::FilePhotoSource(), options, report, progress);
  const double cpu_s = CpuSeconds() - cpu_before;
  if (!aligned) return fmt::print(stderr, "{}\n", aligned.error().message), 1;
  fmt::print("{}\n", TextOf(report));
  ground::ModelGroundReport ground_report;
  const ground::GroundSurface surface = ground::ModelGround(*aligned, ground_report);
  fmt::print("{}\n", TextOf(ground_report));
  const auto seams = [&](const alignment::AlignedFlight& flight, const ground::GroundSurface& on) {
    const flight::FilePhotoSource photos;
    render::PhotoCache cache(photos, std::int64_t{512} << 20);
    return TextOf(render::SeamPatches(flight, on, {}).Measure(cache, progress));
  };
  fmt::print("seams {}\n", seams(*aligned, surface));
  fmt::print("seams by pose alone {}\n", seams(alignment::AlignByPoseOnly(*posed),
                                               ground::GroundSurface::Plane(posed->ground_z_in_enu_m)));
  for (const std::string& warning : flight::InWords(aligned->warnings)) fmt::print("warning: {}\n", warning);
  fmt::print("cpu {:.2f} s, {:.3f} s a photo; {} of {} aligned; rms {:.2f} px; {} ground points\n", cpu_s,
             cpu_s / report.photos, report.aligned, report.photos, report.residual_rms_px,
             aligned->tie_points_in_enu.size());
  return 0;
}
