// How well surveyed points are met that were not told: each left out in turn, the flight aligned by the
// others, and its marks compared with the survey. alignment_control_loo DIR-OR-FILES...
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/alignment/align_flight.h"
#include "core/alignment/bundle/control_points.h"
#include "core/base/median.h"
#include "core/flight/photos/photo_decoder.h"
#include "core/flight/read_flight.h"
#include "core/flight/remarks/remark_words.h"
#include "core/pipeline/placing/control_points.h"
#include "core/poses/estimate_poses.h"
#include "core/poses/lists/compare_sources.h"

int main(int argc, char** argv) {
  using namespace skyquilt;
  SilentProgress progress;
  std::vector<std::filesystem::path> paths(argv + 1, argv + argc);
  const Result<std::vector<flight::InputFile>> files = flight::ListInputFiles(paths);
  if (!files) return fmt::print(stderr, "{}\n", files.error().message), 1;
  Result<flight::Flight> read = flight::ReadFlight(*files, 0, progress);
  if (!read) return fmt::print(stderr, "{}\n", read.error().message), 1;
  if (const Result<void> compared = poses::CompareSources(*read); !compared)
    return fmt::print(stderr, "{}\n", compared.error().message), 1;
  poses::EstimatePosesOptions pose_options;
  pose_options.keep_unplaced = true;
  const Result<poses::PosedFlight> posed = poses::EstimatePoses(*read, pose_options);
  if (!posed) return fmt::print(stderr, "{}\n", posed.error().message), 1;
  const std::vector<alignment::ControlPoint> control = pipeline::ControlPointsOf(read->gcp_lists);
  const flight::FilePhotoSource source;
  alignment::AlignOptions options;
  alignment::FoundFeatures features;
  std::vector<flight::Photo> photos = posed->unplaced;
  for (const poses::PosedPhoto& photo : posed->photos) photos.push_back(photo.photo);
  for (const flight::Photo& photo : photos) {
    Result<alignment::PhotoFeatures> found = alignment::ExtractFeatures(photo, source);
    if (found) features.emplace(photo.name, *std::move(found));
  }
  std::vector<double> misses;
  for (std::size_t left = 0; left < control.size(); ++left) {
    options.control = control;
    options.control.erase(options.control.begin() + static_cast<std::ptrdiff_t>(left));
    alignment::AlignReport report;
    const auto aligned = alignment::AlignFlight(*posed, source, options, report, progress, features);
    if (!aligned) return fmt::print(stderr, "{}\n", aligned.error().message), 1;
    std::vector<std::string> names;
    std::vector<alignment::View> views;
    alignment::PhotoSet tied;
    for (const alignment::AlignedPhoto& photo : aligned->photos) {
      names.push_back(photo.photo.name);
      views.push_back(
          {photo.intrinsics, photo.cam_from_enu, photo.height_above_ground_m, photo.readout_motion});
      tied.Append(photo.placement == alignment::Placement::kAligned);
    }
    alignment::ControlReport told;
    const auto track = alignment::MarkedPhotos(names, views, tied).TrackOf(control[left], told);
    if (!track) {
      fmt::print("{}: {} marks, {}\n", control[left].name, told.sightings,
                 told.reason ? flight::InWords(*told.reason) : "");
      continue;
    }
    const Eigen::Vector3d surveyed =
        aligned->frame.EnuFromWgs84({control[left].position.lat_deg, control[left].position.lon_deg,
                                     aligned->frame.origin().height_ellipsoid_m});
    const Eigen::Vector2d miss = (track->point_in_enu - surveyed).head<2>();
    misses.push_back(miss.norm());
    fmt::print("{}: {} marks, {:.3f} m ({:+.3f} {:+.3f}); {} of {} aligned, {:.2f} px\n", control[left].name,
               told.sightings, miss.norm(), miss.x(), miss.y(), report.aligned, report.photos,
               report.residual_rms_px);
  }
  if (misses.empty()) return 1;
  fmt::print("leave-one-out: median {:.3f} m, largest {:.3f} m of {} points\n", Median(misses),
             *std::max_element(misses.begin(), misses.end()), misses.size());
  return 0;
}
