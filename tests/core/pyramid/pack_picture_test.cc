#include "core/pyramid/pack_picture.h"

#include <gtest/gtest.h>

#include <random>

namespace skyquilt::pyramid {
namespace {

image::RgbaImage Noise(int side_px) {
  image::RgbaImage image = image::RgbaImage::Transparent(side_px, side_px);
  std::mt19937 random(5);
  for (auto& byte : image.rgba) byte = static_cast<std::uint8_t>(random());
  return image;
}

TEST(PackPicture, PremultipliedAlphaComesBackAsItWas) {
  for (const int side_px : {1, 7, 128}) {
    const image::RgbaImage image = Noise(side_px);
    const auto unpacked = UnpackPicture(PackPicture(image), side_px);
    ASSERT_TRUE(unpacked);
    EXPECT_EQ(unpacked->rgba, image.rgba);
  }
}

TEST(UnpackPicture, RefusesWhatIsDamagedOrOfAnotherSize) {
  std::vector<std::uint8_t> packed = PackPicture(Noise(32));
  EXPECT_EQ(UnpackPicture(packed, 64).error().code, ErrorCode::kCorrupt);
  EXPECT_EQ(UnpackPicture({}, 32).error().code, ErrorCode::kCorrupt);
  packed.resize(10);
  EXPECT_EQ(UnpackPicture(packed, 32).error().code, ErrorCode::kCorrupt);
}

}  // namespace
}  // namespace skyquilt::pyramid
