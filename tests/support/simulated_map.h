// SimulatedMap: a simulated flight with exactly known poses, up to where its map can be rendered; and the
// truth of what stands or moves on its ground. For tests and benchmarks of the renderer.
#pragma once

#include <map>
#include <memory>
#include <vector>

#include "core/alignment/scene/aligned_flight.h"
#include "core/ground/ground_surface.h"
#include "core/render/exposure/exposure.h"
#include "core/render/mosaic_plan.h"
#include "core/render/plan_mosaic.h"
#include "core/render/render_tiles.h"
#include "core/render/seams/seam_map.h"
#include "core/render/thumbnail.h"
#include "core/simulate/simulate_flight.h"

namespace skyquilt::test {

// A flat painted car that drives along a straight line at constant speed.
struct Car {
  Eigen::Vector2d start_in_enu = Eigen::Vector2d::Zero();
  Eigen::Vector2d velocity_mps = Eigen::Vector2d::Zero();
  std::array<std::uint8_t, 3> rgb{200, 30, 30};

  Eigen::Vector2d PlaceAt(double t_s, const Eigen::Vector2d& in_car_m) const;
};

inline constexpr double kCarLengthM = 4.5, kCarWidthM = 1.8;

// A picture at 1 / denominator of its size, each pixel the mean of its area.
image::DecodedImage AtSize(const image::DecodedImage& whole, int denominator);

// The photos, rendered once and kept, with the cars painted in.
class KeptPhotos final : public flight::PhotoSource {
 public:
  KeptPhotos(const simulate::SimulatedFlight& flight, const std::vector<Car>& cars);
  Result<image::DecodedImage> Decode(const flight::Photo& photo, int denominator) const override;

 private:
  std::map<std::string, image::DecodedImage> images_;
};

struct SimulatedMap {
  simulate::SimulatedFlight truth;
  std::vector<Car> cars;
  std::unique_ptr<KeptPhotos> photos;
  alignment::AlignedFlight flight;
  ground::GroundSurface ground = ground::GroundSurface::Plane(0.0);
  render::MosaicPlan plan;
  std::vector<render::Thumbnail> thumbnails;
  render::ExposureModel exposure;

  render::SeamMap Seams(const render::SeamOptions& options) const;
};

// A flight of pictures small enough that hundreds are rendered in a test.
simulate::SimulateOptions SmallPhotos(int photos);

SimulatedMap MakeSimulatedMap(const simulate::SimulateOptions& options, const render::PlanOptions& plan = {},
                              int cars = 0);

// The map as tiles in memory.
class MemorySink;
void RenderMap(const SimulatedMap& map, const render::SeamMap& seams, int threads, MemorySink& sink);

// How things that lean or move come out: each is whole, gone, or broken (shown twice or in part).
struct ObjectCount {
  int objects = 0;
  int twice = 0;
  int in_part = 0;
  double worst_share =
      0.0;  // of the most broken object: its parts shown twice, or those of the smaller piece
  Eigen::Vector2d worst_in_enu = Eigen::Vector2d::Zero();  // where the map shows some of it
  double BrokenShare() const { return objects == 0 ? 0.0 : static_cast<double>(twice + in_part) / objects; }
};
ObjectCount CountCars(const SimulatedMap& map, const render::SeamMap& seams);
ObjectCount CountRoofs(const SimulatedMap& map, const render::SeamMap& seams);

}  // namespace skyquilt::test
