#include "core/geo/crs/reference_system.h"

#include <gtest/gtest.h>

namespace skyquilt::geo {
namespace {

TEST(ReferenceSystem, IsReadInTheFormsThatPeopleWrite) {
  for (const char* line :
       {"EPSG:32615", "epsg 32615", "EPSG: 32615", "# EPSG:32615", "\"EPSG:32615\"", "32615",
        "urn:ogc:def:crs:EPSG::32615", "EPSG:32615+5773", "EPSG:32615+EPSG:5773", "WGS84 UTM 15N",
        "wgs84 utm zone 15 north", "WGS 84 / UTM zone 15N", "UTM 15N", "WGS84_UTM_Zone_15N",
        "+proj=utm +zone=15 +datum=WGS84 +units=m +no_defs", "NAD83 / UTM zone 15N", "nad83 utm 15n"}) {
    const auto system = ReferenceSystem::Parse(line);
    ASSERT_TRUE(system.ok()) << line;
    const auto place = system->ToLatLon(576667.1, 5188164.6);
    ASSERT_TRUE(place) << line;
    EXPECT_NEAR(place->lat_deg, 46.84261, 2e-5) << line;
    EXPECT_NEAR(place->lon_deg, -91.99451, 2e-5) << line;
    EXPECT_FALSE(system->is_geographic()) << line;
  }
  for (const char* line : {"EPSG:4326", "WGS84", "WGS 84", "CRS84", "EPSG:4979"}) {
    const auto system = ReferenceSystem::Parse(line);
    ASSERT_TRUE(system.ok()) << line;
    EXPECT_TRUE(system->is_geographic()) << line;
    EXPECT_DOUBLE_EQ(system->ToLatLon(-91.99, 46.84)->lat_deg, 46.84) << line << ": longitude comes first";
  }
  for (const char* line : {"ETRS89 / UTM zone 32N", "etrs89 utm 32n", "CH1903+ / LV95", "WGS84 UTM 33S",
                           "British National Grid", "epsg:2180", "GDA94 / MGA zone 55"}) {
    EXPECT_TRUE(ReferenceSystem::Parse(line).ok()) << line;
  }
}

TEST(ReferenceSystem, RefusesWhatIsNoneAndStringsThatOpenFiles) {
  for (const char* line :
       {"", "hello", "EPSG:", "EPSG:999999999", "EPSG:5773", "EPSG:4978", "EPSG:32615+32615",
        "+proj=longlat +nadgrids=/etc/passwd", "+proj=pipeline", "WGS84 UTM 61N", "WGS84 UTM", "WGS84 UTM 15",
        "+proj=nonsense", "x y z im_x im_y image name", "no such system", "{\"type\": \"GeographicCRS\"}",
        "UTM 16N (ftUS)", "PROJCS[\"a\",EXTENSION[\"PROJ4\",\"+nadgrids=a\"]]"}) {
    EXPECT_FALSE(ReferenceSystem::Parse(line).ok()) << line;
  }
}

TEST(ReferenceSystem, KnowsItsUnitsAndItsArea) {
  const auto feet = ReferenceSystem::Parse("NAD83 / Minnesota North (ftUS)");
  ASSERT_TRUE(feet.ok());
  EXPECT_NEAR(feet->metres_per_height_unit(), 1200.0 / 3937.0, 1e-9);
  EXPECT_TRUE(feet->area().Contains({46.84, -91.99}, 0.0));
  EXPECT_FALSE(feet->area().Contains({46.84, 8.0}, 1.0));
  EXPECT_EQ(feet->definition(), "EPSG:26849");
  const auto metres_up = ReferenceSystem::Parse("EPSG:26849+5703");  // feet east and north, NAVD88 in metres
  ASSERT_TRUE(metres_up.ok());
  EXPECT_DOUBLE_EQ(metres_up->metres_per_height_unit(), 1.0);
  EXPECT_TRUE(metres_up->heights_are_above_sea());
  EXPECT_FALSE(feet->heights_are_above_sea());
  const AreaOfUse fiji{.west_deg = 176.0, .south_deg = -20.0, .east_deg = 182.0, .north_deg = -12.0};
  EXPECT_TRUE(fiji.Contains({-16.0, -179.0}, 0.0));
  EXPECT_FALSE(fiji.Contains({-16.0, -177.0}, 0.5));
}

TEST(ReferenceSystem, TakesNoOtherDatumForWgs84) {
  for (const char* line : {"UTM 15N NAD27", "UTM zone 15N / NAD27"}) {
    const auto system = ReferenceSystem::Parse(line);
    if (system) EXPECT_NE(system->definition(), "EPSG:32615") << line;
  }
  EXPECT_EQ(ReferenceSystem::Parse("UTM 15N WGS 84")->definition(), "EPSG:32615");
}

TEST(UtmCodeOf, CountsZonesFromTheDateLine) {
  EXPECT_EQ(UtmCodeOf({46.8, -92.0}), 32615);
  EXPECT_EQ(UtmCodeOf({-33.9, 151.2}), 32756);
  EXPECT_EQ(UtmCodeOf({0.0, 180.0}), 32601);
  EXPECT_EQ(UtmCodeOf({0.0, -180.0}), 32601);
  EXPECT_EQ(UtmCodeOf({60.0, 4.0}), 32632);   // Bergen
  EXPECT_EQ(UtmCodeOf({78.2, 15.6}), 32633);  // Longyearbyen
}

}  // namespace
}  // namespace skyquilt::geo
