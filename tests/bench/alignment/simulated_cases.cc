#include "tests/bench/alignment/simulated_cases.h"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "tests/bench/alignment/cpu_seconds.h"

namespace skyquilt::alignment {
namespace {

constexpr double kDeg = 3.14159265358979 / 180.0;

void MoveRecord(const simulate::SimulatedFlight& flight, simulate::SimulatedPhoto& photo,
                const Eigen::Vector3d& by_m) {
  const geo::Wgs84 moved =
      flight.frame.Wgs84FromEnu(flight.frame.EnuFromWgs84(*photo.recorded.position) + by_m);
  photo.photo.position->position = {moved.lat_deg, moved.lon_deg};
}

}  // namespace

const std::vector<SimulatedCase>& SimulatedCases() {
  using simulate::SimulateOptions;
  static const std::vector<SimulatedCase> cases = {
      {"flat", {.show = 1, .relative_gsds = 2.0}, false, false, [](SimulateOptions&) {}},
      {"relief8",
       {.show = 1, .relative_gsds = 5.0},
       false,
       false,
       [](SimulateOptions& o) { o.world.relief_m = 8.0; }},
      {"no_gimbal",
       {.show = 1, .relative_gsds = 3.0},
       false,
       false,
       [](SimulateOptions& o) {
         o.trajectory.max_tilt_rad = 12.0 * kDeg;
         o.trajectory.height_wander_m = 0.05 * o.trajectory.height_m;
       }},
      {"no_attitude",
       {.show = 1, .relative_gsds = 4.0},
       false,
       false,
       [](SimulateOptions& o) { o.noise = simulate::NoiseClass::kNoAttitude; }},
      {"rtk",
       {.show = 2, .relative_gsds = 2.0, .absolute_gsds = 2.0},
       false,
       false,
       [](SimulateOptions& o) { o.noise = simulate::NoiseClass::kRtk; }},
      {"control5",
       {.show = 2, .relative_gsds = 2.0, .absolute_gsds = 2.0},
       false,
       true,
       [](SimulateOptions&) {}},
      {"rows",
       {.show = 3, .improves_every_photo = true},
       false,
       false,
       [](SimulateOptions& o) { o.world.texture = simulate::TextureLevel::kRows; }},
      {"bare",
       {.show = 3, .improves_every_photo = true},
       false,
       false,
       [](SimulateOptions& o) { o.world.texture = simulate::TextureLevel::kBare; }},
      {"lies", {.show = 5, .relative_gsds = 2.0}, true, false, [](SimulateOptions&) {}},
      {"one_thread", {.show = 7, .is_same_on_one_thread = true}, false, false, [](SimulateOptions&) {}},
      {"boxes", {}, false, false, [](SimulateOptions& o) { o.world.has_boxes = true; }},
  };
  return cases;
}

std::set<std::string> Lies::All() const {
  std::set<std::string> all;
  for (const auto* kind : {&gnss, &yaw, &elsewhere, &duplicate, &blurred})
    all.insert(kind->begin(), kind->end());
  return all;
}

Lies TellLies(simulate::SimulatedFlight& flight) {
  Lies lies;
  const std::size_t count = flight.photos.size();
  std::size_t next = 1;
  const auto pick = [&](std::set<std::string>& kind) -> simulate::SimulatedPhoto& {
    simulate::SimulatedPhoto& photo = flight.photos[next % count];
    next += 3;  // spread, and by 60 photos never the same twice
    kind.insert(photo.photo.name);
    return photo;
  };
  for (int i = 0; i < 10; ++i) {
    const double angle = 0.7 * i;
    MoveRecord(flight, pick(lies.gnss), 50.0 * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.0));
  }
  for (int i = 0; i < 5; ++i) pick(lies.yaw).photo.attitude->yaw_rad += 90.0 * kDeg;
  pick(lies.elsewhere);
  MoveRecord(flight, pick(lies.elsewhere), {2500.0, -1800.0, 0.0});
  pick(lies.blurred).render.motion_in_enu_m = Eigen::Vector3d(2.5, 1.5, 0.0);
  const std::size_t twin = (next % count == 0 ? 1 : next % count);
  simulate::SimulatedPhoto copy = flight.photos[twin - 1];
  const std::string original = copy.photo.name;
  copy.photo.name = "COPY_" + original;
  lies.duplicate.insert(copy.photo.name);
  flight.photos.insert(flight.photos.begin() + static_cast<std::ptrdiff_t>(twin), copy);
  return lies;
}

RenderedSource::RenderedSource(const simulate::SimulatedFlight& flight, const Lies& lies, std::string folder)
    : source_(flight), elsewhere_(flight), lies_(lies), folder_(std::move(folder)) {
  simulate::WorldOptions other = flight.options.world;
  other.seed += 1000;
  elsewhere_.world = simulate::World(other);
  if (folder_.empty()) return;
  // One folder a flight: everything that decides its pictures.
  const simulate::SimulateOptions& o = flight.options;
  folder_ += fmt::format("/{}_{}_{}_{}_{:.0f}_{:.3f}_{:.1f}_{}", o.seed, flight.photos.size(),
                         o.intrinsics.width_px, static_cast<int>(o.world.texture), o.intrinsics.focal_x_px,
                         o.trajectory.max_tilt_rad, o.world.relief_m, o.world.has_boxes) +
             fmt::format("_{:.2f}", o.trajectory.height_wander_m);
  std::filesystem::create_directories(folder_);
}

Result<image::DecodedImage> RenderedSource::Render(const flight::Photo& photo, int denominator) const {
  if (!lies_.elsewhere.contains(photo.name)) return source_.Decode(photo, denominator);
  return simulate::SimulatedPhotoSource(elsewhere_).Decode(photo, denominator);
}

Result<image::DecodedImage> RenderedSource::Decode(const flight::Photo& photo, int denominator) const {
  const double before = ThreadCpuSeconds();
  const char* spoilt = lies_.elsewhere.contains(photo.name) ? ".elsewhere"
                       : lies_.blurred.contains(photo.name) ? ".blurred"
                                                            : "";
  const std::string path =
      folder_.empty() ? "" : fmt::format("{}/{}{}.{}.rgb", folder_, photo.name, spoilt, denominator);
  Result<image::DecodedImage> image = Error{ErrorCode::kNotFound, "not rendered yet", ""};
  if (std::ifstream file(path, std::ios::binary); !path.empty() && file) {
    image::DecodedImage kept;
    file.read(reinterpret_cast<char*>(&kept.width_px), sizeof kept.width_px);
    file.read(reinterpret_cast<char*>(&kept.height_px), sizeof kept.height_px);
    kept.rgb.resize(static_cast<std::size_t>(kept.width_px) * kept.height_px * 3);
    file.read(reinterpret_cast<char*>(kept.rgb.data()), static_cast<std::streamsize>(kept.rgb.size()));
    if (file) image = std::move(kept);
  }
  if (!image) {
    image = Render(photo, denominator);
    if (image && !path.empty()) {
      std::ofstream file(path, std::ios::binary);
      file.write(reinterpret_cast<const char*>(&image->width_px), sizeof image->width_px);
      file.write(reinterpret_cast<const char*>(&image->height_px), sizeof image->height_px);
      file.write(reinterpret_cast<const char*>(image->rgb.data()),
                 static_cast<std::streamsize>(image->rgb.size()));
    }
  }
  const std::lock_guard lock(mutex_);
  cpu_s_ += ThreadCpuSeconds() - before;
  return image;
}

}  // namespace skyquilt::alignment
