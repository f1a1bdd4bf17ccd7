#include "storage/db/ids.h"

#include <gtest/gtest.h>

namespace skyquilt::storage {
namespace {

TEST(Ids, SortInTheOrderTheyWereMadeHoweverFast) {
  std::string last = NewId();
  for (int i = 0; i < 20'000; ++i) {
    const std::string next = NewId();
    ASSERT_TRUE(IsId(next)) << next;
    ASSERT_LT(last, next);
    last = next;
  }
  for (const std::string& bad :
       {std::string(), std::string("../../etc/passwd0000000000"), last + "0", "A" + last.substr(1)})
    EXPECT_FALSE(IsId(bad)) << bad;
}

}  // namespace
}  // namespace skyquilt::storage
