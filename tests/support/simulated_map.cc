#include "tests/support/simulated_map.h"

#include <cmath>
#include <functional>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "core/base/parallel_for.h"
#include "core/camera/intrinsics.h"
#include "core/geo/web_mercator.h"
#include "core/render/exposure/estimate_exposure.h"
#include "core/simulate/world/parcels.h"
#include "tests/support/memory_sink.h"
#include "tests/support/rendered_once.h"

namespace skyquilt::test {
namespace {

constexpr int kSubPixels = 4;  // cars are painted with bits of a pixel

void PaintCar(const simulate::SimulatedFlight& flight, std::size_t index, const Car& car,
              image::DecodedImage& image) {
  const simulate::SimulatedPhoto& photo = flight.photos[index];
  std::vector<cv::Point> outline;
  for (const auto& [along, across] : {std::pair{-1.0, -1.0}, {1.0, -1.0}, {1.0, 1.0}, {-1.0, 1.0}}) {
    const Eigen::Vector2d place =
        car.PlaceAt(photo.pose.t_s, {0.5 * kCarLengthM * along, 0.5 * kCarWidthM * across});
    const camera::Intrinsics& lens = flight.options.intrinsics;
    const auto pixel = lens.Project(photo.pose.cam_from_enu * Eigen::Vector3d(place.x(), place.y(), 0.0));
    if (!pixel || !lens.IsInImage(*pixel)) return;
    outline.emplace_back(cvRound(pixel->x() * (1 << kSubPixels)), cvRound(pixel->y() * (1 << kSubPixels)));
  }
  cv::Mat rgb(image.height_px, image.width_px, CV_8UC3, image.rgb.data());
  cv::fillConvexPoly(rgb, outline, cv::Scalar(car.rgb[0], car.rgb[1], car.rgb[2]), cv::LINE_AA, kSubPixels);
}

std::vector<Car> MakeCars(const simulate::SimulatedFlight& flight, int count) {
  geo::Bounds2 bounds;
  for (const auto& photo : flight.photos)
    bounds.Include(Eigen::Vector2d(photo.pose.cam_from_enu.TargetOriginInSource().head<2>()));
  std::vector<Car> cars;
  for (int i = 0; i < count; ++i) {
    // Spread evenly (a Halton sequence), each with its own course; speeds of town traffic, some standing.
    const auto halton = [](int n, int base) {
      double value = 0.0;
      for (double f = 1.0 / base; n > 0; n /= base, f /= base) value += f * (n % base);
      return value;
    };
    Car car;
    const double course = 2.0 * geo::kPi * halton(i + 1, 5);
    const double middle_t = 0.5 * flight.photos.back().pose.t_s;
    const double speed = 0.25 * (i % 4);
    car.velocity_mps = speed * Eigen::Vector2d(std::cos(course), std::sin(course));
    if (speed == 0.0) car.velocity_mps = 1e-6 * Eigen::Vector2d(std::cos(course), std::sin(course));
    const Eigen::Vector2d middle{bounds.min.x() + bounds.Width() * halton(i + 1, 2),
                                 bounds.min.y() + bounds.Height() * halton(i + 1, 3)};
    car.start_in_enu = middle - middle_t * car.velocity_mps;
    constexpr std::array<std::array<std::uint8_t, 3>, 4> kPaints{
        {{190, 30, 30}, {235, 235, 235}, {30, 30, 40}, {40, 70, 180}}};
    car.rgb = kPaints[static_cast<std::size_t>(i % 4)];
    cars.push_back(car);
  }
  return cars;
}

std::int32_t OwnerAt(const SimulatedMap& map, const render::SeamMap& seams,
                     const Eigen::Vector2d& east_north) {
  const geo::Wgs84 wgs84 = map.flight.frame.Wgs84FromEnu({east_north.x(), east_north.y(), 0.0});
  const Eigen::Vector2d merc = geo::MercFromLatLon({wgs84.lat_deg, wgs84.lon_deg});
  const Eigen::Vector2d corner = seams.grid.CellInMerc(0, 0);
  const double cell_m = seams.grid.CellInMercM();
  return seams.labels.At(static_cast<int>(std::lround((merc.x() - corner.x()) / cell_m)),
                         static_cast<int>(std::lround((corner.y() - merc.y()) / cell_m)));
}

// An object is a set of parts; `place` says where a photo shows a part on the map.
void CountObject(const SimulatedMap& map, const render::SeamMap& seams, int parts,
                 const std::function<Eigen::Vector2d(int part, std::size_t photo)>& place,
                 ObjectCount& count) {
  constexpr double kTolerated = 0.2;
  int shown = 0, often = 0;
  Eigen::Vector2d seen_in_enu = Eigen::Vector2d::Zero();
  for (int part = 0; part < parts; ++part) {
    int times = 0;
    for (std::size_t photo = 0; photo < map.flight.photos.size(); ++photo) {
      const Eigen::Vector2d at = place(part, photo);
      if (OwnerAt(map, seams, at) != static_cast<std::int32_t>(photo)) continue;
      ++times;
      seen_in_enu = at;
    }
    shown += times > 0 ? 1 : 0;
    often += times > 1 ? 1 : 0;
  }
  ++count.objects;
  const double share = static_cast<double>(std::max(often, std::min(shown, parts - shown))) / parts;
  if (share > count.worst_share) count.worst_share = share, count.worst_in_enu = seen_in_enu;
  if (often > kTolerated * parts) {
    ++count.twice;
  } else if (shown > kTolerated * parts && shown < (1.0 - kTolerated) * parts) {
    ++count.in_part;
  }
}

}  // namespace

Eigen::Vector2d Car::PlaceAt(double t_s, const Eigen::Vector2d& in_car_m) const {
  const Eigen::Vector2d ahead = velocity_mps.normalized();
  return start_in_enu + t_s * velocity_mps + in_car_m.x() * ahead +
         in_car_m.y() * Eigen::Vector2d(-ahead.y(), ahead.x());
}

KeptPhotos::KeptPhotos(const simulate::SimulatedFlight& flight, const std::vector<Car>& cars) {
  std::vector<image::DecodedImage> made(flight.photos.size());
  ParallelFor(made.size(), 0, [&](std::size_t i) {
    made[i] = RenderedOnce(flight, i);
    for (const Car& car : cars) PaintCar(flight, i, car, made[i]);
  });
  for (std::size_t i = 0; i < made.size(); ++i) images_[flight.photos[i].photo.name] = std::move(made[i]);
}

image::DecodedImage AtSize(const image::DecodedImage& whole, int denominator) {
  if (denominator == 1) return whole;
  const cv::Mat in(whole.height_px, whole.width_px, CV_8UC3, const_cast<std::uint8_t*>(whole.rgb.data()));
  image::DecodedImage small{(whole.width_px + denominator - 1) / denominator,
                            (whole.height_px + denominator - 1) / denominator,
                            {}};
  small.rgb.resize(static_cast<std::size_t>(small.width_px) * small.height_px * 3);
  cv::Mat out(small.height_px, small.width_px, CV_8UC3, small.rgb.data());
  cv::resize(in, out, out.size(), 0, 0, cv::INTER_AREA);
  return small;
}

Result<image::DecodedImage> KeptPhotos::Decode(const flight::Photo& photo, int denominator) const {
  return AtSize(images_.at(photo.name), denominator);
}

render::SeamMap SimulatedMap::Seams(const render::SeamOptions& options) const {
  return render::BuildSeamMap(flight, ground, plan, exposure, thumbnails, options);
}

simulate::SimulateOptions SmallPhotos(int photos) {
  simulate::SimulateOptions options;
  options.intrinsics = camera::Intrinsics::Centered(480, 360, 360.0);
  options.trajectory.photos = photos;
  return options;
}

SimulatedMap MakeSimulatedMap(const simulate::SimulateOptions& options, const render::PlanOptions& plan,
                              int cars) {
  auto truth = simulate::PlanSimulatedFlight(options);
  if (!truth) throw std::runtime_error(truth.error().message);
  SimulatedMap map{*std::move(truth), {}, nullptr, {}, ground::GroundSurface::Plane(0.0), {}, {}, {}};
  map.cars = MakeCars(map.truth, cars);
  map.photos = std::make_unique<KeptPhotos>(map.truth, map.cars);
  map.flight.frame = map.truth.frame;
  for (const simulate::SimulatedPhoto& photo : map.truth.photos) {
    alignment::AlignedPhoto aligned;
    aligned.photo = photo.photo;
    aligned.intrinsics = options.intrinsics;
    aligned.cam_from_enu = photo.pose.cam_from_enu;
    aligned.placement = alignment::Placement::kAligned;
    aligned.height_above_ground_m = photo.pose.cam_from_enu.TargetOriginInSource().z();
    map.flight.photos.push_back(std::move(aligned));
    map.thumbnails.push_back(*render::MakeThumbnail(*map.photos, photo.photo));
  }
  map.plan = *render::PlanMosaic(map.flight, map.ground, plan);
  map.exposure = render::EstimateExposure(map.flight, map.ground, map.thumbnails);
  return map;
}

void RenderMap(const SimulatedMap& map, const render::SeamMap& seams, int threads, MemorySink& sink) {
  render::PhotoCache cache(*map.photos, std::int64_t{256} << 20);
  SilentProgress progress;
  const render::RenderContext context{map.flight, map.ground, map.exposure, seams, map.plan, cache};
  const auto done =
      render::RenderTiles(context, {threads, {image::TileEncoding::kJpegPng, 95}}, sink, progress);
  if (!done) throw std::runtime_error(done.error().message);
}

ObjectCount CountCars(const SimulatedMap& map, const render::SeamMap& seams) {
  constexpr int kAlong = 9, kAcross = 4;
  ObjectCount count;
  for (const Car& car : map.cars) {
    CountObject(
        map, seams, kAlong * kAcross,
        [&](int part, std::size_t photo) {
          const Eigen::Vector2d in_car{kCarLengthM * ((part % kAlong + 0.5) / kAlong - 0.5),
                                       kCarWidthM * ((part / kAlong + 0.5) / kAcross - 0.5)};
          return car.PlaceAt(map.truth.photos[photo].pose.t_s, in_car);
        },
        count);
  }
  return count;
}

ObjectCount CountRoofs(const SimulatedMap& map, const render::SeamMap& seams) {
  constexpr int kSide = 8;
  ObjectCount count;
  const simulate::WorldOptions& world = map.truth.options.world;
  const simulate::Parcels parcels(world.seed, world.texture);
  geo::Bounds2 bounds;
  for (const auto& photo : map.truth.photos)
    bounds.Include(Eigen::Vector2d(photo.pose.cam_from_enu.TargetOriginInSource().head<2>()));
  const double reach = std::hypot(bounds.Width(), bounds.Height());
  const int cells = static_cast<int>(reach / simulate::kBuildingCellM) + 2;
  const Eigen::Vector2d middle =
      parcels.ToTurned(0.5 * (bounds.min.x() + bounds.max.x()), 0.5 * (bounds.min.y() + bounds.max.y()));
  const int middle_u = static_cast<int>(std::floor(middle.x() / simulate::kBuildingCellM));
  const int middle_v = static_cast<int>(std::floor(middle.y() / simulate::kBuildingCellM));
  for (int v = middle_v - cells; v <= middle_v + cells; ++v) {
    for (int u = middle_u - cells; u <= middle_u + cells; ++u) {
      const auto building = parcels.BuildingOfCell(u, v);
      if (!building) continue;
      const Eigen::Vector2d& c = building->center_in_enu;
      if (c.x() < bounds.min.x() || c.x() > bounds.max.x() || c.y() < bounds.min.y() ||
          c.y() > bounds.max.y())
        continue;
      CountObject(
          map, seams, kSide * kSide,
          [&](int part, std::size_t photo) {
            const Eigen::Vector2d axes{
                building->half_size_m.x() * (2.0 * (part % kSide + 0.5) / kSide - 1.0),
                building->half_size_m.y() * (2.0 * (part / kSide + 0.5) / kSide - 1.0)};
            const Eigen::Vector2d& a = building->axis_in_enu;
            const Eigen::Vector2d roof = c + axes.x() * a + axes.y() * Eigen::Vector2d(-a.y(), a.x());
            const Eigen::Vector3d camera = map.flight.photos[photo].cam_from_enu.TargetOriginInSource();
            // Seen from the camera the roof lies on the map where the ray goes on to the ground.
            return Eigen::Vector2d(camera.head<2>() + (roof - camera.head<2>()) *
                                                          (camera.z() / (camera.z() - building->height_m)));
          },
          count);
    }
  }
  return count;
}

}  // namespace skyquilt::test
