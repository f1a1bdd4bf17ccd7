#include "core/render/seams/seam_map.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cstddef>
#include <utility>

#include "core/geo/web_mercator.h"
#include "core/render/blocks/measure_seams.h"
#include "core/render/blocks/weigh_block.h"
#include "core/render/seams/label_seams.h"
#include "tests/support/peak_memory.h"
#include "tests/support/simulated_map.h"

namespace skyquilt::render {
namespace {

// A view of `side` x `side` cells from the grid's corner that sees them all, in one grey.
LowResView PlainView(int side, std::uint8_t grey, float score_m) {
  LowResView view;
  view.columns = view.rows = side;
  const auto cells = static_cast<std::size_t>(side) * static_cast<std::size_t>(side);
  view.seen.assign(cells, Seen::kFully);
  view.rgb.assign(cells, {grey, grey, grey});
  view.score_m.assign(cells, score_m);
  return view;
}

SeamGrid GridOf(int side) {
  SeamGrid grid;
  grid.columns = grid.rows = side;
  return grid;
}

TEST(LabelSeams, CutsWhereNoCandidateHasANeighbour) {
  // The second photo may take one cell alone: nothing to weigh against its neighbours, which stay.
  std::vector<LowResView> views{PlainView(5, 100, 1.0f), PlainView(5, 100, 2.0f)};
  views[1].seen.assign(25, Seen::kNot);
  views[1].seen[12] = Seen::kFully;
  const SeamLabels labels = LabelSeams(views, GridOf(5), {true, 50.0, nullptr});
  for (int row = 0; row < 5; ++row) {
    for (int column = 0; column < 5; ++column) EXPECT_EQ(labels.At(column, row), 0);
  }
}

TEST(LabelSeams, TakesFlightsWithNothingToDecide) {
  EXPECT_EQ(LabelSeams({}, GridOf(3), {true, 50.0, nullptr}).At(1, 1), kNoPhoto);
  EXPECT_EQ(LabelSeams({LowResView{}}, GridOf(3), {true, 50.0, nullptr}).At(1, 1), kNoPhoto);
  EXPECT_EQ(LabelSeams({PlainView(1, 0, 0.0f)}, GridOf(1), {true, 50.0, nullptr}).At(0, 0), 0);
  // Two photos alike in everything: the first shows all.
  const std::vector<LowResView> same{PlainView(4, 80, 1.0f), PlainView(4, 80, 1.0f)};
  const SeamLabels labels = LabelSeams(same, GridOf(4), {true, 0.0, nullptr});
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) EXPECT_EQ(labels.At(column, row), 0);
  }
}

// Two fields far apart lie in one grid of cells, and hardly any of those is of a field: half a minute cell by
// cell.
TEST(SeamLabels, AreWalkedPastWhatLiesBetweenFieldsFarApart) {
  constexpr int kSide = 1 << 16;
  KnownLabels known{GridOf(kSide), SeamLabels(kSide, kSide), 0};
  known.labels.Set(kSide - 1, kSide - 1, 0);
  SeamMap seams;
  seams.labels = LabelSeams({}, GridOf(kSide), {true, 50.0, &known});
  EXPECT_TRUE(ShownRegions({}, ground::GroundSurface::Plane(0.0), seams).empty());
}

simulate::SimulateOptions SmallFlight() {
  simulate::SimulateOptions options = test::SmallPhotos(12);
  options.vignetting = 0.2;
  options.exposure_jitter = 0.08;
  return options;
}

TEST(SeamMap, GivesEverySeenCellToAPhotoThatSeesIt) {
  const test::SimulatedMap map = test::MakeSimulatedMap(SmallFlight());
  const SeamMap seams = map.Seams({});
  int cells = 0;
  for (int row = 0; row < seams.grid.rows; ++row) {
    for (int column = 0; column < seams.grid.columns; ++column) {
      const std::int32_t photo = seams.labels.At(column, row);
      if (photo == kNoPhoto) {
        for (const PhotoLevels& levels : seams.levels) EXPECT_FALSE(levels.SeesWhole(column, row));
        continue;
      }
      ++cells;
      bool someone_sees_it_whole = false;
      for (const PhotoLevels& levels : seams.levels) someone_sees_it_whole |= levels.SeesWhole(column, row);
      EXPECT_EQ(seams.levels[static_cast<std::size_t>(photo)].SeesWhole(column, row), someone_sees_it_whole);
    }
  }
  EXPECT_GT(cells, 5000);
}

TEST(SeamMap, IsTheSameWithAnyNumberOfThreads) {
  const test::SimulatedMap map = test::MakeSimulatedMap(SmallFlight());
  const SeamMap one = map.Seams({.threads = 1}), three = map.Seams({.threads = 3});
  for (int row = 0; row < one.grid.rows; ++row) {
    for (int column = 0; column < one.grid.columns; ++column) {
      ASSERT_EQ(one.labels.At(column, row), three.labels.At(column, row));
    }
  }
  for (std::size_t i = 0; i < one.levels.size(); ++i)
    EXPECT_EQ(one.levels[i].eighths, three.levels[i].eighths);
}

TEST(SeamMap, GoesRoundCarsThatMove) {
  const test::SimulatedMap map = test::MakeSimulatedMap(SmallFlight(), {}, 60);
  const test::ObjectCount nearest = test::CountCars(map, map.Seams({.moves_seams = false}));
  const test::ObjectCount moved = test::CountCars(map, map.Seams({}));
  EXPECT_GE(nearest.twice + nearest.in_part, 3) << "the scene must be hard for this to say anything";
  EXPECT_LE(moved.BrokenShare(), 0.05) << moved.twice << " twice, " << moved.in_part << " in part";
}

TEST(SeamMap, ShowsCarsThatDroveOnNoMoreThanOnce) {
  simulate::SimulateOptions options = SmallFlight();
  options.trajectory.photos = 60;  // line beside line: most of the ground is seen again half a minute later
  const test::SimulatedMap map = test::MakeSimulatedMap(options, {}, 80);
  const test::ObjectCount cars = test::CountCars(map, map.Seams({}));
  EXPECT_LE(cars.BrokenShare(), 0.05) << cars.twice << " twice, " << cars.in_part << " in part";
}

TEST(SeamMap, GoesRoundBuildings) {
  simulate::SimulateOptions options = SmallFlight();
  options.world.has_boxes = true;
  options.world.seed = 2;
  options.trajectory.photos = 40;
  options.trajectory.height_m = 90.0;
  const test::SimulatedMap map = test::MakeSimulatedMap(options);
  const test::ObjectCount roofs = test::CountRoofs(map, map.Seams({}));
  ASSERT_GT(roofs.objects, 5);
  EXPECT_LE(roofs.BrokenShare(), 0.05) << roofs.twice << " twice, " << roofs.in_part << " in part";
}

// From so high up that its pixels cover ten times the ground: near the point below it, it stands most nearly
// above.
TEST(SeamMap, APhotoWithFarCoarserPixelsGivesWay) {
  test::SimulatedMap map = test::MakeSimulatedMap(SmallFlight());
  constexpr std::size_t kHigh = 5;
  alignment::AlignedPhoto& high = map.flight.photos[kHigh];
  Eigen::Vector3d center = high.cam_from_enu.TargetOriginInSource();
  center.z() *= 10.0;
  high.height_above_ground_m *= 10.0;
  high.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(high.cam_from_enu.rotation, center);
  map.plan = *PlanMosaic(map.flight, map.ground, {});
  const SeamMap seams = map.Seams({});
  int of_high = 0;
  for (int row = 0; row < seams.grid.rows; ++row) {
    for (int column = 0; column < seams.grid.columns; ++column) {
      if (seams.labels.At(column, row) != static_cast<std::int32_t>(kHigh)) continue;
      ++of_high;
      for (std::size_t i = 0; i < seams.levels.size(); ++i) {
        EXPECT_FALSE(i != kHigh && seams.levels[i].SeesWhole(column, row)) << i << " sees it better";
      }
    }
  }
  EXPECT_GT(of_high, 1000) << "what nobody else sees";
}

TEST(SeamMap, ShowsNothingBeyondTheLookAngle) {
  test::SimulatedMap map = test::MakeSimulatedMap(SmallFlight());
  const double max_look_rad = geo::DegToRad(20.0);
  for (alignment::AlignedPhoto& photo : map.flight.photos) photo.max_look_rad = max_look_rad;
  map.plan = *PlanMosaic(map.flight, map.ground, {});
  const SeamMap seams = map.Seams({});
  int cells = 0;
  for (int row = 0; row < seams.grid.rows; ++row) {
    for (int column = 0; column < seams.grid.columns; ++column) {
      const std::int32_t photo = seams.labels.At(column, row);
      if (photo == kNoPhoto) continue;
      ++cells;
      const Eigen::Vector3d ground =
          map.flight.frame.EnuAtHeight(geo::LatLonFromMerc(seams.grid.CellInMerc(column, row)), 0.0);
      const Eigen::Vector3d up =
          map.flight.photos[static_cast<std::size_t>(photo)].cam_from_enu.TargetOriginInSource() - ground;
      EXPECT_LE(std::atan2(up.head<2>().norm(), up.z()), max_look_rad + 1e-6);
    }
  }
  EXPECT_GT(cells, 1000);
}

TEST(SeamMap, CorrectionsOfNeighboursMeetAtTheSeam) {
  const test::SimulatedMap map = test::MakeSimulatedMap(SmallFlight());
  const SeamMap seams = map.Seams({});
  double corrections = 0.0;
  for (const PhotoLevels& levels : seams.levels) {
    for (const auto& eighths : levels.eighths)
      corrections = std::max(corrections, std::abs(eighths[0] / 8.0));
  }
  // Most of the light was evened out by the gains: what is left is small, and it is there.
  EXPECT_GT(corrections, 0.2);
  EXPECT_LT(corrections, 12.0);
}

// 144 photos from low down, and one from five times as high that sees all of them and shows what lies around.
// A picture of its view for each of them would be 250 MiB.
TEST(SeamMap, TakesNoMoreMemoryForAHighPhotoThatSeesHundreds) {
  constexpr int kSide = 12, kPhotos = kSide * kSide + 1;
  const Eigen::Quaterniond down(Eigen::AngleAxisd(geo::kPi, Eigen::Vector3d::UnitX()));
  alignment::AlignedFlight flight;
  flight.frame = geo::LocalFrame({46.8, 7.1, 500.0});
  std::vector<Thumbnail> thumbnails;
  for (int i = 0; i < kPhotos; ++i) {
    const bool is_high = i + 1 == kPhotos;
    alignment::AlignedPhoto photo;
    photo.intrinsics = camera::Intrinsics::Centered(640, 480, 800.0);
    photo.height_above_ground_m = is_high ? 400.0 : 80.0;
    Eigen::Vector3d center(0.0, 0.0, photo.height_above_ground_m);
    if (!is_high) center.head<2>() = Eigen::Vector2d(10.0 * (i % kSide) - 55.0, 8.0 * (i / kSide) - 44.0);
    photo.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(down, center);
    image::DecodedImage picture{64, 48, {}};
    picture.rgb.assign(std::size_t{64} * 48 * 3, is_high ? 128 : 120);
    thumbnails.push_back(MakeThumbnail(photo.photo, picture));
    flight.photos.push_back(std::move(photo));
  }
  const ground::GroundSurface ground = ground::GroundSurface::Plane(0.0);
  const MosaicPlan plan = *PlanMosaic(flight, ground, {});
  const double before_mib = test::PeakMib();
  const SeamMap seams = BuildSeamMap(flight, ground, plan, ExposureModel::Even(kPhotos), thumbnails,
                                     {.moves_seams = false, .threads = 1});
  EXPECT_LT(test::PeakMib() - before_mib, 180.0);
  int darkest = 0;  // of what evens the high photo's light at its seams with the others
  for (const auto& eighths : seams.levels.back().eighths) darkest = std::min<int>(darkest, eighths[0]);
  EXPECT_LT(darkest, -8 * 2);
  EXPECT_GT(darkest, -8 * 8);
}

test::SimulatedMap SharpMap() {
  simulate::SimulateOptions options;
  options.intrinsics = camera::Intrinsics::Centered(1600, 1200, 1200.0);
  options.trajectory.photos = 4;
  options.trajectory.photos_per_line = 2;
  return test::MakeSimulatedMap(options);
}

SeamShift Measure(const test::SimulatedMap& map, int threads = 2) {
  SilentProgress progress;
  MeasureSeamsOptions options;
  options.threads = threads;
  PhotoCache cache(*map.photos, std::int64_t{1} << 28);
  return SeamPatches(map.flight, map.ground, options).Measure(cache, progress);
}

TEST(MeasureSeams, FindsNothingToShiftBetweenPhotosThatLieRight) {
  const SeamShift shift = Measure(SharpMap());
  EXPECT_GT(shift.patches, 3);
  EXPECT_GT(2 * shift.reliable, shift.patches);
  EXPECT_LT(shift.p90_m, 0.5 * shift.gsd_m);
}

TEST(MeasureSeams, MeasuresByHowMuchAPhotoLiesOffOnAnyNumberOfThreads) {
  test::SimulatedMap map = SharpMap();
  // Every second photo lies 0.5 m off to the east.
  for (std::size_t i = 0; i < map.flight.photos.size(); i += 2) {
    geo::Rigid3& pose = map.flight.photos[i].cam_from_enu;
    pose = geo::Rigid3::FromRotationAndTargetOrigin(
        pose.rotation, pose.TargetOriginInSource() + Eigen::Vector3d(0.5, 0.0, 0.0));
  }
  const SeamShift one = Measure(map, 1);
  const SeamShift two = Measure(map, 2);
  EXPECT_NEAR(one.p90_m, 0.5, 0.5 * one.gsd_m);
  EXPECT_EQ(one.p90_m, two.p90_m);
  EXPECT_EQ(one.median_m, two.median_m);
}

TEST(MeasureSeams, SaysThatItSawNothingOfASinglePhoto) {
  test::SimulatedMap map = SharpMap();
  map.flight.photos.resize(1);
  const SeamShift shift = Measure(map);
  EXPECT_EQ(shift.patches, 0);
  EXPECT_EQ(shift.p90_m, 0.0);
}

}  // namespace
}  // namespace skyquilt::render
