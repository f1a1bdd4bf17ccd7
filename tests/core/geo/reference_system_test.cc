#include "core/geo/crs/reference_system.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/geo/crs/map_projection.h"
#include "core/geo/crs/zoned_easting.h"
#include "tests/support/value_of.h"

namespace skyquilt::geo {
namespace {

TEST(ReferenceSystem, IsReadInTheFormsThatPeopleWrite) {
  for (const char* line : {"EPSG:32615",
                           "epsg 32615",
                           "EPSG: 32615",
                           "# EPSG:32615",
                           "\"EPSG:32615\"",
                           "32615",
                           "urn:ogc:def:crs:EPSG::32615",
                           "urn:ogc:def:crs:EPSG:9.8.5:32615",
                           "EPSG-Code: 32615",
                           "https://www.opengis.net/def/crs/EPSG/0/32615",
                           "https://www.opengis.net/def/crs/EPSG/9.9.1/32615",
                           "https://epsg.io/32615",
                           "EPSG:32615+5773",
                           "EPSG:32615+EPSG:5773",
                           "urn:ogc:def:crs,crs:EPSG::32615,crs:EPSG::5773",
                           "WGS84 UTM 15N",
                           "wgs84 utm zone 15 north",
                           "WGS 84 / UTM zone 15N",
                           "UTM 15N",
                           "WGS84_UTM_Zone_15N",
                           "+proj=utm +zone=15 +datum=WGS84 +units=m +no_defs",
                           "NAD83 / UTM zone 15N",
                           "nad83 utm 15n"}) {
    const auto system = ReferenceSystem::Parse(line);
    ASSERT_TRUE(system.ok()) << line;
    const auto place = system->ToLatLon(576667.1, 5188164.6);
    ASSERT_TRUE(place) << line;
    EXPECT_NEAR(place->lat_deg, 46.84261, 2e-5) << line;
    EXPECT_NEAR(place->lon_deg, -91.99451, 2e-5) << line;
    EXPECT_FALSE(system->is_geographic()) << line;
  }
  for (const char* line :
       {"EPSG:4326", "WGS84", "WGS 84", "CRS84", "urn:ogc:def:crs:OGC:1.3:CRS84", "EPSG:4979"}) {
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

TEST(ReferenceSystem, ReadsZonesOfUtmWithTheBandOfMgrs) {
  struct Named {
    const char* line;
    const char* definition;
  };
  for (const Named& one :
       {Named{"33U", "EPSG:32633"}, Named{"UTM 33U", "EPSG:32633"}, Named{"WGS84 / UTM 33 U", "EPSG:32633"},
        Named{"33W", "EPSG:32633"}, Named{"UTM 37M", "EPSG:32737"}, Named{"UTM zone 23K", "EPSG:32723"},
        Named{"ETRS89 / UTM 32T", "EPSG:25832"}, Named{"33N", "EPSG:32633"},
        Named{"UTM 33S", "EPSG:32733"}}) {
    const auto system = ReferenceSystem::Parse(one.line);
    ASSERT_TRUE(system.ok()) << one.line;
    EXPECT_EQ(system->definition(), one.definition) << one.line;
  }
  for (const char* line : {"UTM 33 (m)", "UTM 33 W", "UTM 33E", "UTM 33I", "UTM 33Z", "UTM 61U", "61U", "33u",
                           "33S", "33 U", "033U", "33UU", "33"}) {
    EXPECT_FALSE(ReferenceSystem::Parse(line).ok()) << line;
  }
}

TEST(ReferenceSystem, RefusesWhatIsNoneAndStringsThatOpenFiles) {
  for (const char* line :
       {"", "hello", "EPSG:", "EPSG:999999999", "EPSG:5773", "EPSG:4978", "EPSG:32615+32615",
        "urn:ogc:def:crs,crs:EPSG::32615,crs:OTHER::5773", "+proj=longlat +nadgrids=/etc/passwd",
        "+proj=pipeline", "WGS84 UTM 61N", "WGS84 UTM", "WGS84 UTM 15", "+proj=nonsense",
        "x y z im_x im_y image name", "no such system", "{\"type\": \"GeographicCRS\"}", "UTM 16N (ftUS)",
        "PROJCS[\"a\",EXTENSION[\"PROJ4\",\"+nadgrids=a\"]]"}) {
    EXPECT_FALSE(ReferenceSystem::Parse(line).ok()) << line;
  }
}

TEST(ReferenceSystem, KnowsItsUnitsAndItsArea) {
  const auto feet = test::ValueOf(ReferenceSystem::Parse("NAD83 / Minnesota North (ftUS)"));
  EXPECT_NEAR(feet.metres_per_height_unit(), 1200.0 / 3937.0, 1e-9);
  EXPECT_TRUE(feet.area().Contains({46.84, -91.99}, 0.0));
  EXPECT_FALSE(feet.area().Contains({46.84, 8.0}, 1.0));
  EXPECT_EQ(feet.definition(), "EPSG:26849");
  const auto metres_up = ReferenceSystem::Parse("EPSG:26849+5703");  // feet east and north, NAVD88 in metres
  ASSERT_TRUE(metres_up.ok());
  EXPECT_DOUBLE_EQ(metres_up->metres_per_height_unit(), 1.0);
  EXPECT_TRUE(metres_up->heights_are_above_sea());
  EXPECT_FALSE(feet.heights_are_above_sea());
  for (const char* line : {"EPSG::26849,crs:EPSG::5703", "urn:ogc:def:crs,crs:EPSG::26849,crs:EPSG::5703",
                           "urn:ogc:def:crs,crs:EPSG:9.8.5:26849,crs:EPSG:9.8.5:5703",
                           "http://www.opengis.net/def/crs-compound?1=http://www.opengis.net/def/crs/EPSG/0/"
                           "26849&2=http://www.opengis.net/def/crs/EPSG/0/5703"}) {
    const auto compound = ReferenceSystem::Parse(line);
    ASSERT_TRUE(compound.ok()) << line;
    EXPECT_TRUE(compound->heights_are_above_sea()) << line;
  }
  const AreaOfUse fiji{.west_deg = 176.0, .south_deg = -20.0, .east_deg = 182.0, .north_deg = -12.0};
  EXPECT_TRUE(fiji.Contains({-16.0, -179.0}, 0.0));
  EXPECT_FALSE(fiji.Contains({-16.0, -177.0}, 0.5));
}

TEST(ReferenceSystem, TakesNoOtherDatumForWgs84) {
  for (const char* line : {"UTM 15N NAD27", "UTM zone 15N / NAD27"}) {
    const auto system = ReferenceSystem::Parse(line);
    if (system) {
      EXPECT_NE(system->definition(), "EPSG:32615") << line;
    }
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

TEST(MapProjection, UtmIsThatOfEpsgsGuidance) {
  // CN Tower (NGA's example of UTM): zone 17, 630084 m east, 4833438 m north.
  const auto zone = test::ValueOf(MapProjection::OfEpsg(32617));
  const auto place = test::ValueOf(zone.PlaceOf({.lat_deg = 43.642567, .lon_deg = -79.387139}));
  EXPECT_NEAR(place.x(), 630084.0, 1.0);
  EXPECT_NEAR(place.y(), 4833438.0, 1.0);
  EXPECT_FALSE(zone.is_north_first());
  EXPECT_FALSE(zone.is_geographic());
}

TEST(MapProjection, UtmWithoutTheDatabaseIsThatOfTheDatabase) {
  // EPSG:25832 is the same projection on ETRS89, which PROJ takes for WGS84.
  const auto own = MapProjection::OfEpsg(32632), other = MapProjection::OfEpsg(25832);
  ASSERT_TRUE(own && other);
  for (const LatLon position : {LatLon{47.1, 8.2}, LatLon{54.9, 6.01}, LatLon{38.0, 11.9}}) {
    const auto a = own->PlaceOf(position), b = other->PlaceOf(position);
    ASSERT_TRUE(a && b);
    EXPECT_LT((*a - *b).norm(), 1e-3);  // the ellipsoids differ by 0.1 mm
  }
}

TEST(MapProjection, SouthIsTenThousandKilometresNorth) {
  const auto north = MapProjection::OfEpsg(32656), south = MapProjection::OfEpsg(32756);
  ASSERT_TRUE(north && south);
  const LatLon sydney{.lat_deg = -33.8568, .lon_deg = 151.2153};
  EXPECT_NEAR(south->PlaceOf(sydney)->y() - north->PlaceOf(sydney)->y(), 1e7, 1e-6);
  EXPECT_NEAR(south->PlaceOf(sydney)->x(), north->PlaceOf(sydney)->x(), 1e-6);
}

TEST(MapProjection, ThereAndBackIsTheSamePlace) {
  struct Case {
    int code;
    LatLon position;
  };
  for (const Case& one :
       {Case{32632, {47.123456, 8.765432}}, Case{2056, {46.95, 7.45}}, Case{3035, {52.0, 10.5}},
        Case{27700, {51.5, -0.1}}, Case{4258, {48.0, 11.0}}, Case{3857, {48.0, 11.0}},
        Case{2263, {40.7, -74.0}}, Case{32661, {85.0, 20.0}}, Case{3413, {75.0, -40.0}}}) {
    const auto system = MapProjection::OfEpsg(one.code);
    ASSERT_TRUE(system) << one.code;
    const auto place = system->PlaceOf(one.position);
    ASSERT_TRUE(place) << one.code;
    const auto back = system->LatLonOf(*place);
    ASSERT_TRUE(back) << one.code;
    EXPECT_NEAR(back->lat_deg, one.position.lat_deg, 3e-8) << one.code;
    EXPECT_NEAR(back->lon_deg, one.position.lon_deg, 3e-8) << one.code;
  }
}

TEST(MapProjection, AxesAreOursAndTheAuthoritysOrderIsTold) {
  const auto etrs89 = MapProjection::OfEpsg(4258), laea = MapProjection::OfEpsg(3035),
             swiss = MapProjection::OfEpsg(2056), gauss = MapProjection::OfEpsg(31467);
  ASSERT_TRUE(etrs89 && laea && swiss && gauss);
  EXPECT_TRUE(etrs89->is_north_first() && etrs89->is_geographic());
  EXPECT_TRUE(laea->is_north_first());
  EXPECT_FALSE(swiss->is_north_first());
  EXPECT_TRUE(gauss->is_north_first());
  const auto place =
      laea->PlaceOf({.lat_deg = 52.0, .lon_deg = 10.0});  // its origin: 4321000 east, 3210000 north
  EXPECT_NEAR(place->x(), 4321000.0, 1.0);
  EXPECT_NEAR(place->y(), 3210000.0, 1.0);
  EXPECT_NEAR(etrs89->PlaceOf({.lat_deg = 48.0, .lon_deg = 11.0})->x(), 11.0, 1e-6);
}

TEST(ReferenceSystem, TellsOlderDatumsFromFramesThatStandForWgs84) {
  struct Case {
    int code;
    LatLon position;
    bool is_inexact;
  };
  for (const Case& one : {Case{3003, {45.0, 9.0}, true}, Case{25832, {50.0, 9.0}, false},
                          Case{26915, {42.0, -93.0}, false}, Case{28355, {-37.0, 145.0}, false},
                          Case{2056, {47.0, 8.0}, false}, Case{32632, {47.0, 8.0}, false}}) {
    const auto place = MapProjection::OfEpsg(one.code)->PlaceOf(one.position);
    const auto system = ReferenceSystem::Parse("EPSG:" + std::to_string(one.code));
    ASSERT_TRUE(place && system) << one.code;
    const auto shift = system->InexactShiftAt(place->x(), place->y());
    EXPECT_EQ(shift.has_value(), one.is_inexact) << one.code;
    const std::optional<double> near_m = system->InexactShiftM(one.position);
    EXPECT_EQ(near_m.has_value(), one.is_inexact) << one.code;
    if (near_m && shift) {
      EXPECT_EQ(*near_m, shift->error_m) << one.code;
    }
  }
  // Better where the grid of the Ordnance Survey is installed, and said where it is not.
  const auto place = MapProjection::OfEpsg(27700)->PlaceOf({51.5, -0.1});
  const auto shift = ReferenceSystem::Parse("EPSG:27700")->InexactShiftAt(place->x(), place->y());
  if (shift) {
    EXPECT_TRUE(shift->lacks_grid && shift->error_m > 1.0);
  }
}

TEST(MapProjection, WhatCannotBeIsRefusedOrAbsent) {
  for (const int code : {1, 0, -5, 999999, 4979 /* three axes */, 4978 /* geocentric */, 5773 /* heights */,
                         7415 /* compound */, 32661 + 100000}) {
    EXPECT_FALSE(MapProjection::OfEpsg(code)) << code;
  }
  const auto zone = test::ValueOf(MapProjection::OfEpsg(32632));
  EXPECT_FALSE(zone.LatLonOf({1e12, 1e12}));
  EXPECT_FALSE(zone.LatLonOf({std::nan(""), 0.0}));
  EXPECT_FALSE(zone.PlaceOf({.lat_deg = std::nan(""), .lon_deg = 0.0}));
  // Beyond the pole a transverse Mercator goes on with the other side of the Earth.
  EXPECT_FALSE(test::ValueOf(MapProjection::OfEpsg(3035)).LatLonOf({4321000.0 + 3e7, 3210000.0}));
}

TEST(ReferenceSystem, KnowsNoPlaceOfAnOlderEllipsoidWithoutADatum) {
  const auto gauss =
      ReferenceSystem::Parse("+proj=tmerc +lat_0=0 +lon_0=9 +k=1 +x_0=3500000 +y_0=0 +ellps=bessel +units=m");
  const auto utm = ReferenceSystem::Parse("+proj=utm +zone=32 +ellps=GRS80 +units=m");
  ASSERT_TRUE(gauss && utm);
  const auto shift = gauss->InexactShiftAt(3'500'000.0, 5'200'000.0);
  ASSERT_TRUE(shift);
  EXPECT_GT(shift->error_m, 150.0);
  EXPECT_FALSE(shift->lacks_grid);
  EXPECT_EQ(gauss->InexactShiftM({.lat_deg = 46.94, .lon_deg = 9.0}), shift->error_m);
  EXPECT_FALSE(utm->InexactShiftAt(500'000.0, 5'200'000.0)) << "as all present frames";
}

// PROJ keeps what failed last, of whichever system, until somebody forgets it.
TEST(ReferenceSystem, AnswersAfterAnotherLackedAGrid) {
  const auto mine = ReferenceSystem::Parse("EPSG:25832"), other = ReferenceSystem::Parse("EPSG:27700");
  ASSERT_TRUE(mine && other);
  other->InexactShiftAt(530'000.0, 180'000.0);
  EXPECT_TRUE(mine->ToLatLon(500'000.0, 5'412'000.0));
  other->InexactShiftAt(530'000.0, 180'000.0);
  EXPECT_FALSE(mine->InexactShiftAt(500'000.0, 5'412'000.0));
  EXPECT_TRUE(mine->ToLatLon(500'000.0, 5'412'000.0));
}

// Eastings of eight digits that a system has of its own stay what they are.
TEST(EastingIn, LeavesOutTheZoneOfTheSystemAlone) {
  struct Written {
    const char* system;
    double x, y, counts;
  };
  for (const Written& row : {Written{"EPSG:25832", 32'521'000.0, 5'412'000.0, 521'000.0},
                             Written{"EPSG:32719", 19'346'000.0, 6'298'000.0, 346'000.0},
                             Written{"EPSG:25832", 33'421'000.0, 5'412'000.0, 33'421'000.0},
                             Written{"EPSG:25832", 521'000.0, 5'412'000.0, 521'000.0},
                             Written{"EPSG:4647", 32'521'000.0, 5'412'000.0, 32'521'000.0},
                             // Pulkovo 1942, GK zone 10; Finland, GK25; Virginia North, in US feet
                             Written{"EPSG:28410", 10'521'000.0, 5'412'000.0, 10'521'000.0},
                             Written{"EPSG:3879", 25'496'000.0, 6'673'000.0, 25'496'000.0},
                             Written{"EPSG:2283", 11'850'000.0, 6'950'000.0, 11'850'000.0}}) {
    const auto system = ReferenceSystem::Parse(row.system);
    ASSERT_TRUE(system.ok()) << row.system;
    EXPECT_EQ(EastingIn(*system, row.x, row.y), row.counts) << row.system;
  }
}

}  // namespace
}  // namespace skyquilt::geo
