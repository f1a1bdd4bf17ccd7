// Maps that lie in a store are shown as they were while a newer one comes slowly.
#include <gtest/gtest.h>

#include <future>
#include <thread>

#include "storage/caches/tileset_cache.h"
#include "tests/storage/blobs/far_folder.h"
#include "tests/storage/small_tileset.h"
#include "tests/support/temporary_folder.h"

namespace skyquilt::storage {
namespace {

TEST(SlowStore, HoldsUpNoOtherMapAndNobodyWhoHasTheOneBefore) {
  test::TemporaryFolder folder;
  const DataDir dir = *DataDir::Open(folder / "data");
  const auto db = *CatalogueDb::Open(dir.Catalogue());
  Catalogue catalogue(*db);
  const auto far = std::make_shared<test::FarFolder>(dir.root());
  TilesetCache cache(dir, catalogue, far, /*is_shared=*/true);
  const std::string slow = catalogue.AddFlight("slow", "{}", Now())->id;
  const std::string other = catalogue.AddFlight("other", "{}", Now())->id;
  for (const std::string& flight : {slow, other}) {
    PublishSmallTileset(dir, *db, flight, {{1, 0, 1, "one"}});
    ASSERT_EQ((*cache.Get(flight))->revision.revision, 1);
  }
  std::promise<void> gate;
  std::atomic<int> lists = 0;
  const auto opened = gate.get_future().share();
  far->before_list = [&](const std::string& prefix) {
    if (prefix.find(slow) == std::string::npos) return;
    ++lists;
    opened.wait();
  };
  for (const std::string& flight : {slow, other}) PublishSmallTileset(dir, *db, flight, {{1, 0, 1, "two"}});
  std::this_thread::sleep_for(TilesetCache::kFreshFor);
  std::future<std::int64_t> first =
      std::async(std::launch::async, [&] { return (*cache.Get(slow))->revision.revision; });
  while (lists == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  EXPECT_EQ((*cache.Get(other))->revision.revision, 2);
  EXPECT_EQ((*cache.Get(slow))->revision.revision, 1);
  EXPECT_EQ((*cache.Get(slow))->revision.revision, 1);
  gate.set_value();
  EXPECT_EQ(first.get(), 2);
  EXPECT_EQ((*cache.Get(slow))->revision.revision, 2);
  EXPECT_EQ(lists, 1);
  ASSERT_TRUE(catalogue.DeleteFlight(slow));
  std::this_thread::sleep_for(TilesetCache::kFreshFor);
  EXPECT_EQ(cache.Get(slow).error().code, ErrorCode::kNotFound);
}

// Whoever waits there for a store serves nobody else.
TEST(SlowStore, IsNotAskedByThreadsThatServeSockets) {
  test::TemporaryFolder folder;
  const DataDir dir = *DataDir::Open(folder / "data");
  const auto db = *CatalogueDb::Open(dir.Catalogue());
  Catalogue catalogue(*db);
  const std::string flight = catalogue.AddFlight("a", "{}", Now())->id;
  PublishSmallTileset(dir, *db, flight, {{1, 0, 1, "one"}});
  for (const bool is_shared : {false, true}) {
    const auto far = std::make_shared<test::FarFolder>(dir.root());
    int lists = 0;
    far->before_list = [&](const std::string&) { ++lists; };
    TilesetCache cache(dir, catalogue, far, is_shared);
    EXPECT_EQ(cache.AtHand(flight), nullptr);
    EXPECT_EQ(lists, 0);
    const std::int64_t shown = (*cache.Get(flight))->revision.revision;
    PublishSmallTileset(dir, *db, flight, {{1, 0, 1, "two"}});
    std::this_thread::sleep_for(TilesetCache::kFreshFor);
    EXPECT_EQ(cache.AtHand(flight), nullptr);  // a newer one may have to be opened
    EXPECT_EQ(lists, 1);
    EXPECT_EQ((*cache.Get(flight))->revision.revision, shown + 1);
  }
  TilesetCache here(dir, catalogue);
  EXPECT_EQ(here.AtHand(flight), nullptr);
  const std::int64_t shown = (*here.Get(flight))->revision.revision;
  PublishSmallTileset(dir, *db, flight, {{1, 0, 1, "three"}});
  std::this_thread::sleep_for(TilesetCache::kFreshFor);
  const auto newest = here.AtHand(flight);
  ASSERT_NE(newest, nullptr);
  EXPECT_EQ(newest->revision.revision, shown + 1);
  ASSERT_TRUE(catalogue.DeleteFlight(flight));
  std::this_thread::sleep_for(TilesetCache::kFreshFor);
  EXPECT_EQ(here.AtHand(flight), nullptr);
}

}  // namespace
}  // namespace skyquilt::storage
