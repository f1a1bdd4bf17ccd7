#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/geo/web_mercator.h"
#include "core/simulate/simulate_flight.h"
#include "core/simulate/world/random.h"
#include "core/simulate/world/world.h"
#include "core/simulate/world/world_raster.h"
#include "tests/support/value_of.h"

namespace skyquilt::simulate {
namespace {

// 12 x 8 m, 7 m high, turned by 30 degrees.
StandingObject HouseAtTwenty(double fall_per_m) {
  StandingObject house;
  house.kind = fall_per_m > 0.0 ? ObjectKind::kGabledHouse : ObjectKind::kFlatHouse;
  house.outline.center_in_enu = {20.0, 10.0};
  house.outline.axis_in_enu = {std::cos(geo::DegToRad(30.0)), std::sin(geo::DegToRad(30.0))};
  house.outline.half_size_m = {6.0, 4.0};
  house.ground_m = 1.0;
  house.ridge_m = 8.0;
  house.fall_per_m = fall_per_m;
  return house;
}

WorldOptions Village(double relief_m) {
  WorldOptions options;
  options.seed = 3;
  options.relief_m = relief_m;
  options.objects = {12, 6, 30, 3.0, 12.0, {-60.0, -50.0}, {70.0, 60.0}};
  return options;
}

TEST(StandingObject, AFlatRoofIsMetAtItsHeight) {
  const StandingObject house = HouseAtTwenty(0.0);
  for (const Eigen::Vector2d& at : {Eigen::Vector2d(0, 0), Eigen::Vector2d(5.99, -3.99)}) {
    const Eigen::Vector3d roof = house.RoofPointAt(at);
    const auto hit = test::ValueOf(house.CastRay({roof.x(), roof.y(), 60.0}, {0.0, 0.0, -1.0}));
    EXPECT_NEAR(hit.distance_m, 52.0, 1e-9);
    EXPECT_FALSE(hit.is_side);
    EXPECT_NEAR(house.TopAt(roof.head<2>()).value(), 8.0, 1e-9);
  }
  const Eigen::Vector3d beside = house.RoofPointAt({6.01, 0.0});
  EXPECT_FALSE(house.CastRay({beside.x(), beside.y(), 60.0}, {0.0, 0.0, -1.0}).has_value());
  EXPECT_FALSE(house.TopAt(beside.head<2>()).has_value());
}

TEST(StandingObject, AFlatRayMeetsTheSideThatFacesIt) {
  const StandingObject house = HouseAtTwenty(0.0);
  const Eigen::Vector3d in_front = house.RoofPointAt({16.0, 0.0});
  const Eigen::Vector3d to_it = -Eigen::Vector3d(house.outline.axis_in_enu.x(), house.outline.axis_in_enu.y(),
                                                 0.1);  // 1 m down on the way
  const auto hit = test::ValueOf(house.CastRay({in_front.x(), in_front.y(), 7.0}, to_it.normalized()));
  EXPECT_TRUE(hit.is_side);
  EXPECT_NEAR(hit.distance_m, 10.0 * to_it.norm(), 1e-9);
  EXPECT_FALSE(house.CastRay({in_front.x(), in_front.y(), 10.5}, to_it.normalized()).has_value())
      << "over it";
}

TEST(StandingObject, AGableFallsFromItsRidgeToBothEaves) {
  const StandingObject house = HouseAtTwenty(0.75);
  EXPECT_NEAR(house.EaveM(), 5.0, 1e-12);
  for (const Eigen::Vector3d& corner : house.Corners()) EXPECT_NEAR(corner.z(), 5.0, 1e-12);
  for (const double y : {-3.0, 0.0, 2.0}) {
    const Eigen::Vector3d roof = house.RoofPointAt({1.0, y});
    EXPECT_NEAR(roof.z(), 8.0 - 0.75 * std::abs(y), 1e-12);
    const auto hit = test::ValueOf(house.CastRay({roof.x(), roof.y(), 60.0}, {0.0, 0.0, -1.0}));
    EXPECT_NEAR(60.0 - hit.distance_m, roof.z(), 1e-9);
  }
  // Level with the middle of a slope, from its side: the slope, not the wall below.
  const Eigen::Vector3d outside = house.RoofPointAt({0.0, 20.0});
  const Eigen::Vector3d middle = house.RoofPointAt({0.0, 2.0});
  const Eigen::Vector3d start(outside.x(), outside.y(), middle.z() + 0.001);
  const auto hit = test::ValueOf(house.CastRay(start, (middle - start).normalized()));
  EXPECT_FALSE(hit.is_side);
  EXPECT_NEAR(hit.distance_m, (middle - start).norm(), 1e-6);
}

TEST(StandingObject, OneSeesBelowACrownButNotThroughIt) {
  const World world(Village(0.0));
  int trees = 0;
  for (const StandingObject& tree : world.objects()) {
    if (tree.kind != ObjectKind::kTree) continue;
    ++trees;
    const Eigen::Vector2d& middle = tree.outline.center_in_enu;
    EXPECT_NEAR(tree.TopAt(middle).value(), tree.ridge_m, 1e-9);
    const double side_m = tree.outline.half_size_m.x() + 1.0;
    const auto across = [&](double z) {
      return tree.CastRay({middle.x() - side_m, middle.y(), z}, {1.0, 0.0, 0.0});
    };
    ASSERT_TRUE(across(tree.ground_m + 0.6 * tree.outline.height_m).has_value());
    // Below the leaves only the trunk stands.
    EXPECT_NEAR(test::ValueOf(across(tree.ground_m + 0.05 * tree.outline.height_m)).distance_m, side_m, 0.35);
  }
  EXPECT_GT(trees, 20);
}

TEST(StandingObjects, AreThoseOfTheirSeedAndTouchNoOther) {
  const World world(Village(8.0));
  const World again(Village(8.0));
  WorldOptions other = Village(8.0);
  other.seed = 4;
  int houses = 0, gables = 0, walls = 0;
  ASSERT_EQ(world.objects().size(), again.objects().size());
  for (std::size_t i = 0; i < world.objects().size(); ++i) {
    const StandingObject& object = world.objects()[i];
    EXPECT_EQ(object.outline.center_in_enu, again.objects()[i].outline.center_in_enu);
    EXPECT_EQ(object.ridge_m, again.objects()[i].ridge_m);
    houses += object.IsHouse() ? 1 : 0;
    gables += object.kind == ObjectKind::kGabledHouse ? 1 : 0;
    walls += object.kind == ObjectKind::kWall ? 1 : 0;
    if (object.IsHouse()) {
      EXPECT_GE(object.ridge_m - object.ground_m, 3.0);
      EXPECT_LE(object.ridge_m - object.ground_m, 12.0);
      EXPECT_GE(object.outline.half_size_m.minCoeff(), 4.0);
      EXPECT_LE(object.outline.half_size_m.maxCoeff(), 10.0);
    }
    for (const StandingObject& near : world.objects()) {
      if (&near == &object || object.kind == ObjectKind::kTree) continue;
      for (const Eigen::Vector3d& corner : object.Corners()) {
        EXPECT_FALSE(near.TopAt(corner.head<2>()).has_value());
        // None is buried.
        EXPECT_GT(corner.z(), world.TerrainHeightAt(corner.x(), corner.y()) + 0.5);
      }
    }
  }
  EXPECT_GE(houses, 8);
  EXPECT_GT(gables, 1);
  EXPECT_LT(gables, houses);
  EXPECT_GE(walls, 3);
  EXPECT_NE(World(other).objects().front().outline.center_in_enu,
            world.objects().front().outline.center_in_enu);
}

TEST(StandingObjects, TheNearestThatARayMeetsIsWhatItShows) {
  for (const double relief_m : {0.0, 8.0}) {
    const World world(Village(relief_m));
    WorldOptions bare = Village(relief_m);
    bare.objects = {};
    const World ground(bare);
    RandomStream random(5, 2);
    int hidden = 0, sides = 0, crowns = 0;
    for (int i = 0; i < 20000; ++i) {
      const double east = random.Uniform(-80.0, 80.0);
      const double north = random.Uniform(-80.0, 80.0);
      const Eigen::Vector3d start(east, north, 60.0);
      const double aside = random.Uniform(-0.7, 0.7);
      const Eigen::Vector3d way = i % 4 == 0
                                      ? Eigen::Vector3d(0.0, 0.0, -1.0)
                                      : Eigen::Vector3d(aside, random.Uniform(-0.7, 0.7), -1.0).normalized();
      const auto hit = world.CastRay(start, way, 5000.0);
      const auto on_ground = ground.CastRay(start, way, 5000.0);
      ASSERT_TRUE(hit.has_value() && on_ground.has_value());
      double nearest_m = on_ground->distance_m;
      int nearest = -1;
      for (std::size_t k = 0; k < world.objects().size(); ++k) {
        const auto met = world.objects()[k].CastRay(start, way);
        if (!met || met->distance_m > nearest_m) continue;
        nearest_m = met->distance_m;
        nearest = static_cast<int>(k);
      }
      EXPECT_EQ(hit->object, nearest);
      EXPECT_NEAR(hit->distance_m, nearest_m, 1e-9);
      hidden += hit->distance_m < on_ground->distance_m ? 1 : 0;
      sides += hit->surface == SurfaceKind::kWall ? 1 : 0;
      crowns += hit->surface == SurfaceKind::kTree ? 1 : 0;
      if (i % 4 == 0) {
        EXPECT_NEAR(hit->point_in_enu.z(), world.SurfaceHeightAt(east, north), 2e-4);
        EXPECT_EQ(world.ObjectAt(east, north), nearest);
      }
    }
    EXPECT_GT(hidden, 1000);
    EXPECT_GT(sides, 200);
    EXPECT_GT(crowns, 100);
  }
}

TEST(StandingObjects, APhotoThatSeesNoneHasTheBytesOfAWorldWithoutAny) {
  WorldOptions options = Village(5.0);
  options.objects.area_min = {900.0, 900.0};
  options.objects.area_max = {1000.0, 1000.0};
  const World far(options);
  ASSERT_FALSE(far.objects().empty());
  options.objects = {};
  const World none(options);
  const camera::Intrinsics lens = camera::Intrinsics::Centered(160, 120, 120.0);
  const auto pose = geo::Rigid3::FromRotationAndTargetOrigin(
      CamFromEnuOfGimbal({0.4, geo::DegToRad(-80.0), 0.0}), Eigen::Vector3d(20.0, -30.0, 70.0));
  EXPECT_EQ(RenderPhoto(far, lens, pose, {}).rgb, RenderPhoto(none, lens, pose, {}).rgb);
}

SimulateOptions FlightOverAVillage() {
  SimulateOptions options;
  options.intrinsics = camera::Intrinsics::Centered(400, 300, 300.0);
  options.trajectory.photos = 9;
  options.world.relief_m = 3.0;
  options.world.objects.houses = 4;
  options.world.objects.trees = 5;
  return options;
}

TEST(StandingObjects, TheTruthOfAFlightHasTheirCornersAndHeights) {
  const auto flight = PlanSimulatedFlight(FlightOverAVillage());
  ASSERT_TRUE(flight.ok()) << flight.error().message;
  const auto truth = nlohmann::json::parse(TruthJson(*flight));
  const auto& objects = truth.at("objects");
  ASSERT_EQ(objects.size(), flight->world.objects().size());
  int houses = 0;
  for (const auto& object : objects) {
    if (object.at("kind") == "tree") continue;
    ++houses;
    EXPECT_GE(object.at("ridge_m"), object.at("eave_m"));
    ASSERT_EQ(object.at("corners_in_enu").size(), 4u);
    // The raster of true heights, at a corner moved a little inwards, shows the roof.
    const Eigen::Vector3d corner(object["corners_in_enu"][0][0], object["corners_in_enu"][0][1],
                                 object["corners_in_enu"][0][2]);
    const Eigen::Vector2d middle(object["center_in_enu"][0], object["center_in_enu"][1]);
    const Eigen::Vector2d inside = corner.head<2>() + 0.02 * (middle - corner.head<2>());
    const geo::Wgs84 at = flight->frame.Wgs84FromEnu({inside.x(), inside.y(), corner.z()});
    const Eigen::Vector2d in_merc = geo::MercFromLatLon({at.lat_deg, at.lon_deg});
    geo::RasterFrame one = flight->WorldRaster();
    one.pixel_size_in_merc_m = 0.01;
    one.north_west_in_merc = in_merc + Eigen::Vector2d(-0.005, 0.005);
    one.width_px = one.height_px = 1;
    const std::vector<float> surface = SurfaceOf(flight->world, flight->frame, one);
    EXPECT_NEAR(surface[0], 500.0 + flight->world.SurfaceHeightAt(inside.x(), inside.y()), 0.02);
    EXPECT_NEAR(surface[1], 500.0 + flight->world.TerrainHeightAt(inside.x(), inside.y()), 0.02);
    EXPECT_NEAR(surface[0], 500.0 + corner.z(), 0.25);
    EXPECT_EQ(surface[2], static_cast<float>(&object - &objects[0] + 1));
    // And it lies where the corner's place in the map is.
    const Eigen::Vector2d corner_in_merc(object["corners_in_merc"][0][0], object["corners_in_merc"][0][1]);
    EXPECT_LT((corner_in_merc - in_merc).norm(), 0.5);
  }
  EXPECT_GE(houses, 2);
  SimulateOptions plain = FlightOverAVillage();
  plain.world.objects = {};
  EXPECT_FALSE(nlohmann::json::parse(TruthJson(*PlanSimulatedFlight(plain))).contains("objects"));
}

TEST(StandingObjects, ImpossibleOnesAreRefused) {
  const auto refused = [](const auto& change) {
    SimulateOptions options = FlightOverAVillage();
    change(options);
    const auto flight = PlanSimulatedFlight(options);
    return !flight.ok() && flight.error().code == ErrorCode::kInvalidArgument;
  };
  EXPECT_FALSE(refused([](SimulateOptions&) {}));
  EXPECT_TRUE(refused([](SimulateOptions& o) { o.world.objects.houses = -1; }));
  EXPECT_TRUE(refused([](SimulateOptions& o) { o.world.objects.trees = 1'000'000; }));
  EXPECT_TRUE(refused([](SimulateOptions& o) { o.world.objects.lowest_house_m = 13.0; }));
  EXPECT_TRUE(refused([](SimulateOptions& o) { o.world.objects.highest_house_m = std::nan(""); }));
  EXPECT_TRUE(refused([](SimulateOptions& o) { o.world.has_boxes = true; }));
  EXPECT_TRUE(refused([](SimulateOptions& o) { o.trajectory.height_m = 20.0; }));
}

}  // namespace
}  // namespace skyquilt::simulate
