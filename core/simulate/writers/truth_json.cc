#include <nlohmann/json.hpp>

#include "core/base/text/json_io.h"
#include "core/camera/intrinsics.h"
#include "core/geo/tile_id.h"
#include "core/geo/web_mercator.h"
#include "core/simulate/simulate_flight.h"

namespace skyquilt::simulate {
namespace {

using nlohmann::ordered_json;

ordered_json Vector(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

ordered_json Lens(const camera::Intrinsics& lens) {
  ordered_json json;
  camera::VisitLensFields(lens, [&](const char* name, auto value) { json[name] = value; });
  return json;
}

const char* KindName(ObjectKind kind) {
  switch (kind) {
    case ObjectKind::kFlatHouse:
      return "flat_house";
    case ObjectKind::kGabledHouse:
      return "gabled_house";
    case ObjectKind::kWall:
      return "wall";
    case ObjectKind::kTree:
      return "tree";
  }
  return "";
}

// Heights are z of enu; corners and ridge are those of the roof.
ordered_json Object(const StandingObject& object, const geo::LocalFrame& frame) {
  const Eigen::Vector2d& middle = object.outline.center_in_enu;
  ordered_json json{{"kind", KindName(object.kind)},
                    {"center_in_enu", {middle.x(), middle.y()}},
                    {"ground_m", object.ground_m},
                    {"ridge_m", object.ridge_m}};
  if (object.kind == ObjectKind::kTree) {
    json["radius_m"] = object.outline.half_size_m.x();
    return json;
  }
  json["eave_m"] = object.EaveM();
  for (const Eigen::Vector3d& corner : object.Corners()) {
    const geo::Wgs84 at = frame.Wgs84FromEnu(corner);
    const Eigen::Vector2d in_merc = geo::MercFromLatLon({at.lat_deg, at.lon_deg});
    json["corners_in_enu"].push_back(Vector(corner));
    json["corners_in_merc"].push_back({in_merc.x(), in_merc.y()});
  }
  if (object.kind == ObjectKind::kGabledHouse) {
    const double half_m = object.outline.half_size_m.x();
    json["ridge_in_enu"] = {Vector(object.RoofPointAt({-half_m, 0.0})),
                            Vector(object.RoofPointAt({half_m, 0.0}))};
  }
  return json;
}

}  // namespace

std::string TruthJson(const SimulatedFlight& flight) {
  const geo::Wgs84& origin = flight.frame.origin();
  const geo::RasterFrame raster = flight.WorldRaster();
  ordered_json truth;
  truth["frame"] =
      "enu at origin (x east, y north, z up, metres); ground z = 0; cam: x right, y down, z forward; "
      "pixel (0,0) is the centre of the first pixel; heights over the WGS84 ellipsoid";
  truth["origin"] = {{"lat_deg", origin.lat_deg},
                     {"lon_deg", origin.lon_deg},
                     {"height_ellipsoid_m", origin.height_ellipsoid_m}};
  truth["gsd_m"] = flight.GsdM();
  truth["relief_m"] = flight.options.world.relief_m;
  truth["has_boxes"] = flight.options.world.has_boxes;
  truth["seed"] = flight.options.seed;
  truth["world"] = {{"file", flight.options.write_world ? ordered_json("world.tif") : ordered_json(nullptr)},
                    {"north_west_in_merc", {raster.north_west_in_merc.x(), raster.north_west_in_merc.y()}},
                    {"pixel_size_in_merc_m", raster.pixel_size_in_merc_m},
                    {"width_px", raster.width_px},
                    {"height_px", raster.height_px}};
  if (flight.options.write_surface) truth["surface"] = {{"file", "surface.tif"}};
  for (const StandingObject& object : flight.world.objects())
    truth["objects"].push_back(Object(object, flight.frame));
  truth["intrinsics"] = Lens(flight.options.intrinsics);
  truth["photos"] = ordered_json::array();
  for (const SimulatedPhoto& photo : flight.photos) {
    const Eigen::Vector3d center = photo.pose.cam_from_enu.TargetOriginInSource();
    const geo::Wgs84 at = flight.frame.Wgs84FromEnu(center);
    const Eigen::Quaterniond& q = photo.pose.cam_from_enu.rotation;
    const YawPitchRoll gimbal = GimbalOfCamFromEnu(q);
    truth["photos"].push_back({{"name", photo.photo.name},
                               {"t_s", photo.pose.t_s},
                               {"lat_deg", at.lat_deg},
                               {"lon_deg", at.lon_deg},
                               {"height_ellipsoid_m", at.height_ellipsoid_m},
                               {"camera_center_in_enu", Vector(center)},
                               {"cam_from_enu_wxyz", {q.w(), q.x(), q.y(), q.z()}},
                               {"gimbal_yaw_deg", geo::RadToDeg(gimbal.yaw_rad)},
                               {"gimbal_pitch_deg", geo::RadToDeg(gimbal.pitch_rad)},
                               {"gimbal_roll_deg", geo::RadToDeg(gimbal.roll_rad)},
                               {"velocity_in_enu_mps", Vector(photo.pose.velocity_in_enu_mps)},
                               {"line", photo.pose.line}});
  }
  for (const RigBand& band : flight.rig) {
    const Eigen::Vector4d& of_color = band.reflectance_of_color;
    truth["bands"].push_back({{"name", band.name},
                              {"wavelength_nm", band.wavelength_nm},
                              {"reflectance_at_black", of_color[0]},
                              {"reflectance_of_red_green_blue", {of_color[1], of_color[2], of_color[3]}},
                              {"intrinsics", Lens(band.lens)}});
  }
  return JsonText(truth, 1) + "\n";
}

}  // namespace skyquilt::simulate
