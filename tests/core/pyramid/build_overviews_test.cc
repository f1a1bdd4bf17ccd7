#include "core/pyramid/build_overviews.h"

#include <gtest/gtest.h>

#include <map>
#include <utility>

namespace skyquilt::pyramid {
namespace {

using Tiles = std::map<std::pair<int, std::pair<std::uint32_t, std::uint32_t>>, image::RgbaImage>;

std::pair<int, std::pair<std::uint32_t, std::uint32_t>> KeyOf(const geo::TileId& tile) {
  return {tile.z(), {tile.x(), tile.y()}};
}

// A tile that is empty but for a rectangle.
image::RgbaImage Sparse(int side, int left, int top, int right, int bottom) {
  image::RgbaImage image = image::RgbaImage::Transparent(side, side);
  for (int y = top; y < bottom; ++y) {
    for (int x = left; x < right; ++x) {
      std::uint8_t* pixel = image.Pixel(x, y);
      pixel[0] = static_cast<std::uint8_t>(x * 7), pixel[1] = static_cast<std::uint8_t>(y * 5), pixel[2] = 9;
      pixel[3] = 255;
    }
  }
  return image;
}

// Every parent whole in memory.
Tiles Reference(const std::vector<std::pair<geo::TileId, image::RgbaImage>>& base, int side) {
  Tiles level, all;
  for (const auto& [tile, image] : base) level.emplace(KeyOf(tile), image);
  for (int zoom = base.front().first.z(); zoom > 0; --zoom) {
    Tiles parents;
    for (const auto& [key, image] : level) {
      const auto [x, y] = key.second;
      const std::pair<int, std::pair<std::uint32_t, std::uint32_t>> parent{zoom - 1, {x / 2, y / 2}};
      image::RgbaImage& into =
          parents.try_emplace(parent, image::RgbaImage::Transparent(side, side)).first->second;
      Paste(Halve(image), static_cast<int>(x % 2) * side / 2, static_cast<int>(y % 2) * side / 2, into);
    }
    all.insert(parents.begin(), parents.end());
    level = std::move(parents);
  }
  return all;
}

// Large tiles are held trimmed while they are unfinished.
TEST(OverviewBuilder, MakesTheSameOfTilesOfAnySize) {
  for (const int side : {64, 1024}) {
    const int s = side;
    // Four that meet in the middle of the world: their parents have next to nothing in them.
    const std::vector<std::pair<geo::TileId, image::RgbaImage>> base{
        {*geo::TileId::Make(3, 2, 3), Sparse(s, 0, 0, 5, 3)},
        {*geo::TileId::Make(3, 3, 3), Sparse(s, s - 9, s - 20, s, s)},
        {*geo::TileId::Make(3, 4, 3), Sparse(s, 0, s - 20, 3, s - 1)},
        {*geo::TileId::Make(3, 4, 4), Sparse(s, 0, 0, s, s)},
        {*geo::TileId::Make(3, 5, 4), Sparse(s, 0, 0, 0, 0)},
    };
    Tiles made;
    OverviewBuilder builder(3, 0, side, [&](const geo::TileId& tile, const image::RgbaImage& image) {
      EXPECT_TRUE(made.emplace(KeyOf(tile), image).second) << "a tile twice";
    });
    for (const auto& [tile, image] : base) builder.Add(tile, image);
    builder.Finish();
    const Tiles expected = Reference(base, side);
    ASSERT_EQ(made.size(), expected.size());
    for (const auto& [key, image] : expected) {
      ASSERT_TRUE(made.contains(key));
      EXPECT_EQ(made.at(key).rgba, image.rgba) << "zoom " << key.first << ", tiles of " << side;
    }
  }
}

}  // namespace
}  // namespace skyquilt::pyramid
