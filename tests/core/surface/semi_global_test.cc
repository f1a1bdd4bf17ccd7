#include "core/surface/paths/semi_global.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>

#include "core/surface/paths/pick_heights.h"

namespace skyquilt::surface {
namespace {

constexpr int kColumns = 9, kRows = 7;
constexpr int kNever = 100000;

class PlainPaths {
 public:
  PlainPaths(const HeightSheets& sheets, const SheetCosts& costs, const std::vector<std::uint8_t>& gray,
             const JumpPenalties& penalties)
      : sheets_(sheets), costs_(costs), gray_(gray), penalties_(penalties) {}

  // The sums of all eight paths, each followed from the border to the cell.
  std::vector<int> SumsAt(int column, int row) const {
    std::vector<int> sums(Costs(column, row).size(), 0);
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        if (dx == 0 && dy == 0) continue;
        const std::vector<int> path = Path(column, row, dx, dy);
        for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += path[i];
      }
    }
    return sums;
  }

 private:
  std::size_t Cell(int column, int row) const { return static_cast<std::size_t>(row) * kColumns + column; }
  std::vector<int> Costs(int column, int row) const {
    const std::size_t cell = Cell(column, row), heights = static_cast<std::size_t>(sheets_.heights);
    std::vector<int> costs;
    for (std::size_t i = 0; i < heights; ++i) costs.push_back(costs_.first[cell * heights + i]);
    if (sheets_.second[cell] >= 0) {
      for (std::size_t i = 0; i < kSheetHeights; ++i) {
        costs.push_back(costs_.second[static_cast<std::size_t>(sheets_.second[cell]) * kSheetHeights + i]);
      }
    }
    return costs;
  }
  std::vector<int> Path(int column, int row, int dx, int dy) const {
    const std::vector<int> own = Costs(column, row);
    const int from_column = column - dx, from_row = row - dy;
    if (from_row < 0 || from_row >= kRows) return own;
    const ColumnSpan span = sheets_.compared[static_cast<std::size_t>(from_row)];
    if (from_column < span.first || from_column >= span.end) return own;
    const std::vector<int> before = Path(from_column, from_row, dx, dy);
    const int least = *std::min_element(before.begin(), before.end());
    const std::size_t here = Cell(column, row), there = Cell(from_column, from_row);
    const int edge = std::min(std::abs(gray_[here] - gray_[there]), penalties_.whole_edge);
    const int jump = penalties_.most - edge * (penalties_.most - penalties_.least) / penalties_.whole_edge;
    std::vector<int> path;
    const int heights = sheets_.heights;
    for (int i = 0; i < static_cast<int>(own.size()); ++i) {
      const float low = i < heights ? sheets_.low_m[here] : sheets_.second_low_m[here];
      const int at = i < heights ? i : i - heights;
      int best = least + jump;
      for (int j = 0; j < static_cast<int>(before.size()); ++j) {
        const float other_low = j < heights ? sheets_.low_m[there] : sheets_.second_low_m[there];
        const int other_at = j < heights ? j : j - heights;
        const int steps = at + static_cast<int>(std::lround((low - other_low) / sheets_.step_m)) - other_at;
        const int penalty = steps == 0 ? 0 : std::abs(steps) == 1 ? penalties_.step : kNever;
        best = std::min(best, before[static_cast<std::size_t>(j)] + penalty);
      }
      path.push_back(own[static_cast<std::size_t>(i)] + best - least);
    }
    return path;
  }

  const HeightSheets& sheets_;
  const SheetCosts& costs_;
  const std::vector<std::uint8_t>& gray_;
  const JumpPenalties penalties_;
};

struct Volume {
  HeightSheets sheets;
  SheetCosts costs;
  std::vector<std::uint8_t> gray;
};

Volume RandomVolume(unsigned seed, int heights, bool with_second) {
  std::mt19937 random(seed);
  Volume volume;
  std::vector<float> ground_m;
  for (int i = 0; i < kColumns * kRows; ++i) ground_m.push_back(0.3f * static_cast<float>(random() % 20));
  volume.sheets = SheetsAbout(kColumns, kRows, ground_m, 2.0, 0.5, heights);
  if (with_second) {
    for (std::size_t cell = 0; cell < volume.sheets.Cells(); ++cell) {
      if (random() % 3 == 0) continue;
      volume.sheets.second[cell] = volume.sheets.second_count++;
      // Some join the first, others lie far above.
      volume.sheets.second_low_m[cell] =
          volume.sheets.low_m[cell] + 0.5f * static_cast<float>(kSheetHeights + random() % 40);
    }
  }
  const auto fill = [&](std::vector<std::uint8_t>& costs, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) costs.push_back(static_cast<std::uint8_t>(random() % 97));
  };
  fill(volume.costs.first, volume.sheets.Cells() * static_cast<std::size_t>(heights));
  fill(volume.costs.second, static_cast<std::size_t>(volume.sheets.second_count) * kSheetHeights);
  for (std::size_t i = 0; i < volume.sheets.Cells(); ++i) {
    volume.gray.push_back(static_cast<std::uint8_t>(random() % 64));
  }
  return volume;
}

void ExpectPlainSums(const Volume& volume) {
  const JumpPenalties penalties;
  SheetSums sums;
  sums.first.assign(3, 77);  // of an earlier block
  SumAlongPaths(volume.sheets, volume.costs, volume.gray, penalties, sums);
  const PlainPaths plain(volume.sheets, volume.costs, volume.gray, penalties);
  const std::size_t heights = static_cast<std::size_t>(volume.sheets.heights);
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      const ColumnSpan span = volume.sheets.compared[static_cast<std::size_t>(row)];
      if (column < span.first || column >= span.end) continue;
      const std::size_t cell = static_cast<std::size_t>(row) * kColumns + column;
      const std::vector<int> expected = plain.SumsAt(column, row);
      for (std::size_t i = 0; i < expected.size(); ++i) {
        const int sum =
            i < heights ? sums.first[cell * heights + i]
                        : sums.second[static_cast<std::size_t>(volume.sheets.second[cell]) * kSheetHeights +
                                      i - heights];
        ASSERT_EQ(sum, expected[i]) << column << " " << row << " height " << i;
      }
    }
  }
}

TEST(SumAlongPaths, IsThatOfPlainLoopsWithOneSheet) {
  ExpectPlainSums(RandomVolume(1, kSheetHeights, false));
}

TEST(SumAlongPaths, IsThatOfPlainLoopsWithLongSheets) {
  ExpectPlainSums(RandomVolume(2, 3 * kSheetHeights, false));
}

TEST(SumAlongPaths, IsThatOfPlainLoopsWithTwoSheets) {
  ExpectPlainSums(RandomVolume(3, kSheetHeights, true));
  ExpectPlainSums(RandomVolume(4, kSheetHeights, true));
}

TEST(SumAlongPaths, BeginsWhereCellsAreCompared) {
  Volume volume = RandomVolume(7, kSheetHeights, true);
  volume.sheets.compared = {{2, 5}, {0, 9}, {4, 4}, {6, 9}, {0, 2}, {1, 8}, {3, 4}};
  ASSERT_EQ(volume.sheets.compared.size(), static_cast<std::size_t>(kRows));
  ExpectPlainSums(volume);
}

// Costs of |height - true height|, of a plane that hardly climbs.
TEST(PickHeights, FindsWhatLiesBetweenSteps) {
  Volume volume = RandomVolume(5, kSheetHeights, false);
  volume.sheets =
      SheetsAbout(kColumns, kRows, std::vector<float>(kColumns * kRows, 10.0f), 4.0, 0.5, kSheetHeights);
  volume.costs.first.clear();
  const auto true_m = [](int column) { return 9.2 + 0.02 * column; };
  for (int cell = 0; cell < kColumns * kRows; ++cell) {
    for (int i = 0; i < kSheetHeights; ++i) {
      const double steps = std::abs(6.0 + 0.5 * i - true_m(cell % kColumns)) / 0.5;
      volume.costs.first.push_back(static_cast<std::uint8_t>(std::min(96.0, 20.0 * steps)));
    }
  }
  SheetSums sums;
  SumAlongPaths(volume.sheets, volume.costs, volume.gray, {}, sums);
  const PickedHeights picked = PickHeights(volume.sheets, volume.costs, sums);
  for (int cell = 0; cell < kColumns * kRows; ++cell) {
    const auto at = static_cast<std::size_t>(cell);
    EXPECT_NEAR(picked.heights_m[at], true_m(cell % kColumns), 0.05) << cell;
    EXPECT_GT(picked.margins[at], 100);
    EXPECT_GT(picked.contrasts[at], 30);
  }
}

TEST(PickHeights, LeavesWhatIsExpectedWhereNothingIsCompared) {
  Volume volume = RandomVolume(8, kSheetHeights, true);
  volume.sheets.compared.assign(kRows, {3, 6});
  SheetSums sums;
  SumAlongPaths(volume.sheets, volume.costs, volume.gray, {}, sums);
  const PickedHeights picked = PickHeights(volume.sheets, volume.costs, sums);
  for (std::size_t cell = 0; cell < volume.sheets.Cells(); ++cell) {
    if (cell % kColumns >= 3 && cell % kColumns < 6) continue;
    EXPECT_EQ(picked.heights_m[cell], volume.sheets.expected_m[cell]);
    EXPECT_EQ(picked.margins[cell], 0);
  }
}

// The first of equal sums, and of what is left the least beyond two steps of it.
TEST(PickHeights, TakesTheLeastSumAndSaysByHowMuch) {
  Volume volume = RandomVolume(9, 3 * kSheetHeights, false);
  SheetSums sums;
  SumAlongPaths(volume.sheets, volume.costs, volume.gray, {}, sums);
  const PickedHeights picked = PickHeights(volume.sheets, volume.costs, sums);
  const int heights = volume.sheets.heights;
  for (std::size_t cell = 0; cell < volume.sheets.Cells(); ++cell) {
    const auto first = sums.first.begin() + static_cast<std::ptrdiff_t>(cell) * heights;
    const auto least = std::min_element(first, first + heights);
    int others = 65535;
    for (auto other = first; other != first + heights; ++other) {
      if (std::abs(other - least) > 2) others = std::min<int>(others, *other);
    }
    EXPECT_EQ(picked.margins[cell], std::max(0, others - *least)) << cell;
    const float at_m =
        volume.sheets.low_m[cell] + volume.sheets.step_m * static_cast<float>(std::distance(first, least));
    EXPECT_NEAR(picked.heights_m[cell], at_m, 1.001f * volume.sheets.step_m) << cell;
  }
}

TEST(PickHeights, SaysWhereTheCellItselfShowsNothing) {
  Volume volume = RandomVolume(6, kSheetHeights, true);
  std::fill(volume.costs.first.begin(), volume.costs.first.end(), std::uint8_t{48});
  std::fill(volume.costs.second.begin(), volume.costs.second.end(), std::uint8_t{48});
  SheetSums sums;
  SumAlongPaths(volume.sheets, volume.costs, volume.gray, {}, sums);
  for (const std::uint8_t contrast : PickHeights(volume.sheets, volume.costs, sums).contrasts) {
    EXPECT_EQ(contrast, 0);
  }
}

}  // namespace
}  // namespace skyquilt::surface
