#include "core/surface/match_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/median.h"
#include "tests/core/surface/synthetic_scene.h"
#include "tests/support/value_of.h"

namespace skyquilt::surface {
namespace {

constexpr double kGsdM = 0.1;  // of the photos: 50 m up, 500 pixels of focal length
constexpr double kCellM = 0.2;

geo::Bounds2 Around(double west, double south, double east, double north) {
  geo::Bounds2 bounds;
  bounds.Include(Eigen::Vector2d(west, south));
  bounds.Include(Eigen::Vector2d(east, north));
  return bounds;
}

// Ground that slopes a little, seen by photos that overlap by four fifths.
SyntheticScene Scene(int east, int north) {
  SyntheticScene scene;
  scene.slope = {0.05, -0.03};
  scene.Photograph(east, north, 10.0, 50.0, 480, 400, 500.0);
  return scene;
}

SurfaceOptions Options(int threads = 2) {
  SurfaceOptions options;
  options.threads = threads;
  options.block_cells = 64;
  return options;
}

Result<DenseSurface> Match(const SyntheticScene& scene, const geo::Bounds2& area,
                           const SurfaceOptions& options = Options()) {
  SilentProgress progress;
  return MatchSurface(scene.flight, scene, ground::GroundSurface::Plane(0.0), GridOver(area, kCellM), options,
                      progress);
}

struct Off {
  double median_m = 0.0, most_m = 0.0;  // the second of 98 of 100
  double share_known = 0.0;
};

Off OffIn(const DenseSurface& surface, const SyntheticScene& scene,
          const std::function<bool(const Eigen::Vector2d&)>& is_asked) {
  std::vector<double> off;
  double known = 0.0;
  for (int row = 0; row < surface.grid.rows; ++row) {
    for (int column = 0; column < surface.grid.columns; ++column) {
      const Eigen::Vector2d place =
          surface.grid.south_west_in_enu + surface.grid.cell_m * Eigen::Vector2d(column, row);
      if (!is_asked(place)) continue;
      const std::size_t cell = static_cast<std::size_t>(row) * surface.grid.columns + column;
      off.push_back(std::abs(surface.cells.heights_m[cell] - scene.HeightAt(place)));
      known += surface.cells.agreeing_photos[cell] >= 2 ? 1.0 : 0.0;
      EXPECT_EQ(surface.cells.agreeing_photos[cell] == 0, surface.cells.confidence[cell] == 0);
    }
  }
  return {Percentile(off, 0.5), Percentile(off, 0.98), known / static_cast<double>(off.size())};
}

const auto kAll = [](const Eigen::Vector2d&) { return true; };

void ExpectNothingKnown(const Result<DenseSurface>& surface, bool is_seen) {
  ASSERT_TRUE(surface);
  ASSERT_FALSE(surface->cells.heights_m.empty());
  for (std::size_t i = 0; i < surface->cells.heights_m.size(); ++i) {
    ASSERT_EQ(surface->cells.agreeing_photos[i], 0);
    ASSERT_EQ(surface->cells.confidence[i], 0);
    ASSERT_EQ(std::isnan(surface->cells.heights_m[i]), !is_seen);
    if (is_seen) {
      ASSERT_FLOAT_EQ(surface->cells.heights_m[i], 0.0f);
    }
  }
}

TEST(MatchSurface, FindsASlope) {
  const SyntheticScene scene = Scene(3, 3);
  const auto surface = test::ValueOf(Match(scene, Around(-12, -10, 12, 10)));
  const Off off = OffIn(surface, scene, kAll);
  EXPECT_LT(off.median_m, 0.3 * kGsdM);
  EXPECT_LT(off.most_m, 1.0 * kGsdM);
  EXPECT_GT(off.share_known, 0.98);
}

// What three photos show so near their rims that parts of what lies around it is beyond them.
TEST(MatchSurface, KnowsWhatPhotosShowNearTheirRims) {
  const SyntheticScene scene = Scene(3, 3);
  const auto surface = test::ValueOf(Match(scene, Around(-36, -32, 36, 32)));
  const auto seen = [&](const Eigen::Vector2d& place, double within_px) {
    const Eigen::Vector3d point(place.x(), place.y(), scene.HeightAt(place));
    return std::count_if(scene.flight.photos.begin(), scene.flight.photos.end(), [&](const auto& photo) {
      const auto pixel = photo.intrinsics.Project(photo.cam_from_enu * point);
      return pixel && pixel->minCoeff() > within_px &&
             pixel->x() < photo.intrinsics.width_px - 1 - within_px &&
             pixel->y() < photo.intrinsics.height_px - 1 - within_px;
    });
  };
  const Off rim = OffIn(surface, scene,
                        [&](const auto& place) { return seen(place, 3.0) >= 3 && seen(place, 11.0) < 3; });
  EXPECT_LT(rim.median_m, 0.5 * kGsdM);
  EXPECT_GT(rim.share_known, 0.9);
}

TEST(MatchSurface, RaisesABoxAndKeepsTheGroundBesideIt) {
  SyntheticScene scene = Scene(3, 3);
  const geo::Bounds2 outline = Around(-4.1, -3.3, 4.3, 5.2);
  scene.boxes.push_back({outline, 6.0});
  const auto surface = test::ValueOf(Match(scene, Around(-14, -12, 14, 12)));
  const auto within = [&](const Eigen::Vector2d& place, double margin_m) {
    return (place.array() > outline.min.array() + margin_m).all() &&
           (place.array() < outline.max.array() - margin_m).all();
  };
  const Off roof = OffIn(surface, scene, [&](const auto& place) { return within(place, 5 * kCellM); });
  EXPECT_LT(roof.median_m, 0.5 * kGsdM);
  EXPECT_LT(roof.most_m, 2.0 * kGsdM);
  const Off beside = OffIn(surface, scene, [&](const auto& place) { return !within(place, -5 * kCellM); });
  EXPECT_LT(beside.median_m, 0.5 * kGsdM);
  EXPECT_LT(beside.most_m, 2.0 * kGsdM);
  // The volume above the ground: the outline, of 42 cells a side, is off by less than a cell.
  double volume_m3 = 0.0, true_m3 = 0.0;
  for (int row = 0; row < surface.grid.rows; ++row) {
    for (int column = 0; column < surface.grid.columns; ++column) {
      const Eigen::Vector2d place = surface.grid.south_west_in_enu + kCellM * Eigen::Vector2d(column, row);
      const double ground_m = scene.slope.dot(place);
      const std::size_t cell = static_cast<std::size_t>(row) * surface.grid.columns + column;
      volume_m3 += kCellM * kCellM * (surface.cells.heights_m[cell] - ground_m);
      true_m3 += kCellM * kCellM * (scene.HeightAt(place) - ground_m);
    }
  }
  EXPECT_NEAR(volume_m3, true_m3, 0.095 * true_m3);
}

// Seven of the largest cells wide, and higher than is looked for about the ground in smaller ones.
TEST(MatchSurface, RaisesATower) {
  SyntheticScene scene = Scene(4, 4);
  constexpr double kHalfM = 5.6;
  scene.boxes.push_back({Around(-kHalfM, -kHalfM, kHalfM, kHalfM), 14.0});
  const auto surface = test::ValueOf(Match(scene, Around(-12, -12, 12, 12)));
  const Off roof = OffIn(surface, scene, [&](const Eigen::Vector2d& place) {
    return place.cwiseAbs().maxCoeff() < kHalfM - 5 * kCellM;
  });
  EXPECT_LT(roof.median_m, 0.5 * kGsdM);
  EXPECT_LT(roof.most_m, 2.0 * kGsdM);
  EXPECT_GT(roof.share_known, 0.95);
}

TEST(MatchSurface, FillsWaterAndSaysSo) {
  SyntheticScene scene = Scene(3, 3);
  scene.even = Around(-6, -5, 6, 5);
  const auto surface = test::ValueOf(Match(scene, Around(-12, -10, 12, 10)));
  const Off water = OffIn(surface, scene, [](const Eigen::Vector2d& place) {
    return std::abs(place.x()) < 4.5 && std::abs(place.y()) < 3.5;
  });
  EXPECT_LT(water.share_known, 0.1);
  EXPECT_LT(water.most_m, 1.0);  // from around it
  const Off shore = OffIn(surface, scene, [](const Eigen::Vector2d& place) {
    return std::abs(place.x()) > 8.0 || std::abs(place.y()) > 7.0;
  });
  EXPECT_GT(shore.share_known, 0.97);
}

TEST(MatchSurface, NeedsTwoPhotos) {
  ExpectNothingKnown(Match(Scene(1, 1), Around(-5, -5, 5, 5)), true);
  const SyntheticScene two = Scene(2, 1);
  const auto surface = test::ValueOf(Match(two, Around(-5, -5, 5, 5)));
  const Off off = OffIn(surface, two, kAll);
  EXPECT_LT(off.median_m, 1.0 * kGsdM);
  EXPECT_GT(off.share_known, 0.9);
}

TEST(MatchSurface, HasNoHeightsBeyondWhatIsSeen) {
  ExpectNothingKnown(Match(Scene(3, 3), Around(300, 300, 306, 306)), false);
}

TEST(MatchSurface, TakesNoPhotosThatAreNotAligned) {
  SyntheticScene scene = Scene(2, 2);
  for (auto& photo : scene.flight.photos) photo.placement = alignment::Placement::kPoseOnly;
  ExpectNothingKnown(Match(scene, Around(-3, -3, 3, 3)), false);
}

TEST(MatchSurface, DoesWithoutADamagedPhoto) {
  SyntheticScene scene = Scene(3, 3);
  scene.flight.photos[4].photo.name = "damaged";
  EXPECT_LT(OffIn(test::ValueOf(Match(scene, Around(-5, -5, 5, 5))), scene, kAll).median_m, 0.5 * kGsdM);
}

TEST(MatchSurface, IsTheSameWithAnyNumberOfThreads) {
  SyntheticScene scene = Scene(3, 2);
  scene.boxes.push_back({Around(-2, -2, 3, 3), 4.0});
  const geo::Bounds2 area = Around(-14, -9, 14, 9);
  const auto one = Match(scene, area, Options(1)), four = Match(scene, area, Options(4));
  ASSERT_TRUE(one && four);
  EXPECT_EQ(one->cells.heights_m, four->cells.heights_m);
  EXPECT_EQ(one->cells.confidence, four->cells.confidence);
  EXPECT_EQ(one->cells.agreeing_photos, four->cells.agreeing_photos);
}

class CancelledAtOnce final : public Progress {
 public:
  void BeginStage(std::string_view) override {}
  void Report(double, std::string_view) override {}
  bool IsCancelled() const override { return true; }
};

TEST(MatchSurface, StopsWhenCancelled) {
  const SyntheticScene scene = Scene(2, 1);
  CancelledAtOnce progress;
  const Error surface =
      test::ErrorOf(MatchSurface(scene.flight, scene, ground::GroundSurface::Plane(0.0),
                                 GridOver(Around(-5, -5, 5, 5), kCellM), Options(), progress));
  EXPECT_EQ(surface.code, ErrorCode::kCancelled);
}

TEST(MatchSurface, HandsOnTheErrorOfWhoTakesBlocks) {
  const SyntheticScene scene = Scene(1, 1);
  SilentProgress progress;
  int taken = 0;
  const auto done = MatchSurfaceBlocks(
      scene.flight, scene, ground::GroundSurface::Plane(0.0), GridOver(Around(-20, -20, 20, 20), kCellM),
      Options(),
      [&](SurfaceBlock&&) -> Result<void> {
        ++taken;
        return Error{ErrorCode::kOutOfSpace, "full", ""};
      },
      progress);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, ErrorCode::kOutOfSpace);
  EXPECT_EQ(taken, 1);
}

TEST(MatchSurface, RefusesAGridWithoutCells) {
  const SyntheticScene scene = Scene(1, 1);
  SilentProgress progress;
  const Error surface = test::ErrorOf(
      MatchSurface(scene.flight, scene, ground::GroundSurface::Plane(0.0), {}, Options(), progress));
  EXPECT_EQ(surface.code, ErrorCode::kInvalidArgument);
}

TEST(GridOver, HasTheSameCellsForAllMapsOfAFlight) {
  const SurfaceGrid grid = GridOver(Around(-1.05, 0.3, 2.0, 0.9), 0.25);
  EXPECT_DOUBLE_EQ(grid.south_west_in_enu.x(), -1.25);
  EXPECT_DOUBLE_EQ(grid.south_west_in_enu.y(), 0.25);
  EXPECT_EQ(grid.columns, 14);
  EXPECT_EQ(grid.rows, 4);
}

TEST(RangeAbout, ReachesAsFarAsTiePointsDo) {
  SyntheticScene scene = Scene(2, 2);
  SurfaceOptions options;
  options.above_ground_m = 5.0;
  options.below_ground_m = 2.0;
  const auto ground = ground::GroundSurface::Plane(0.0);
  for (int i = 0; i < 100; ++i) scene.flight.tie_points_in_enu.emplace_back(0.0, 0.0, i < 10 ? 12.0 : 0.1);
  const HeightRange range = RangeAbout(scene.flight, ground, options);
  EXPECT_NEAR(range.above_m, 13.0, 1e-6);
  EXPECT_NEAR(range.below_m, 2.0, 1e-6);
  // No further than a share of the flying height, whatever points say.
  scene.flight.tie_points_in_enu.assign(100, Eigen::Vector3d(0.0, 0.0, 22.0));
  EXPECT_LE(RangeAbout(scene.flight, ground, options).above_m, options.most_share_of_height * 50.0 + 1e-9);
}

}  // namespace
}  // namespace skyquilt::surface
