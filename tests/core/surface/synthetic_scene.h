// SyntheticScene: sloping ground with boxes on it, photographed by pinhole cameras that look straight down,
// each ray followed to what it meets. Texture is noise of several sizes, fixed to the surfaces. Metres of
// enu. What Decode gives depends on the scene and the photo's pose alone; any thread.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/alignment/scene/aligned_flight.h"
#include "core/flight/photos/photo_source.h"
#include "core/geo/bounds.h"

namespace skyquilt::surface {

struct StandingBox {
  geo::Bounds2 outline;
  double top_z_m = 0.0;
};

class SyntheticScene final : public flight::PhotoSource {
 public:
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();  // of the ground, z = slope . (E, N)
  std::vector<StandingBox> boxes;
  geo::Bounds2 even;  // without texture, but for noise that each photo has of its own
  alignment::AlignedFlight flight;

  // Cameras at so many places east and north, about the origin, at height_m, turned a little each.
  void Photograph(int east, int north, double spacing_m, double height_m, int width_px, int height_px,
                  double focal_px);
  double HeightAt(const Eigen::Vector2d& east_north) const;
  Result<image::DecodedImage> Decode(const flight::Photo& photo, int denominator) const override;

 private:
  std::uint8_t Shown(const Eigen::Vector3d& center, const Eigen::Vector3d& ray, std::uint32_t salt) const;
};

}  // namespace skyquilt::surface
