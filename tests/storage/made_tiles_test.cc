#include "storage/tilesets/made_tiles.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <thread>
#include <vector>

namespace skyquilt::storage {
namespace {

MadeTileKey Key(std::int64_t x, std::int64_t revision = 1) {
  return {"flight", revision, *geo::TileId::Make(10, x, 7), image::PictureFormat::kPng, 2};
}

Result<std::string> Letters(std::size_t count) { return std::string(count, 'x'); }

TEST(MadeTiles, AreMadeOnce) {
  MadeTiles tiles;
  int made = 0;
  for (int i = 0; i < 3; ++i) {
    const auto tile = tiles.Get(Key(1), [&] { return ++made, Letters(5); });
    ASSERT_TRUE(tile);
    EXPECT_EQ((*tile)->bytes, "xxxxx");
  }
  EXPECT_EQ(made, 1);
  EXPECT_NE(tiles.Find(Key(1)), nullptr);
  EXPECT_EQ(tiles.Find(Key(1, 2)), nullptr);  // another revision has other tiles
  MadeTileKey other = Key(1);
  other.scale = 1;
  EXPECT_EQ(tiles.Find(other), nullptr);
  other = Key(1);
  other.format = image::PictureFormat::kWebp;
  EXPECT_EQ(tiles.Find(other), nullptr);
}

TEST(MadeTiles, AreMadeOnceForAllWhoAskAtTheSameTime) {
  MadeTiles tiles;
  std::atomic<int> made = 0, asked = 0;
  std::vector<std::thread> many;
  for (int i = 0; i < 8; ++i) {
    many.emplace_back([&] {
      ++asked;
      const auto tile = tiles.Get(Key(1), [&] {
        ++made;
        while (asked < 8) std::this_thread::yield();
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        return Letters(5);
      });
      EXPECT_TRUE(tile && (*tile)->bytes.size() == 5);
    });
  }
  for (std::thread& one : many) one.join();
  EXPECT_EQ(made, 1);
}

TEST(MadeTiles, StayWithinTheirBudget) {
  constexpr std::size_t kBudget = 10'000;
  MadeTiles tiles(kBudget);
  for (int x = 0; x < 50; ++x) {
    ASSERT_TRUE(tiles.Get(Key(x), [] { return Letters(1500); }));
    ASSERT_TRUE(tiles.Find(Key(0)));  // what is asked for stays
    EXPECT_LE(tiles.kept().bytes, kBudget);
  }
  EXPECT_EQ(tiles.kept().tiles, 5u);
  EXPECT_EQ(tiles.Find(Key(1)), nullptr);
  EXPECT_NE(tiles.Find(Key(49)), nullptr);
  // One that is larger than all of it is given, not kept.
  EXPECT_EQ((*tiles.Get(Key(100), [] { return Letters(20'000); }))->bytes.size(), 20'000u);
  EXPECT_EQ(tiles.Find(Key(100)), nullptr);
  EXPECT_EQ(tiles.kept().tiles, 5u);
}

TEST(MadeTiles, AreTriedAgainWhereMakingThemFailed) {
  MadeTiles tiles;
  const auto failed = tiles.Get(Key(1), []() -> Result<std::string> {
    return Error{ErrorCode::kCorrupt, "damaged", ""};
  });
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().code, ErrorCode::kCorrupt);
  EXPECT_THROW(static_cast<void>(tiles.Get(
                   Key(1), []() -> Result<std::string> { throw std::runtime_error("out of something"); })),
               std::runtime_error);
  EXPECT_TRUE(tiles.Get(Key(1), [] { return Letters(1); }));
}

}  // namespace
}  // namespace skyquilt::storage
