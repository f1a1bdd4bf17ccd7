#include "core/alignment/from_images/grow_block.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string_view>

namespace skyquilt::alignment {
namespace {

// Five photos that agree on sixty points, and a sixth: it sees nine of these where they are, and four 7.8
// pixels beside. So it is found by thirteen points, of which the block then keeps nine: too few to stay.
struct ComesAndGoes {
  Registration input;
  std::vector<PhotoFeatures> features;
  std::vector<geo::Rigid3> cam_from_world;

  ComesAndGoes() : features(6) {
    const camera::Intrinsics lens = camera::Intrinsics::Centered(4000, 3000, 3000.0);
    input.lenses.emplace_back();
    input.lenses[0].recorded = input.lenses[0].intrinsics = lens;
    const double centers[6][2] = {{-6.0, -6.0}, {6.0, -6.0}, {-6.0, 6.0},
                                  {6.0, 6.0},   {2.0, 1.0},  {0.5, -0.5}};
    for (const auto& [x, y] : centers) {
      cam_from_world.push_back(
          geo::Rigid3::FromRotationAndTargetOrigin(Eigen::Quaterniond::Identity(), {x, y, 0.0}));
    }
    input.tracks_of.resize(6);
    for (int t = 0; t < 60; ++t) {
      KeypointTrack& track = input.scene.emplace_back();
      const Eigen::Vector3d point(4.0 * (t % 10) - 18.0, 4.0 * (t / 10) - 10.0,
                                  50.0 + 2.0 * std::sin(1.7 * t));
      for (int photo = 0; photo < 6; ++photo) {
        std::optional<Eigen::Vector2d> beside_px = BesidePx(t);
        if (photo < 5) beside_px = Eigen::Vector2d(0.0, 0.0);
        if (!beside_px) continue;
        const std::optional<Eigen::Vector2d> seen = lens.Project(cam_from_world[photo] * point);
        if (!seen) continue;
        std::vector<Keypoint>& keypoints = features[photo].keypoints;
        track.push_back({photo, static_cast<int>(keypoints.size())});
        input.tracks_of[photo].push_back(t);
        keypoints.push_back({static_cast<float>(seen->x() + beside_px->x()),
                             static_cast<float>(seen->y() + beside_px->y()), 0.0F, 10.0F});
      }
    }
    for (const PhotoFeatures& one : features) input.Add(&one, 0, {});
  }

  // Of the sixth photo; nothing: it does not see that point.
  static std::optional<Eigen::Vector2d> BesidePx(int track) {
    switch (track) {
      case 12:
        return Eigen::Vector2d(7.8, 0.0);
      case 13:
        return Eigen::Vector2d(-7.8, 0.0);
      case 46:
        return Eigen::Vector2d(0.0, 7.8);
      case 47:
        return Eigen::Vector2d(0.0, -7.8);
      case 0:
      case 4:
      case 9:
      case 20:
      case 24:
      case 29:
      case 50:
      case 54:
      case 59:
        return Eigen::Vector2d(0.0, 0.0);
      default:
        return std::nullopt;
    }
  }
};

TEST(GrowBlock, GivesUpAPhotoThatComesAndGoes) {
  const ComesAndGoes scene;
  Block block(scene.input, scene.input.lenses);
  for (int photo = 0; photo < 5; ++photo) block.Place(photo, scene.cam_from_world[photo]);
  block.TriangulateAll(1);
  SilentProgress progress;
  GrowBlock(PhotoSet(6), 1, progress, block);
  EXPECT_EQ(block.size(), 5);
  EXPECT_FALSE(block.Has(5));
  for (int photo = 0; photo < 5; ++photo) EXPECT_EQ(block.PointsSeen()[photo], 60) << photo;
}

TEST(BeginBlock, BeginsWithNoPhotoThatIsSpent) {
  const ComesAndGoes scene;
  Registration input = scene.input;
  PhotoPair& pair = input.links.emplace_back();
  pair.second = 1;
  pair.matches.resize(60);
  pair.poses = {scene.cam_from_world[1] * scene.cam_from_world[0].Inverse()};
  pair.angle_rad = 0.2;
  PhotoSet spent(6);
  std::set<std::size_t> failed;
  SilentProgress progress;
  EXPECT_TRUE(BeginBlock(input, input.lenses, PhotoSet(6), spent, 1, failed, progress).has_value());
  spent.Add(1);
  EXPECT_FALSE(BeginBlock(input, input.lenses, PhotoSet(6), spent, 1, failed, progress).has_value());
}

// As of a flight over woods: pairs of two photos each, with more matches than those of any group.
TEST(BeginBlock, GoesOnAfterPairsThatNoThirdPhotoSharesAnythingWith) {
  const ComesAndGoes scene;
  Registration input = scene.input;
  const auto add_link = [&](int first, int second, std::size_t matches) {
    PhotoPair& pair = input.links.emplace_back();
    pair.first = first;
    pair.second = second;
    pair.matches.resize(matches);
    pair.poses = {scene.cam_from_world[1] * scene.cam_from_world[0].Inverse()};
    pair.angle_rad = 0.2;
  };
  const PhotoFeatures alone;
  for (int pair = 0; pair < 10; ++pair) {
    const int first = static_cast<int>(input.Photos());
    for (int photo = 0; photo < 2; ++photo) input.Add(&alone, 0, {});
    add_link(first, first + 1, 500);
  }
  input.tracks_of.resize(input.Photos());
  const PhotoSet none(input.Photos());
  std::set<std::size_t> failed;
  SilentProgress progress;
  EXPECT_FALSE(BeginBlock(input, input.lenses, none, none, 1, failed, progress).has_value());
  EXPECT_EQ(failed.size(), 10U) << "not to be tried before each of hundreds of groups";
  add_link(0, 1, 60);
  const std::optional<Block> block = BeginBlock(input, input.lenses, none, none, 1, failed, progress);
  ASSERT_TRUE(block.has_value());
  EXPECT_TRUE(block->Has(0) && block->Has(1));
  EXPECT_GE(block->size(), 3);
}

class CancelledAfter final : public Progress {
 public:
  explicit CancelledAfter(int questions) : left_(questions) {}
  void BeginStage(std::string_view) override {}
  void Report(double, std::string_view) override {}
  bool IsCancelled() const override { return left_-- <= 0; }

 private:
  mutable int left_;
};

// Of a flight of thousands of photos all such pairs take minutes.
TEST(BeginBlock, TriesNoFurtherPairsWhenCancelled) {
  const ComesAndGoes scene;
  Registration input = scene.input;
  const PhotoFeatures alone;
  for (int pair = 0; pair < 30; ++pair) {
    PhotoPair& link = input.links.emplace_back();
    link.first = static_cast<int>(input.Photos());
    link.second = link.first + 1;
    for (int photo = 0; photo < 2; ++photo) input.Add(&alone, 0, {});
    link.matches.resize(500);
    link.poses = {scene.cam_from_world[1] * scene.cam_from_world[0].Inverse()};
    link.angle_rad = 0.2;
  }
  input.tracks_of.resize(input.Photos());
  const PhotoSet none(input.Photos());
  std::set<std::size_t> failed;
  EXPECT_FALSE(BeginBlock(input, input.lenses, none, none, 1, failed, CancelledAfter(2)).has_value());
  EXPECT_EQ(failed.size(), 12U) << "two times six";
}

// Hundreds of groups lie beside each other while all of a flight's points are one scene.
TEST(Block, IsPackedByItsOwnPointsAlone) {
  const ComesAndGoes scene;
  Registration input = scene.input;
  input.scene.resize(100'000);
  Block block(input, input.lenses);
  for (int photo = 0; photo < 5; ++photo) block.Place(photo, scene.cam_from_world[photo]);
  block.TriangulateAll(1);
  const Block::Packed packed = block.Pack();
  EXPECT_EQ(packed.size(), 5);
  EXPECT_TRUE(packed.Has(4));
  EXPECT_FALSE(packed.Has(5));
  EXPECT_EQ(packed.points.size(), 60U);
  Block again(input, packed);
  for (int t = 0; t < 60; ++t) {
    EXPECT_EQ(again.Point(t), block.Point(t)) << t;
    EXPECT_EQ(again.SeenBy(t), block.SeenBy(t)) << t;
  }
  EXPECT_FALSE(again.HasPoint(60));
  SilentProgress progress;
  GrowBlock(PhotoSet(6), 1, progress, block);
  GrowBlock(PhotoSet(6), 1, progress, again);
  for (int photo = 0; photo < 5; ++photo)
    EXPECT_EQ(again.Pose(photo).translation, block.Pose(photo).translation) << photo;
}

// As of a flight that hovers over a shadow that moves: of what hundreds of photos see half goes, one by one.
TEST(Block, AgreesOnAPointThatHalfOfHundredsOfPhotosShowElsewhere) {
  constexpr int kPhotos = 600;
  const camera::Intrinsics lens = camera::Intrinsics::Centered(4000, 3000, 3000.0);
  Registration input;
  input.lenses.emplace_back();
  input.lenses[0].recorded = input.lenses[0].intrinsics = lens;
  input.tracks_of.assign(kPhotos, std::vector<int>{0});
  KeypointTrack& track = input.scene.emplace_back();
  std::vector<PhotoFeatures> features(kPhotos);
  std::vector<geo::Rigid3> cam_from_world;
  for (int photo = 0; photo < kPhotos; ++photo) {
    cam_from_world.push_back(geo::Rigid3::FromRotationAndTargetOrigin(Eigen::Quaterniond::Identity(),
                                                                      {0.02 * photo - 6.0, 0.0, 0.0}));
    const Eigen::Vector2d seen =
        lens.ProjectBeyondFold(cam_from_world.back() * Eigen::Vector3d(0.0, 0.0, 50.0));
    const double way = photo % 4 == 1 ? 1.0 : -1.0;
    const double beside_px = photo % 2 == 1 ? way * (8.0 + 0.02 * photo) : 0.0;
    features[photo].keypoints.push_back(
        {static_cast<float>(seen.x()), static_cast<float>(seen.y() + beside_px), 0.0F, 10.0F});
    input.Add(&features[photo], 0, {});
    track.push_back({photo, 0});
  }
  Block block(input, input.lenses);
  for (int photo = 0; photo < kPhotos; ++photo) block.Place(photo, cam_from_world[photo]);
  block.TriangulateAll(1);
  ASSERT_TRUE(block.HasPoint(0));
  EXPECT_EQ(block.SeenBy(0).size(), 300U);
  EXPECT_NEAR(block.Point(0).z(), 50.0, 0.1);
}

}  // namespace
}  // namespace skyquilt::alignment
