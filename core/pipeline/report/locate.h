// Locate: which photos see a point of the ground, and where; and where a pixel of a photo lies. From the
// exact cameras and ground that a finished map was rendered with, kept beside it as locate.json. Values; any
// thread. Errors: kNotFound (no such photo), kUnprocessable (the pixel shows no ground), kCorrupt (the file).
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/alignment/scene/aligned_flight.h"
#include "core/base/result.h"
#include "core/geo/lat_lon.h"
#include "core/geo/local_frame.h"
#include "core/ground/ground_surface.h"

namespace skyquilt::pipeline {

struct LocatedCamera {
  std::string name;
  camera::Intrinsics intrinsics;
  geo::Rigid3 cam_from_enu;  // of the middle row
  camera::RowMotion readout_motion;
  alignment::Placement placement = alignment::Placement::kPoseOnly;
  std::optional<double> error_radius_m;  // nothing: nothing supports the place of the map it lies in
  std::optional<double> sharpness;       // as AlignedPhoto has it
};

struct LocatedMap {
  geo::LocalFrame frame{geo::Wgs84{}};
  double raised_m = 0.0;  // added to heights that are told: from the records' zero to that of a survey
  ground::GroundSurface ground = ground::GroundSurface::Plane(0.0);
  std::vector<LocatedCamera> cameras;
};

// Numbers are written so that they are read again exactly. `raised_m`: as LocatedMap has it.
// `known`: of which photos it is said how far off they are.
std::string LocateJson(const alignment::AlignedFlight& flight, const ground::GroundSurface& ground,
                       double raised_m = 0.0, alignment::ErrorsKnown known = alignment::ErrorsKnown::kOfAll);
Result<LocatedMap> ParseLocateJson(std::string_view text);

struct GroundPoint {
  geo::LatLon position;
  std::optional<double> sigma_m;  // of the camera's placement, seen under this ray's angle
};
// Where the ray through a pixel (the centre of the first is (0,0)) first meets the ground.
Result<GroundPoint> GroundAtPixel(const LocatedMap& map, std::string_view photo,
                                  const Eigen::Vector2d& pixel_in_image);

// The ground straight below or above a position, as the map was rendered; its height counts as the survey's
// do where surveyed points place the map.
geo::Wgs84 GroundAt(const LocatedMap& map, const geo::LatLon& position);

struct Sighting {
  std::string photo;
  Eigen::Vector2d pixel_in_image = Eigen::Vector2d::Zero();
  double off_nadir_rad = 0.0;  // between the view and the vertical
  alignment::Placement placement = alignment::Placement::kPoseOnly;
  std::optional<double> sigma_m;
  std::optional<double> sharpness;
  // The share of the fine detail that a sharp photo from straight above shows of the place:
  // min(1, sharpness / 0.8) * cos^2(off_nadir), a photo of unknown sharpness counting as sharp. Photos
  // without fault differ in sharpness by a fifth; seen from aslant, ground is foreshortened by one cosine
  // and, at the same height, further away by another.
  double quality = 0.0;
};
// The photos that have the point in their image, those of the best quality first.
std::vector<Sighting> PhotosAtPoint(const LocatedMap& map, const geo::LatLon& position);

}  // namespace skyquilt::pipeline
