#include "server/comparison/truth_error.h"

#include <algorithm>
#include <complex>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "core/alignment/matching/verified_pair.h"
#include "core/alignment/scene/matches.h"
#include "core/base/percentile.h"
#include "core/camera/lens_fields.h"
#include "core/simulate/world/world.h"

namespace skyquilt::server {
namespace {

using Complex = std::complex<double>;
using Value = nlohmann::json;

constexpr int kPixelsAcross = 5;
constexpr double kFarthestM = 5000.0;

struct Truth {
  geo::LocalFrame frame{geo::Wgs84{}};
  camera::Intrinsics lens;
  simulate::World ground{simulate::WorldOptions{}};
  std::map<std::string, geo::Rigid3, std::less<>> cam_from_enu;
};

Truth Parse(std::string_view text) {
  const Value json = Value::parse(text);
  Truth truth;
  const Value& origin = json.at("origin");
  truth.frame =
      geo::LocalFrame({origin.at("lat_deg"), origin.at("lon_deg"), origin.at("height_ellipsoid_m")});
  const Value& lens = json.at("intrinsics");
  camera::VisitLensFields(truth.lens, [&](const char* name, auto& value) { lens.at(name).get_to(value); });
  simulate::WorldOptions terrain;
  terrain.seed = json.at("seed");
  terrain.relief_m = json.at("relief_m");
  truth.ground = simulate::World(terrain);
  for (const Value& photo : json.at("photos")) {
    const Value& q = photo.at("cam_from_enu_wxyz");
    const Value& c = photo.at("camera_center_in_enu");
    const Eigen::Quaterniond rotation(q.at(0), q.at(1), q.at(2), q.at(3));
    const Eigen::Vector3d center(c.at(0).get<double>(), c.at(1).get<double>(), c.at(2).get<double>());
    truth.cam_from_enu[photo.at("name")] =
        geo::Rigid3::FromRotationAndTargetOrigin(rotation.normalized(), center);
  }
  return truth;
}

}  // namespace

Result<TruthError> MeasureTruthError(const pipeline::LocatedMap& map, std::string_view truth_json) {
  Truth truth;
  try {
    truth = Parse(truth_json);
  } catch (const Value::exception& broken) {
    return Error{ErrorCode::kCorrupt,
                 "The file truth/poses.json beside the photos is not one that \"skyquilt simulate\" writes.",
                 broken.what()};
  }
  TruthError error;
  error.photos_true = static_cast<int>(truth.cam_from_enu.size());
  std::vector<std::pair<Complex, Complex>> places;
  std::vector<double> absolute;
  for (const pipeline::LocatedCamera& camera : map.cameras) {
    const auto real = truth.cam_from_enu.find(camera.name);
    if (real == truth.cam_from_enu.end()) continue;
    ++error.photos;
    std::vector<double> of_photo;
    for (int row = 0; row < kPixelsAcross; ++row) {
      for (int column = 0; column < kPixelsAcross; ++column) {
        const Eigen::Vector2d pixel((column + 0.5) / kPixelsAcross * truth.lens.width_px - 0.5,
                                    (row + 0.5) / kPixelsAcross * truth.lens.height_px - 0.5);
        const Result<pipeline::GroundPoint> shown = pipeline::GroundAtPixel(map, camera.name, pixel);
        if (!shown) continue;
        const auto hit = truth.ground.CastRay(
            real->second.TargetOriginInSource(),
            (real->second.rotation.conjugate() * truth.lens.Unproject(pixel)).normalized(), kFarthestM);
        if (!hit) continue;
        const Eigen::Vector3d place = truth.frame.EnuAtHeight(shown->position, hit->point_in_enu.z());
        places.emplace_back(Complex(place.x(), place.y()),
                            Complex(hit->point_in_enu.x(), hit->point_in_enu.y()));
        of_photo.push_back(std::abs(places.back().first - places.back().second));
      }
    }
    error.worst_photo_m = std::max(error.worst_photo_m, Percentile(of_photo, 0.5));
    absolute.insert(absolute.end(), of_photo.begin(), of_photo.end());
  }
  if (places.empty()) {
    return Error{ErrorCode::kUnprocessable, "The file truth/poses.json beside the photos names none of them.",
                 ""};
  }
  const alignment::GroundSimilarity best = alignment::FitSimilarity(places);
  std::vector<double> relative;
  for (const auto& [shown, real] : places) relative.push_back(std::abs(best * shown - real));
  error.absolute_ce90_m = Percentile(absolute, 0.9);
  error.relative_ce90_m = Percentile(relative, 0.9);
  return error;
}

}  // namespace skyquilt::server
