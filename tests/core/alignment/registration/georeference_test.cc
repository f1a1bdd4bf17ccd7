#include "core/alignment/from_images/georeference.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/alignment/registration/uniform.h"

namespace skyquilt::alignment {
namespace {

constexpr int kPhotos = 40;

struct Case {
  Similarity3 enu_from_world;
  Registration registration;
  GeoreferenceRecords records;
  std::vector<Eigen::Vector3d> centers_in_enu;

  Similarity3 WorldFromEnu() const {
    Similarity3 world_from_enu;
    world_from_enu.scale = 1.0 / enu_from_world.scale;
    world_from_enu.rotation = enu_from_world.rotation.conjugate();
    world_from_enu.shift = -(world_from_enu.scale * (world_from_enu.rotation * enu_from_world.shift));
    return world_from_enu;
  }
};

// Eight photos a line, 60 m over almost level ground, in a world that lies and is scaled anyhow.
Case MakeCase() {
  Case made;
  made.enu_from_world.scale = 1.7;
  made.enu_from_world.rotation = geo::RotationFromVector({0.4, 2.0, -0.8});
  made.enu_from_world.shift = {30.0, -20.0, 10.0};
  const Similarity3 world_from_enu = made.WorldFromEnu();
  Sampler sampler(1);
  BundleLens lens;
  lens.recorded = lens.intrinsics = camera::Intrinsics::Centered(4000, 3000, 3000.0);
  made.registration.lenses = {lens};
  made.registration.block_sizes = {kPhotos};
  Eigen::Matrix3d down;
  down << 1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0;
  for (int i = 0; i < kPhotos; ++i) {
    const Eigen::Vector3d center(15.0 * (i % 8), 20.0 * (i / 8), 60.0);
    made.centers_in_enu.push_back(center);
    const geo::Rigid3 pose = geo::Rigid3::FromRotationAndTargetOrigin(Eigen::Quaterniond(down), center);
    made.registration.Add(nullptr, 0, {});
    made.registration.block_of.push_back(0);
    made.registration.cam_from_world.push_back(world_from_enu.Moved(pose));
    PhotoRecord record;
    record.center_in_enu =
        center + Eigen::Vector3d(Uniform(sampler) - 0.5, Uniform(sampler) - 0.5, Uniform(sampler) - 0.5);
    record.sigma_m = {1.0, 1.0, 1.0};
    made.records.photos.push_back(record);
  }
  for (int k = 0; k < 500; ++k) {
    Track track;
    track.observations.push_back({k % kPhotos, Eigen::Vector2d::Zero(), 1.0});
    track.point_in_enu =
        world_from_enu * Eigen::Vector3d(140.0 * Uniform(sampler) - 15.0, 120.0 * Uniform(sampler) - 20.0,
                                         Uniform(sampler) - 0.5);
    made.registration.tracks.push_back(track);
  }
  made.records.trusts_heights = true;
  return made;
}

double WorstM(const Case& made, const BlockPlace& place) {
  double worst = 0.0;
  for (std::size_t i = 0; i < made.centers_in_enu.size(); ++i) {
    const Eigen::Vector3d center = made.registration.cam_from_world[i].TargetOriginInSource();
    worst = std::max(worst, (place.enu_from_world * center - made.centers_in_enu[i]).norm());
  }
  return worst;
}

double LeanRad(const Case& made, const BlockPlace& place) {
  const Eigen::Vector3d up_in_world = made.enu_from_world.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  return std::acos(std::min(1.0, (place.enu_from_world.rotation * up_in_world).z()));
}

TEST(Georeference, PositionsPlaceABlock) {
  const Case made = MakeCase();
  const BlockPlace place = Georeference(made.registration, 0, made.records);
  EXPECT_EQ(place.placing, Placing::kByPositions);
  EXPECT_EQ(place.positions_held, kPhotos);
  EXPECT_LT(WorstM(made, place), 1.5);
}

TEST(Georeference, HeightsThatDriftDoNotTiltTheGround) {
  Case made = MakeCase();
  for (int i = 0; i < kPhotos; ++i) {
    made.records.photos[i].center_in_enu->z() += 2.5 * i;  // as of a receiver that takes its time
    made.records.photos[i].sigma_m.z() = 20.0;
  }
  made.records.trusts_heights = false;
  const BlockPlace place = Georeference(made.registration, 0, made.records);
  EXPECT_EQ(place.placing, Placing::kByPositions);
  EXPECT_LT(LeanRad(made, place), 0.03);
}

TEST(Georeference, PositionsThatArePoorEverywhereStillPlaceItAndAreNotBelieved) {
  Case made = MakeCase();
  Sampler sampler(9);
  for (PhotoRecord& record : made.records.photos) {
    record.center_in_enu->head<2>() += 40.0 * Eigen::Vector2d(Uniform(sampler) - 0.5, Uniform(sampler) - 0.5);
  }
  const BlockPlace place = Georeference(made.registration, 0, made.records);
  EXPECT_EQ(place.placing, Placing::kByPositions);
  EXPECT_GT(place.spread_sigmas, 4.0);
  EXPECT_LT(WorstM(made, place), 12.0);
}

// Ground seen at an angle is shortened, so a tilt would explain what only looks like one.
TEST(Georeference, PositionsStretchedOneWayDoNotTiltTheGround) {
  Case made = MakeCase();
  for (PhotoRecord& record : made.records.photos) record.center_in_enu->y() *= 0.6;
  const BlockPlace place = Georeference(made.registration, 0, made.records);
  EXPECT_EQ(place.placing, Placing::kByPositions);
  EXPECT_LT(LeanRad(made, place), 0.05);
}

TEST(Georeference, SurveyedPointsComeBeforePositions) {
  Case made = MakeCase();
  for (PhotoRecord& record : made.records.photos) record.center_in_enu->x() += 25.0;
  for (int k = 0; k < 5; ++k) {
    const Eigen::Vector3d& in_world = made.registration.tracks[k * 90].point_in_enu;
    made.records.control.push_back({in_world, made.enu_from_world * in_world, {0.02, 0.02, 0.04}});
  }
  const BlockPlace place = Georeference(made.registration, 0, made.records);
  EXPECT_EQ(place.placing, Placing::kByControl);
  EXPECT_LT(WorstM(made, place), 0.2);
}

// Above the sea, while the flight's heights are above the ellipsoid: cameras at 60 m would lie at 13.
TEST(Georeference, SurveyedHeightsOfAnotherZeroComeToTheFlightsOwn) {
  Case made = MakeCase();
  for (int k = 0; k < 5; ++k) {
    const Eigen::Vector3d& in_world = made.registration.tracks[k * 90].point_in_enu;
    const Eigen::Vector3d surveyed = made.enu_from_world * in_world - Eigen::Vector3d(0.0, 0.0, 47.0);
    made.records.control.push_back({in_world, surveyed, {0.02, 0.02, 0.04}});
  }
  EXPECT_GT(WorstM(made, Georeference(made.registration, 0, made.records)), 40.0) << "it has no own zero";
  made.records.has_own_zero = true;
  const BlockPlace place = Georeference(made.registration, 0, made.records);
  EXPECT_EQ(place.placing, Placing::kByControl);
  EXPECT_LT(WorstM(made, place), 0.5);
}

TEST(Georeference, WithoutPositionsRecordedHeightsGiveTheScale) {
  Case made = MakeCase();
  for (PhotoRecord& record : made.records.photos) {
    record.center_in_enu.reset();
    record.height_above_ground_m = 60.0;
  }
  const BlockPlace place = Georeference(made.registration, 0, made.records);
  EXPECT_EQ(place.placing, Placing::kByHeights);
  EXPECT_NEAR(place.enu_from_world.scale, made.enu_from_world.scale, 0.02 * made.enu_from_world.scale);
  EXPECT_LT(LeanRad(made, place), 0.02);
}

TEST(Georeference, WithoutAnythingAPhotoShowsTheStatedWidth) {
  Case made = MakeCase();
  for (PhotoRecord& record : made.records.photos) record.center_in_enu.reset();
  const BlockPlace place = Georeference(made.registration, 0, made.records);
  EXPECT_EQ(place.placing, Placing::kByGuess);
  EXPECT_FALSE(place.knows_north);
  const Eigen::Vector3d center =
      place.enu_from_world * made.registration.cam_from_world[0].TargetOriginInSource();
  EXPECT_NEAR(center.z() / 3000.0 * 4000.0, kGuessedWidthM, 3.0);
}

TEST(Georeference, ABlockThatNoPhotoIsLeftOfLiesNowhere) {
  Case made = MakeCase();
  made.registration.block_sizes.push_back(0);
  const BlockPlace place = Georeference(made.registration, 1, made.records);
  EXPECT_EQ(place.placing, Placing::kByGuess);
  EXPECT_EQ(place.positions, 0);
}

TEST(Georeference, RecordedAttitudesGiveNorth) {
  Case made = MakeCase();
  Eigen::Matrix3d down;
  down << 1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0;
  for (PhotoRecord& record : made.records.photos) {
    record.center_in_enu.reset();
    record.cam_from_enu = Eigen::Quaterniond(down);
  }
  const BlockPlace place = Georeference(made.registration, 0, made.records);
  EXPECT_TRUE(place.knows_north);
  EXPECT_LT(place.enu_from_world.rotation.angularDistance(made.enu_from_world.rotation), 0.02);
}

// Five rows of eight photos above each other: the plane through what they show stands upright.
TEST(Georeference, AWallIsNoGroundWherePositionsAndAttitudesSaySo) {
  Case made = MakeCase();
  const Similarity3 world_from_enu = made.WorldFromEnu();
  Sampler sampler(3);
  for (int i = 0; i < kPhotos; ++i) {
    geo::Rigid3& cam_from_world = made.registration.cam_from_world[i];
    PhotoRecord& record = made.records.photos[i];
    const Eigen::Vector3d center(15.0 * (i % 8), 0.0, 20.0 + 40.0 * (i / 8));
    record.cam_from_enu = made.enu_from_world.Moved(cam_from_world).rotation;
    record.center_in_enu =
        center + Eigen::Vector3d(Uniform(sampler) - 0.5, Uniform(sampler) - 0.5, Uniform(sampler) - 0.5);
    cam_from_world =
        world_from_enu.Moved(geo::Rigid3::FromRotationAndTargetOrigin(*record.cam_from_enu, center));
    made.centers_in_enu[i] = center;
  }
  for (Track& track : made.registration.tracks) {
    track.point_in_enu = world_from_enu * Eigen::Vector3d(140.0 * Uniform(sampler) - 15.0,
                                                          50.0 + Uniform(sampler), 200.0 * Uniform(sampler));
  }
  const BlockPlace place = Georeference(made.registration, 0, made.records);
  EXPECT_EQ(place.placing, Placing::kByPositions);
  EXPECT_LT(LeanRad(made, place), 0.03);
  for (std::size_t i = 0; i < made.centers_in_enu.size(); ++i) {
    const Eigen::Vector3d center =
        place.enu_from_world * made.registration.cam_from_world[i].TargetOriginInSource();
    EXPECT_LT((center - made.centers_in_enu[i]).head<2>().norm(), 1.5) << i;
  }
}

}  // namespace
}  // namespace skyquilt::alignment
