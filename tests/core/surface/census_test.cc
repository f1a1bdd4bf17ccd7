#include "core/surface/views/census.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <random>

namespace skyquilt::surface {
namespace {

constexpr CensusShape kShape{13, 9};

std::vector<std::uint8_t> RandomPatch(unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::uint8_t> patch(static_cast<std::size_t>(kShape.PatchColumns()) *
                                  (kShape.rows + 2 * kCensusRadius));
  for (std::uint8_t& gray : patch) gray = static_cast<std::uint8_t>(random() % 256);
  return patch;
}

std::vector<std::uint8_t> CensusOf(const std::vector<std::uint8_t>& patch) {
  std::vector<std::uint8_t> planes(kCensusPlanes * kShape.PlaneSize());
  FillCensus(patch.data(), patch.data(), kShape, planes.data());
  return planes;
}

// The neighbours of a cell that are brighter, in reading order.
std::vector<bool> Brighter(const std::vector<std::uint8_t>& patch, int column, int row) {
  const auto at = [&](int x, int y) {
    return patch[static_cast<std::size_t>(row + kCensusRadius + y) * kShape.PatchColumns() + column +
                 kCensusRadius + x];
  };
  std::vector<bool> bits;
  for (int y = -kCensusRadius; y <= kCensusRadius; ++y) {
    for (int x = -kCensusRadius; x <= kCensusRadius; ++x) {
      if (x != 0 || y != 0) bits.push_back(at(x, y) > at(0, 0));
    }
  }
  return bits;
}

struct SeenPicture {
  std::vector<std::uint8_t> planes;
  std::vector<std::uint8_t> unseen = std::vector<std::uint8_t>(kShape.PlaneSize(), 0);
  CensusView View() const { return {planes.data(), unseen.data()}; }
};

SeenPicture Picture(unsigned seed) { return {CensusOf(RandomPatch(seed))}; }

TEST(Census, HasABitForEachBrighterNeighbour) {
  const auto patch = RandomPatch(1);
  const auto planes = CensusOf(patch);
  for (int row = 0; row < kShape.rows; ++row) {
    for (int column = 0; column < kShape.columns; ++column) {
      const std::vector<bool> expected = Brighter(patch, column, row);
      for (std::size_t bit = 0; bit < kCensusBits; ++bit) {
        const std::uint8_t byte = planes[bit / 8 * kShape.PlaneSize() + kShape.IndexOf(column, row)];
        ASSERT_EQ((byte >> (bit % 8) & 1) != 0, expected[bit]) << column << " " << row << " " << bit;
      }
    }
  }
}

TEST(Census, DoesNotChangeWithTheLight) {
  std::vector<std::uint8_t> patch = RandomPatch(2);
  for (std::uint8_t& gray : patch) gray = static_cast<std::uint8_t>(gray / 3);
  std::vector<std::uint8_t> brighter = patch;
  for (std::uint8_t& gray : brighter) gray = static_cast<std::uint8_t>(2 * gray + 20);
  EXPECT_EQ(CensusOf(patch), CensusOf(brighter));
}

TEST(Census, CountsBitsThatDiffer) {
  const auto first = RandomPatch(3), second = RandomPatch(4);
  SeenPicture a{CensusOf(first)}, b{CensusOf(second)};
  b.unseen[kShape.IndexOf(4, 2)] = kNotCompared;
  std::vector<std::uint8_t> distances(kShape.PlaneSize());
  FillDistances(a.View(), b.View(), kShape.PlaneSize(), 0, kShape.PlaneSize(), distances.data());
  for (int row = 0; row < kShape.rows; ++row) {
    for (int column = 0; column < kShape.columns; ++column) {
      const std::vector<bool> here = Brighter(first, column, row), there = Brighter(second, column, row);
      int different = 0;
      for (std::size_t bit = 0; bit < kCensusBits; ++bit) different += here[bit] != there[bit] ? 1 : 0;
      const bool is_unseen = column == 4 && row == 2;
      EXPECT_EQ(distances[kShape.IndexOf(column, row)], is_unseen ? kNotCompared : different);
    }
  }
}

TEST(BetterHalf, CostsNothingWhereAllAgreeAndOneIsHidden) {
  const SeenPicture same = Picture(5), hidden = Picture(6);
  std::vector<std::uint8_t> costs(kShape.PlaneSize());
  BetterHalf(4).Fill({same.View(), same.View(), same.View(), hidden.View()}, kShape.PlaneSize(),
                     costs.data());
  for (int row = 0; row < kShape.rows; ++row) {
    for (int column = 0; column < kShape.columns; ++column) EXPECT_EQ(costs[kShape.IndexOf(column, row)], 0);
  }
}

TEST(BetterHalf, IsTwiceTheDistanceOfTwo) {
  const SeenPicture a = Picture(7), b = Picture(8);
  std::vector<std::uint8_t> distances(kShape.PlaneSize()), costs(kShape.PlaneSize());
  FillDistances(a.View(), b.View(), kShape.PlaneSize(), 0, kShape.PlaneSize(), distances.data());
  BetterHalf(2).Fill({a.View(), b.View()}, kShape.PlaneSize(), costs.data());
  for (std::size_t i = 0; i < kShape.Used(); ++i) EXPECT_EQ(costs[i], 2 * distances[i]);
}

TEST(BetterHalf, KnowsNothingWhereOneAloneSeesTheCell) {
  const SeenPicture a = Picture(9);
  SeenPicture b = Picture(10), c = Picture(11);
  std::fill(b.unseen.begin(), b.unseen.end(), kNotCompared);
  std::fill(c.unseen.begin(), c.unseen.end(), kNotCompared);
  std::vector<std::uint8_t> costs(kShape.PlaneSize());
  BetterHalf(3).Fill({a.View(), b.View(), c.View()}, kShape.PlaneSize(), costs.data());
  for (std::size_t i = 0; i < kShape.Used(); ++i) EXPECT_EQ(costs[i], BetterHalf::kMaxCost / 2);
}

TEST(CountAgreeing, CountsThoseAroundTheOneThatMostAgreeWith) {
  const SeenPicture same = Picture(12), other = Picture(13), third = Picture(14);
  std::vector<std::uint8_t> agreeing(kShape.PlaneSize());
  CountAgreeing({same.View(), other.View(), same.View(), same.View(), third.View()}, kShape.PlaneSize(), 3,
                agreeing.data());
  EXPECT_EQ(agreeing[kShape.IndexOf(6, 4)], 3);
  CountAgreeing({same.View(), other.View(), third.View()}, kShape.PlaneSize(), 3, agreeing.data());
  EXPECT_EQ(agreeing[kShape.IndexOf(6, 4)], 0);
}

}  // namespace
}  // namespace skyquilt::surface
