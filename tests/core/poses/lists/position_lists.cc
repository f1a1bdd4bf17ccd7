// Lists of positions: geo.txt of all systems, bare lists without a header, tables with one.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/geo/geoid.h"
#include "core/geo/local_frame.h"
#include "tests/core/poses/lists/generated_list.h"

namespace skyquilt::testing {
namespace {

// What is written at odds with its format only another source can tell: there the photos know where they
// were.
enum class Shape {
  kOfItsSystem,  // below the line that names it; the usual case, so it comes more often
  kOfItsSystem2,
  kOfItsSystem3,
  kBareDegrees,
  kDegreesBelowMetres,
  kOtherOrder,
  kMetresOfNoSystem,
  kCount
};

flight::Photo BarePhoto(std::size_t number) {
  flight::Photo photo;
  photo.name = fmt::format("DJI_{:04}.JPG", 101 + number);
  photo.camera_key = "one";
  photo.intrinsics = camera::Intrinsics::Centered(4000, 3000, 3665.0);
  photo.captured_at = flight::UtcTime(std::chrono::seconds(1'624'483'869 + 7 * static_cast<int>(number)));
  photo.captured_at_is_local = true;
  return photo;
}

// Heights as the list counts them; the names that a header has for them tell the unit.
struct HeightColumn {
  std::string name;
  bool is_feet = false;
};

HeightColumn ChooseHeightColumn(Dice& dice) {
  if (dice.OneIn(4)) return {dice.Of({"Altitude (ft)", "alt_ft", "altitude [feet]", "Height (ft)"}), true};
  return {dice.Of({"altitude", "Altitude (m)", "alt_m", "height", "Altitude", "elevation", "z"}), false};
}

std::string NameInList(const std::string& name, Dice& dice, bool may_lack_ending) {
  static const std::vector<std::string> folders = {"", "", "", "DCIM/100MEDIA/", "C:\\photos\\"};
  const std::string stem = name.substr(0, name.rfind('.'));
  if (may_lack_ending) return stem;
  return dice.Of(folders) + name;
}

}  // namespace

void FlyOver(const geo::LatLon& middle, bool with_positions, Dice& dice, GeneratedList& list) {
  constexpr int kLines = 3, kPerLine = 4;
  const double geoid_m = geo::GeoidHeightM(middle).value_or(0.0);
  const double ground_m = dice.Between(20.0, 900.0) + geoid_m;
  const geo::LocalFrame frame({middle.lat_deg, middle.lon_deg, ground_m});
  const double off_east_m = dice.Between(-2.0, 2.0), off_north_m = dice.Between(-2.0, 2.0);
  for (int line = 0; line < kLines; ++line) {
    for (int step = 0; step < kPerLine; ++step) {
      const double along_m = 20.0 * (line % 2 == 0 ? step : kPerLine - 1 - step);
      const Eigen::Vector3d enu(along_m - 30.0, 30.0 * line - 30.0, 60.0 + 15.0 * line);
      flight::Photo photo = BarePhoto(list.photos.size());
      list.truth.push_back({photo.name, frame.Wgs84FromEnu(enu), true});
      if (with_positions) {
        const geo::Wgs84 own = frame.Wgs84FromEnu(enu + Eigen::Vector3d(off_east_m, off_north_m, 1.0));
        photo.position.emplace();
        photo.position->position = {own.lat_deg, own.lon_deg};
        photo.position->height_amsl_m = own.height_ellipsoid_m - geoid_m;
        photo.position->source = "exif";
      }
      list.photos.push_back(photo);
    }
  }
}

void LoseRows(Dice& dice, GeneratedList& list) {
  if (!dice.OneIn(4)) return;
  const std::size_t lost = 1 + dice.Below(4);
  for (std::size_t k = 0; k < lost; ++k) list.truth[dice.Below(list.truth.size())].has_row = false;
  list.has_heights = false;
}

GeneratedList GeneratePositions(std::uint32_t seed) {
  Dice dice(seed);
  GeneratedList list;
  const auto shape = static_cast<Shape>(dice.Below(static_cast<std::size_t>(Shape::kCount)));
  const bool is_at_odds = shape >= Shape::kDegreesBelowMetres;
  const bool on_grid = shape == Shape::kDegreesBelowMetres || shape == Shape::kMetresOfNoSystem ||
                       (shape <= Shape::kOfItsSystem3 && dice.OneIn(2));
  const PlaceOnEarth place = on_grid ? AnywhereOnAGrid(dice) : AnywhereInDegrees(dice);
  const System& system = place.system;
  const bool with_positions = is_at_odds || dice.OneIn(2);
  FlyOver(place.middle, with_positions, dice, list);
  list.tolerance_m = 1.0 + system.datum_m;
  const bool names_system = shape == Shape::kOtherOrder
                                ? dice.OneIn(2)
                                : shape != Shape::kBareDegrees && shape != Shape::kMetresOfNoSystem;
  const std::string system_name = dice.Of(system.names);
  const bool in_degrees = system.is_degrees || shape == Shape::kDegreesBelowMetres;
  // ODM's list has east first, Pix4D's bare list latitude.
  bool latitude_first = shape == Shape::kBareDegrees || (shape == Shape::kOtherOrder && names_system);
  if (shape == Shape::kDegreesBelowMetres) latitude_first = dice.OneIn(2);
  const bool with_height = !dice.OneIn(4);
  list.has_heights = with_height && (system.is_metres || system.is_degrees);
  if (!is_at_odds && with_positions && dice.OneIn(6)) {
    list.is_of_another_flight = true;
    for (flight::Photo& photo : list.photos)
      photo.position->position.lat_deg += place.middle.lat_deg > 0 ? -0.6 : 0.6;
  }
  LoseRows(dice, list);
  // A bare list of degrees has the shape of Pix4D's: latitude first; that of ODM, with its system, east
  // first.
  WayToWrite way;
  way.separator = names_system ? dice.Of({" ", " ", "\t", ",", ";"})[0] : dice.Of({",", ",", ";", "\t"})[0];
  if (way.separator == ';' || way.separator == '\t') way.decimal_mark = dice.OneIn(3) ? ',' : '.';
  list.file_name = names_system ? dice.Of({"geo.txt", "geo.txt", "positions.txt", "ppk.csv"})
                                : dice.Of({"positions.csv", "geolocation.csv", "list.txt"});
  if (names_system) list.text += system_name + "\n";
  const bool with_angles = with_height && dice.OneIn(4);
  const bool with_blank_lines = dice.OneIn(5), without_endings = dice.OneIn(6);
  for (const TruePlace& truth : list.truth) {
    if (!truth.has_row) continue;
    const geo::LatLon at{truth.at.lat_deg, truth.at.lon_deg};
    const OnGrid on = in_degrees ? OnGrid{at.lon_deg, at.lat_deg} : InSystem(system, at);
    std::vector<std::string> cells = {NameInList(truth.name, dice, without_endings),
                                      Written(on.x, in_degrees ? 8 : 3, way),
                                      Written(on.y, in_degrees ? 8 : 3, way)};
    if (latitude_first) std::swap(cells[1], cells[2]);
    if (with_height) cells.push_back(Written(truth.at.height_ellipsoid_m, 3, way));
    if (with_angles)
      cells.insert(cells.end(), {Written(45.0, 1, way), Written(0.0, 1, way), Written(0.0, 1, way)});
    list.text += Row(cells, way);
    if (with_blank_lines) list.text += "\n";
  }
  list.causes = {system_name, system.code, "EPSG", "system", "degrees", "latitude", "line ", "km"};
  list.bytes = Encoded(list.text, dice);
  return list;
}

GeneratedList GenerateTable(std::uint32_t seed) {
  Dice dice(seed);
  GeneratedList list;
  const bool in_degrees = !dice.OneIn(8);
  const PlaceOnEarth place = in_degrees ? AnywhereInDegrees(dice) : AnywhereOnAGrid(dice);
  const System& system = place.system;
  // A table of eastings alone says nothing of its system; the photos' own positions do.
  FlyOver(place.middle, !in_degrees || dice.OneIn(2), dice, list);
  list.tolerance_m = 1.0 + system.datum_m;
  const WayToWrite way = ChooseWay(dice);
  const HeightColumn height = ChooseHeightColumn(dice);
  const auto form = static_cast<DegreeForm>(dice.Below(static_cast<std::size_t>(DegreeForm::kCount)));
  struct Column {
    std::string header;
    enum { kImage, kX, kY, kHeight, kFiller } what;
  };
  std::vector<Column> columns = {
      {dice.Of({"image", "Image", "filename", "File Name", "photo", "SourceFile", "imagename", "Image Name"}),
       Column::kImage},
      {in_degrees ? dice.Of({"longitude", "Longitude", "lon", "Longitude (deg)", "lon_deg", "GPSLongitude",
                             "long", "Lon [deg]"})
                  : dice.Of({"easting", "Easting", "E", "East (m)", "x"}),
       Column::kX},
      {in_degrees ? dice.Of({"latitude", "Latitude", "lat", "Latitude (deg)", "lat_deg", "GPSLatitude", "lat",
                             "Lat [deg]"})
                  : dice.Of({"northing", "Northing", "N", "North (m)", "y"}),
       Column::kY}};
  list.has_heights = !dice.OneIn(4);
  if (list.has_heights) columns.push_back({height.name, Column::kHeight});
  if (dice.OneIn(3))
    columns.push_back({dice.Of({"comment", "remark", "battery", "Quality"}), Column::kFiller});
  dice.Shuffle(columns);
  if (dice.OneIn(3))
    std::stable_partition(columns.begin(), columns.end(),
                          [](const Column& c) { return c.what == Column::kImage; });
  LoseRows(dice, list);
  // In a grid of feet a height without a unit may be either.
  if (!in_degrees && !system.is_metres) list.has_heights = false;
  list.file_name = dice.Of({"positions.csv", "images.csv", "photos.txt", "geotags.csv", "export.tsv"});
  std::vector<std::string> headers;
  for (const Column& column : columns) headers.push_back(column.header);
  if (!in_degrees && dice.OneIn(2)) list.text += "# " + system.code + "\n";
  if (dice.OneIn(8)) list.text += fmt::format("sep={}\n", way.separator);
  list.text += Row(headers, way);
  const bool without_endings = dice.OneIn(6);
  for (const TruePlace& truth : list.truth) {
    if (!truth.has_row) continue;
    const OnGrid on = InSystem(system, {truth.at.lat_deg, truth.at.lon_deg});
    const double height_m = truth.at.height_ellipsoid_m;
    std::vector<std::string> cells;
    for (const Column& column : columns) {
      if (column.what == Column::kImage) cells.push_back(NameInList(truth.name, dice, without_endings));
      if (column.what == Column::kX)
        cells.push_back(in_degrees ? WrittenDegrees(on.x, false, form, way) : Written(on.x, 3, way));
      if (column.what == Column::kY)
        cells.push_back(in_degrees ? WrittenDegrees(on.y, true, form, way) : Written(on.y, 3, way));
      if (column.what == Column::kHeight)
        cells.push_back(Written(height.is_feet ? height_m / kMetresPerFoot : height_m, 2, way));
      if (column.what == Column::kFiller) cells.push_back(dice.Of({"", "ok", "7"}));
    }
    list.text += Row(cells, way);
  }
  for (const Column& column : columns) {
    // One letter stands in any sentence, and so does the word for a photo.
    if (column.what != Column::kImage && column.header.size() > 2) list.causes.push_back(column.header);
  }
  list.causes.insert(list.causes.end(), {"EPSG", "system", "line ", "column"});
  list.bytes = Encoded(list.text, dice);
  return list;
}

}  // namespace skyquilt::testing
