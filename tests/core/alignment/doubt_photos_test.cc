#include "core/alignment/stages/doubt_photos.h"

#include <gtest/gtest.h>

#include <cstdint>

#include "core/flight/remarks/remark_words.h"

namespace skyquilt::alignment {
namespace {

AlignedFlight BlockOf(int photos) {
  AlignedFlight flight;
  for (int i = 0; i < photos; ++i) {
    AlignedPhoto photo;
    photo.photo.name = "photo" + std::to_string(i);
    photo.cam_from_enu.translation = -Eigen::Vector3d(20.0 * (i % 5), 20.0 * (i / 5), 60.0);
    photo.placement = Placement::kAligned;
    flight.photos.push_back(photo);
  }
  return flight;
}

void Move(AlignedPhoto& photo, double east_m) { photo.cam_from_enu.translation.x() -= east_m; }

TEST(LeaveOutFarAway, TakesOutASinglePhotoKilometresOffAndSaysWhy) {
  AlignedFlight flight = BlockOf(25);
  Move(flight.photos[7], 3000.0);
  flight.photos[7].placement = Placement::kPoseOnly;
  LeaveOutFarAway(flight);
  EXPECT_EQ(flight.photos.size(), 24u);
  ASSERT_EQ(flight.left_out.size(), 1u);
  EXPECT_EQ(flight.left_out.front().name, "photo7");
  EXPECT_NE(InWords(flight.left_out.front().reason).find("3.0 km"), std::string::npos);
}

TEST(LeaveOutFarAway, TakesOutASinglePhotoOfAFlightWhosePhotosLieFarApart) {
  AlignedFlight flight = BlockOf(25);
  for (AlignedPhoto& photo : flight.photos) photo.cam_from_enu.translation *= 20.0;  // 400 m, from 1200 m
  Move(flight.photos[7], 30'000.0);
  flight.photos[7].placement = Placement::kPoseOnly;
  LeaveOutFarAway(flight);
  ASSERT_EQ(flight.left_out.size(), 1u);
  EXPECT_EQ(flight.left_out.front().name, "photo7");
}

TEST(LeaveOutFarAway, KeepsWhatIsTiedToOthersAndWhatIsNear) {
  AlignedFlight flight = BlockOf(25);
  Move(flight.photos[3], 3000.0);  // aligned: its verified pairs put it there
  Move(flight.photos[7], 150.0);
  flight.photos[7].placement = Placement::kPoseOnly;
  LeaveOutFarAway(flight);
  EXPECT_EQ(flight.photos.size(), 25u);
}

TEST(LeaveOutFarAway, KeepsASecondBlockOfSomeSize) {
  AlignedFlight flight = BlockOf(25);
  for (int i = 0; i < 8; ++i) {
    Move(flight.photos[i], 5000.0);
    flight.photos[i].placement = Placement::kPoseOnly;
  }
  LeaveOutFarAway(flight);
  EXPECT_EQ(flight.photos.size(), 25u);
}

TEST(DoubtsInRemarks, SayOnceThatTheAircraftHovered) {
  const std::vector<std::string> names = {"a", "b", "c", "d", "e", "f"};
  std::vector<PhotoFindings> doubts(6);
  doubts[5].is_blurred = true;
  for (const std::size_t copy : {1U, 2U, 3U}) doubts[copy].copy_of = 0;
  EXPECT_EQ(InWords(DoubtsInRemarks(doubts, names)),
            (std::vector<std::string>{"b: shows the same picture as a", "c: shows the same picture as a",
                                      "d: shows the same picture as a", "f: is blurred"}));
  doubts[4].copy_of = 1;
  EXPECT_EQ(
      InWords(DoubtsInRemarks(doubts, names)),
      (std::vector<std::string>{"4 photos show the same picture as one before them, as of an aircraft that "
                                "hovers: b as a, and others.",
                                "f: is blurred"}));
  EXPECT_EQ(InWords(DoubtsInRemarks(doubts[4], names)),
            (std::vector<std::string>{"shows the same picture as b"}));
}

// As much in all directions and everywhere.
PictureDetail EvenDetail(float fine) {
  return PictureDetail(
      kDetailCells * kDetailCells,
      DetailCell{{fine, 0.0F, 2.0F * fine, 0.0F, fine}, {100.0F, 0.0F, 200.0F, 0.0F, 100.0F}, 128.0F});
}

bool IsDoubted(const PhotoFindings& doubt) {
  return doubt.copy_of || doubt.is_blurred || doubt.shows_other_place;
}

// Photos that overlap fully; the last may be unlinked or a copy.
struct Overlapping {
  std::vector<PhotoFeatures> features;
  MatchedFlight input;

  explicit Overlapping(int count) : features(count) {
    input.findings.resize(count);
    for (int i = 0; i < count; ++i) {
      for (int k = 0; k < 400; ++k) {
        features[i].keypoints.push_back({static_cast<float>(10 * k + 37 * i), 5.0F, 0.0F, 8.0F});
      }
      features[i].detail = EvenDetail(100.0F);
      input.features.push_back(&features[i]);
      View view;
      view.intrinsics = camera::Intrinsics::Centered(600, 600, 600.0);
      view.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin({0.0, 1.0, 0.0, 0.0}, {0.0, 0.0, 60.0});
      view.height_above_ground_m = 60.0;
      input.views.push_back(view);
    }
    for (int i = 0; i < count; ++i) {
      for (int j = i + 1; j < count; ++j) input.pairs.push_back({.first = i, .second = j, .overlap = 0.8});
    }
  }
  void Verify(int i, int j) {
    PhotoPair pair{i, j, {}, {}, 0.1};
    for (std::uint16_t k = 0; k < 300; ++k) pair.matches.push_back({k, k});
    input.links.push_back(pair);
  }
  void VerifyFirstFour() {
    for (int i = 0; i < 4; ++i) {
      for (int j = i + 1; j < 4; ++j) Verify(i, j);
    }
  }
  std::vector<PhotoFindings> Doubts() {
    DoubtPhotos(input.pairs, Relief(0.0), input);
    return input.findings;
  }
};

TEST(DoubtPhotos, KnowsACopyByItsPixels) {
  Overlapping photos(3);
  photos.features[2].keypoints = photos.features[0].keypoints;
  photos.Verify(0, 1);
  photos.Verify(0, 2);
  const auto doubts = photos.Doubts();
  EXPECT_FALSE(IsDoubted(doubts[1]));
  ASSERT_TRUE(doubts[2].copy_of.has_value());
  EXPECT_EQ(*doubts[2].copy_of, 0);
}

TEST(DoubtPhotos, KnowsAPhotoOfAnotherPlaceByItsSilentNeighbours) {
  Overlapping photos(5);
  photos.VerifyFirstFour();
  const auto doubts = photos.Doubts();
  EXPECT_TRUE(doubts[4].shows_other_place);
  for (int i = 0; i < 4; ++i) EXPECT_FALSE(IsDoubted(doubts[i]));
}

TEST(DoubtPhotos, KnowsABlurredPhotoByOthersOfTheSameGround) {
  Overlapping photos(4);
  photos.VerifyFirstFour();
  photos.features[1].detail = EvenDetail(10.0F);
  const auto doubts = photos.Doubts();
  EXPECT_TRUE(doubts[1].is_blurred);
  ASSERT_TRUE(doubts[0].sharpness && doubts[1].sharpness);
  EXPECT_LT(*doubts[1].sharpness, 0.35);
  EXPECT_GT(*doubts[0].sharpness, 0.9);
  EXPECT_FALSE(doubts[0].is_blurred);
}

TEST(DoubtPhotos, KnowsABlurredPhotoThatMatchesNothing) {
  Overlapping photos(5);
  photos.VerifyFirstFour();
  photos.features[4].detail = EvenDetail(10.0F);
  const auto doubts = photos.Doubts();
  EXPECT_TRUE(doubts[4].is_blurred);
  EXPECT_FALSE(doubts[4].shows_other_place);
}

}  // namespace
}  // namespace skyquilt::alignment
