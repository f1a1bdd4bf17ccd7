// What of the photos is decoded, how often, and that a map of parts is the map of the whole photos.
#include "core/render/blocks/photo_cache.h"

#include <gtest/gtest.h>

#include <atomic>
#include <new>

#include "core/base/progress.h"
#include "core/render/blocks/weigh_block.h"
#include "core/render/render_tiles.h"
#include "tests/support/memory_sink.h"
#include "tests/support/simulated_map.h"
#include "tests/support/value_of.h"

namespace skyquilt::render {
namespace {

using image::DecodedImage;
using image::DecodedPart;
using image::PixelBox;

// Gives exactly what is asked for, so that one pixel too few would show, and keeps count.
class ExactParts final : public flight::PhotoSource {
 public:
  explicit ExactParts(const flight::PhotoSource& whole) : whole_(whole) {}

  Result<DecodedImage> Decode(const flight::Photo& photo, int denominator) const override {
    return whole_.Decode(photo, denominator);
  }
  Result<DecodedPart> DecodePart(const flight::Photo& photo, int denominator, const PixelBox& box,
                                 PixelBytes memory) const override {
    ++decodes;
    const Result<DecodedImage> whole = whole_.Decode(photo, denominator);
    if (!whole) return whole.error();
    pixels += static_cast<std::int64_t>(box.right - box.left) * (box.bottom - box.top);
    DecodedPart part{{box.right - box.left, box.bottom - box.top, std::move(memory)}, box.left, box.top};
    part.image.rgb.clear();
    for (int y = box.top; y < box.bottom; ++y) {
      const std::uint8_t* row = whole->Row(y);
      part.image.rgb.insert(part.image.rgb.end(), row + 3 * box.left, row + 3 * box.right);
    }
    return part;
  }

  mutable std::atomic<int> decodes{0};
  mutable std::atomic<std::int64_t> pixels{0};

 private:
  const flight::PhotoSource& whole_;
};

// Every pixel says where it is.
class Places final : public flight::PhotoSource {
 public:
  Result<DecodedImage> Decode(const flight::Photo& photo, int denominator) const override {
    if (photo.name == "damaged") return Error{ErrorCode::kCorrupt, "damaged", ""};
    DecodedImage image{(photo.intrinsics.width_px + denominator - 1) / denominator,
                       (photo.intrinsics.height_px + denominator - 1) / denominator,
                       {}};
    for (int y = 0; y < image.height_px; ++y) {
      for (int x = 0; x < image.width_px; ++x)
        image.rgb.insert(image.rgb.end(), {static_cast<std::uint8_t>(x), static_cast<std::uint8_t>(y), 7});
    }
    return image;
  }
};

// The first time that it is asked.
class ShortOfMemory final : public flight::PhotoSource {
 public:
  Result<DecodedImage> Decode(const flight::Photo& photo, int denominator) const override {
    if (!was_asked_.exchange(true)) throw std::bad_alloc();
    return places_.Decode(photo, denominator);
  }

 private:
  const Places places_;
  mutable std::atomic<bool> was_asked_{false};
};

flight::Photo Named(const char* name) {
  flight::Photo photo;
  photo.name = name;
  photo.intrinsics = camera::Intrinsics::Centered(201, 101, 150.0);
  return photo;
}

void ExpectHolds(const DecodedPart& part, const PixelBox& box) {
  for (int y = box.top; y < box.bottom; ++y) {
    for (int x = box.left; x < box.right; ++x) {
      ASSERT_GE(x, part.left_px);
      ASSERT_LT(x, part.left_px + part.image.width_px);
      const std::uint8_t* pixel = part.image.Row(y - part.top_px) + 3 * (x - part.left_px);
      ASSERT_EQ(pixel[0], x);
      ASSERT_EQ(pixel[1], y);
    }
  }
}

class PhotoCacheTest : public ::testing::Test {
 protected:
  const Places places_;
  const ExactParts parts_{places_};
  PhotoCache cache_{parts_, std::int64_t{1} << 20};
  const flight::Photo photo_ = Named("photo");
};

TEST_F(PhotoCacheTest, DecodesAPhotoOfWhichNothingIsExpectedWhole) {
  const auto got = test::ValueOf(cache_.Get(0, photo_, 1, {10, 10, 20, 20}));
  ExpectHolds(*got, {0, 0, 201, 101});
  ASSERT_TRUE(cache_.Get(0, photo_, 1, {-50, -50, 900, 900}));
  EXPECT_EQ(parts_.decodes, 1);
}

TEST_F(PhotoCacheTest, DecodesWhatIsExpectedOnceAndMoreOnlyWhenAsked) {
  cache_.Expect(0, {10, 10, 40, 40});
  cache_.Expect(0, {30, 5, 60, 20});
  ExpectHolds(**cache_.Get(0, photo_, 1, {12, 12, 14, 14}), {10, 5, 60, 40});
  ExpectHolds(**cache_.Get(0, photo_, 1, {59, 5, 60, 40}), {59, 5, 60, 40});
  EXPECT_EQ(parts_.pixels, 50 * 35);
  EXPECT_EQ(parts_.decodes, 1);
  const auto earlier = cache_.Get(0, photo_, 1, {12, 12, 14, 14});
  ExpectHolds(**cache_.Get(0, photo_, 1, {70, 50, 80, 60}), {10, 5, 80, 60});
  ExpectHolds(**earlier, {10, 5, 60, 40});  // whoever holds the smaller part keeps it
  // Twice too little was expected.
  ExpectHolds(**cache_.Get(0, photo_, 1, {150, 90, 160, 95}), {0, 0, 201, 101});
  ExpectHolds(**cache_.Get(0, photo_, 1, {150, 90, 201, 101}), {0, 0, 201, 101});
  EXPECT_EQ(parts_.decodes, 3);
}

TEST_F(PhotoCacheTest, CountsInPixelsOfTheFullSize) {
  cache_.Expect(0, {11, 11, 41, 41});
  const auto got = test::ValueOf(cache_.Get(0, photo_, 4, {13, 13, 14, 14}));
  EXPECT_EQ(parts_.pixels, (11 - 2) * (11 - 2));
  // The last column and row hang over the edge.
  ExpectHolds(**cache_.Get(0, photo_, 4, {196, 96, 400, 400}), {49, 24, 51, 26});
}

TEST_F(PhotoCacheTest, ForgetsWhatIsDroppedAndRemembersWhatIsDamaged) {
  int calls = 0;
  cache_.OnDecoded([&](std::size_t photo, int denominator, const DecodedPart& part) {
    ++calls;
    EXPECT_EQ(photo, 0U);
    EXPECT_EQ(denominator, 1);
    ExpectHolds(part, {0, 0, 201, 101});
  });
  {
    const auto held = cache_.Get(0, photo_, 1, {0, 0, 1, 1});
    cache_.Drop(0);
    ASSERT_TRUE(cache_.Get(0, photo_, 1, {0, 0, 1, 1}));
    EXPECT_EQ(calls, 1);  // somebody holds it: nothing would come of dropping it
  }
  cache_.Drop(5);
  cache_.Drop(0);
  ExpectHolds(**cache_.Get(0, photo_, 1, {0, 0, 1, 1}), {0, 0, 201, 101});
  EXPECT_EQ(calls, 2);
  const flight::Photo damaged = Named("damaged");
  EXPECT_EQ(cache_.Get(1, damaged, 1, {0, 0, 1, 1}).error().code, ErrorCode::kCorrupt);
  EXPECT_EQ(cache_.Get(1, damaged, 1, {0, 0, 1, 1}).error().code, ErrorCode::kCorrupt);
  EXPECT_EQ(parts_.decodes, 3);
}

TEST_F(PhotoCacheTest, NobodyWaitsForWhatThereWasNoMemoryFor) {
  const ShortOfMemory source;
  PhotoCache cache(source, std::int64_t{1} << 20);
  EXPECT_THROW(static_cast<void>(cache.Get(0, photo_, 1, {0, 0, 1, 1})), std::bad_alloc);
  ExpectHolds(**cache.Get(0, photo_, 1, {0, 0, 1, 1}), {0, 0, 201, 101});
}

TEST(PhotoRegions, MakeTheMapOfTheWholePhotosFromLess) {
  simulate::SimulateOptions options = test::SmallPhotos(9);
  options.intrinsics.k1 = -0.1;
  options.trajectory.yaw_rule = simulate::YawRule::kAnywhere;
  const test::SimulatedMap map = test::MakeSimulatedMap(options);
  const SeamMap seams = map.Seams({});
  test::MemorySink expected;
  test::RenderMap(map, seams, 1, expected);
  ASSERT_GT(expected.tiles.size(), 20U);
  std::int64_t all_pixels = 0;
  for (const auto& photo : map.flight.photos)
    all_pixels += static_cast<std::int64_t>(photo.intrinsics.width_px) * photo.intrinsics.height_px;
  // A cache for all and one that holds two photos.
  for (const std::int64_t budget : {std::int64_t{1} << 28, std::int64_t{1} << 20}) {
    for (const int threads : {1, 2}) {
      const ExactParts parts(*map.photos);
      PhotoCache cache(parts, budget);
      const auto regions = ShownRegions(map.flight, map.ground, seams);
      for (std::size_t i = 0; i < regions.size(); ++i) cache.Expect(i, regions[i]);
      SilentProgress progress;
      test::MemorySink tiles;
      ASSERT_TRUE(RenderTiles({map.flight, map.ground, map.exposure, seams, map.plan, cache},
                              {threads, {image::TileEncoding::kJpegPng, 95}}, tiles, progress));
      ASSERT_EQ(tiles.tiles.size(), expected.tiles.size());
      for (const auto& [tile, stored] : expected.tiles)
        ASSERT_EQ(tiles.tiles.at(tile).bytes, stored.bytes) << tile.z() << "/" << tile.x() << "/" << tile.y();
      if (budget > (1 << 20)) {
        EXPECT_LT(parts.pixels, 0.9 * static_cast<double>(all_pixels));
        EXPECT_LT(parts.decodes, 2 * 9);  // some again at the map's edge, which is all round here
      }
    }
  }
}

}  // namespace
}  // namespace skyquilt::render
