// Surveyed points: the system in the first line in the ways people write it, columns as ODM has them.
#include <fmt/format.h>

#include "core/geo/local_frame.h"
#include "tests/core/poses/lists/generated_list.h"

namespace skyquilt::testing {

GeneratedList GenerateControl(std::uint32_t seed) {
  Dice dice(seed);
  GeneratedList list;
  const PlaceOnEarth place = dice.OneIn(3) ? AnywhereInDegrees(dice) : AnywhereOnAGrid(dice);
  const System& system = place.system;
  FlyOver(place.middle, true, dice, list);
  list.truth.clear();
  list.tolerance_m = 1.0 + system.datum_m;
  const geo::LocalFrame frame({place.middle.lat_deg, place.middle.lon_deg, 100.0});
  constexpr int kPoints = 5;
  for (int k = 0; k < kPoints; ++k) {
    const double east_m = dice.Between(-50.0, 50.0), north_m = dice.Between(-50.0, 50.0);
    const Eigen::Vector3d at(east_m, north_m, 0.0);
    list.truth.push_back({fmt::format("gcp{}", k + 1), frame.Wgs84FromEnu(at), true});
  }
  const bool lacks_system = dice.OneIn(8);
  const bool in_degrees = system.is_degrees || dice.OneIn(8);
  const std::string system_name = dice.Of(system.names);
  WayToWrite way;
  way.separator = dice.Of({" ", " ", "\t", "\t", ",", ";"})[0];
  if (way.separator == ';' || way.separator == '\t') way.decimal_mark = dice.OneIn(4) ? ',' : '.';
  list.file_name = dice.Of({"gcp_list.txt", "gcp_list.txt", "gcp.txt", "points.csv"});
  if (dice.OneIn(5)) list.text += "# surveyed with a rover\n";
  if (!lacks_system) list.text += system_name + "\n";
  if (dice.OneIn(3)) {
    list.text += Row({dice.Of({"x", "easting", "geo_x", "X"}), dice.Of({"y", "northing", "geo_y", "Y"}),
                      dice.Of({"z", "elevation", "geo_z", "Z"}), "im_x", "im_y",
                      dice.Of({"image", "image_name"}), dice.Of({"name", "gcp_name", "label"})},
                     way);
  }
  const bool with_blank_lines = dice.OneIn(5);
  for (const TruePlace& truth : list.truth) {
    const geo::LatLon at{truth.at.lat_deg, truth.at.lon_deg};
    const OnGrid on = in_degrees ? OnGrid{at.lon_deg, at.lat_deg} : InSystem(system, at);
    for (int sighting = 0; sighting < 2; ++sighting) {
      list.text +=
          Row({Written(on.x, in_degrees ? 9 : 3, way), Written(on.y, in_degrees ? 9 : 3, way),
               Written(truth.at.height_ellipsoid_m, 3, way), Written(dice.Between(100.0, 3900.0), 2, way),
               Written(dice.Between(100.0, 2900.0), 2, way), dice.Of(list.photos).name, truth.name},
              way);
    }
    if (with_blank_lines) list.text += "\n";
  }
  list.causes = {system_name, system.code, "EPSG", "system", "degrees", "line "};
  list.bytes = Encoded(list.text, dice);
  return list;
}

}  // namespace skyquilt::testing
