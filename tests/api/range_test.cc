#include <gtest/gtest.h>

#include <string>

#include "api/http/conditional.h"

namespace skyquilt::api {
namespace {

struct Case {
  std::string header;
  std::uint64_t body;
  RangeKind kind;
  std::uint64_t first;
  std::uint64_t length;
};

class Ranges : public testing::TestWithParam<Case> {};

TEST_P(Ranges, AreReadAsTheStandardSays) {
  const ByteRange range = ParseRange(GetParam().header, GetParam().body);
  EXPECT_EQ(range.kind, GetParam().kind) << GetParam().header;
  if (range.kind == RangeKind::kPart) {
    EXPECT_EQ(range.first, GetParam().first) << GetParam().header;
    EXPECT_EQ(range.length, GetParam().length) << GetParam().header;
  }
}

constexpr RangeKind kWhole = RangeKind::kWhole;
constexpr RangeKind kPart = RangeKind::kPart;
constexpr RangeKind kBad = RangeKind::kUnsatisfiable;

INSTANTIATE_TEST_SUITE_P(
    ParseRange, Ranges,
    testing::Values(Case{"bytes=0-0", 10, kPart, 0, 1}, Case{"bytes=2-5", 10, kPart, 2, 4},
                    Case{"bytes=2-", 10, kPart, 2, 8}, Case{"bytes=-3", 10, kPart, 7, 3},
                    Case{"bytes=-30", 10, kPart, 0, 10},
                    Case{"bytes=5-99999999999999999999999", 10, kPart, 5, 5},
                    Case{"BYTES=1-1", 10, kPart, 1, 1}, Case{"bytes= 1-1 ", 10, kPart, 1, 1},
                    Case{"bytes=9-9", 10, kPart, 9, 1}, Case{"bytes=10-", 10, kBad, 0, 0},
                    Case{"bytes=99999999999999999999999-", 10, kBad, 0, 0}, Case{"bytes=-0", 10, kBad, 0, 0},
                    Case{"bytes=0-", 0, kBad, 0, 0}, Case{"bytes=-5", 0, kBad, 0, 0},
                    Case{"bytes=5-2", 10, kWhole, 0, 0}, Case{"bytes=0-0,2-3", 10, kWhole, 0, 0},
                    Case{"lines=0-1", 10, kWhole, 0, 0}, Case{"bytes", 10, kWhole, 0, 0},
                    Case{"bytes=", 10, kWhole, 0, 0}, Case{"bytes=-", 10, kWhole, 0, 0},
                    Case{"bytes=a-b", 10, kWhole, 0, 0}, Case{"bytes=+1-2", 10, kWhole, 0, 0},
                    Case{"bytes=1--2", 10, kWhole, 0, 0}, Case{"bytes=--1", 10, kWhole, 0, 0},
                    Case{"", 10, kWhole, 0, 0}));

}  // namespace
}  // namespace skyquilt::api
