// What stands above the rows of a list: systems and names of columns, in the words that tables use too.
#include "core/flight/logs/texts/list_rows.h"

#include <gtest/gtest.h>

#include "core/flight/logs/formats.h"

namespace skyquilt::flight {
namespace {

using Columns = std::vector<std::string_view>;

bool IsImageAndTwoNumbers(const Columns& cells) {
  return cells.size() >= 3 && LooksLikeImageName(cells[0]) && ParseListCoordinate(cells[1]) &&
         ParseListCoordinate(cells[2]);
}

TEST(OrderOfColumns, KnowsTheNamesThatTablesKnow) {
  for (const Columns& north_first :
       {Columns{"image", "Latitude (deg)", "Longitude (deg)"}, Columns{"bild", "Breite", "Länge"},
        Columns{"name", "Hochwert", "Rechtswert"}, Columns{"photo", "lat_deg", "lonDeg"},
        Columns{"nombre", "latitud", "longitud"}, Columns{"file", "N", "E"}}) {
    EXPECT_EQ(OrderOfColumns(north_first), NamedOrder::kNorthFirst) << north_first[1];
  }
  for (const Columns& east_first :
       {Columns{"image", "lng", "lat"}, Columns{"punkt", "Rechtswert", "Hochwert", "Höhe"},
        Columns{"name", "Easting (m)", "Northing (m)"}, Columns{"id", "GeoX", "GeoY"},
        Columns{"Longitude_WGS84", "Latitude_WGS84"}}) {
    EXPECT_EQ(OrderOfColumns(east_first), NamedOrder::kEastFirst) << east_first[1];
  }
}

TEST(OrderOfColumns, TellsNothingFromNamesThatSayNoOrder) {
  for (const Columns& open :
       {Columns{"image", "x", "y", "z"}, Columns{"WGS84", "UTM", "15N"}, Columns{"32N", "12E"},
        Columns{"image", "latitude"}, Columns{"heading", "speed"}, Columns{}}) {
    EXPECT_EQ(OrderOfColumns(open), std::nullopt);
  }
}

TEST(ReadListTop, KeepsSystemsAndNamesOfColumnsApart) {
  for (const std::string_view system : {"WGS84 UTM 32N", "ETRS89 / UTM zone 32N", "EPSG:25832+7837",
                                        "wgs84 utm zone 32 north", "+proj=utm +zone=32 +datum=WGS84"}) {
    const std::string text =
        std::string(system) + "\nbild rechtswert hochwert höhe\nDJI_1.JPG 400000 5200000 500\n";
    const auto top = ReadListTop(text, IsImageAndTwoNumbers);
    ASSERT_TRUE(top);
    EXPECT_EQ(top->system, system);
    ASSERT_EQ(top->columns.size(), 4u) << system;
    EXPECT_TRUE(top->skipped_lines.empty());
  }
  std::string long_line(200'000, 'n');
  for (std::size_t i = 1; i < long_line.size(); i += 2) long_line[i] = ' ';
  const std::string odd = long_line + "\nDJI_1.JPG 400000 5200000 500\n";
  const auto top = ReadListTop(odd, IsImageAndTwoNumbers);
  ASSERT_TRUE(top);
  EXPECT_TRUE(top->columns.empty()) << "nobody names columns so";
}

TEST(ParseGeoTxt, TakesTheOrderOfColumnsInOtherLanguages) {
  const std::string text = "bild breite länge höhe\nDJI_1.JPG 46.84 8.1 500\n";
  ASSERT_TRUE(LooksLikeGeoTxt(BytesOf(text)));
  const auto log = ParseGeoTxt("positionen.txt", BytesOf(text));
  ASSERT_TRUE(log.ok());
  ASSERT_EQ(log->events.size(), 1u);
  EXPECT_DOUBLE_EQ(log->events[0].written->x, 8.1);
  EXPECT_DOUBLE_EQ(log->events[0].written->y, 46.84);
  EXPECT_TRUE(log->written_order_is_named);
}

}  // namespace
}  // namespace skyquilt::flight
