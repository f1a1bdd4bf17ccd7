#include "storage/blobs/lru_memory.h"

#include <gtest/gtest.h>

namespace skyquilt::storage {
namespace {

std::shared_ptr<const std::string> TextOf(std::size_t bytes) {
  return std::make_shared<const std::string>(bytes, 'x');
}

TEST(LruMemory, IsBoundedByBytesAndForgetsWhatWasUsedLeastRecently) {
  LruMemory<std::string> memory(100);
  memory.Keep("a", TextOf(40), 40);
  memory.Keep("b", TextOf(40), 40);
  EXPECT_TRUE(memory.Find("a"));
  memory.Keep("c", TextOf(40), 40);
  EXPECT_FALSE(memory.Has("b"));
  EXPECT_TRUE(memory.Has("a"));
  EXPECT_EQ(memory.bytes(), 80U);
  for (int i = 0; i < 1'000; ++i) memory.Keep(std::to_string(i), TextOf(1), 30);
  EXPECT_LE(memory.bytes(), 100U);
}

TEST(LruMemory, KeepsTheLatestAloneWhereItIsLargerThanTheBound) {
  LruMemory<std::string> memory(100);
  memory.Keep("a", TextOf(1), 1);
  const auto held = memory.Find("a");
  memory.Keep("large", TextOf(500), 500);
  EXPECT_TRUE(memory.Has("large"));
  EXPECT_FALSE(memory.Has("a"));
  EXPECT_EQ(*held, "x");  // who has it keeps it
  memory.Keep("b", TextOf(1), 1);
  EXPECT_EQ(memory.bytes(), 1U);
  EXPECT_EQ(memory.Find("never"), nullptr);
}

}  // namespace
}  // namespace skyquilt::storage
