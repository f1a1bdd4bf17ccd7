// Named indices, colour ramps, and what values come to over an area.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "core/indices/band_expression.h"
#include "core/indices/colour_ramp.h"
#include "core/indices/spectral_index.h"
#include "core/indices/value_summary.h"

namespace skyquilt::indices {
namespace {

std::vector<std::string> NamesIn(const std::vector<const SpectralIndex*>& found) {
  std::vector<std::string> names;
  for (const SpectralIndex* index : found) names.emplace_back(index->name);
  return names;
}

TEST(SpectralIndexTest, EveryOneParsesAndHasARampAndARange) {
  for (const SpectralIndex& index : AllIndices()) {
    EXPECT_TRUE(BandExpression::Parse(index.expression)) << index.name;
    EXPECT_TRUE(ColourRamp::Named(index.ramp)) << index.name;
    EXPECT_LT(index.least, index.most) << index.name;
    EXPECT_EQ(FindIndex(index.name), &index);
  }
  EXPECT_EQ(FindIndex("NdVi")->title, "NDVI");
  EXPECT_EQ(FindIndex("ndv"), nullptr);
  EXPECT_EQ(FindIndex(""), nullptr);
}

TEST(SpectralIndexTest, BandsSayWhichCanBeMade) {
  EXPECT_EQ(NamesIn(IndicesOf({"red", "green", "blue"})), (std::vector<std::string>{"vari", "gli", "exg"}));
  EXPECT_EQ(NamesIn(IndicesOf({"green", "red", "rededge", "nir"})),
            (std::vector<std::string>{"ndvi", "ndre", "gndvi", "savi"}));
  EXPECT_EQ(NamesIn(IndicesOf({"lwir"})), (std::vector<std::string>{"celsius"}));
  EXPECT_TRUE(IndicesOf({"panchro"}).empty());
  EXPECT_TRUE(IndicesOf({}).empty());
}

TEST(ColourRampTest, GoesFromTheFirstColourToTheLast) {
  const ColourRamp ramp = *ColourRamp::Named("RdYlGn");
  EXPECT_EQ(ramp.At(0), (ColourRamp::Colour{0xa5, 0x00, 0x26}));
  EXPECT_EQ(ramp.At(255), (ColourRamp::Colour{0x00, 0x68, 0x37}));
  const ColourRamp turned = *ColourRamp::Named("rdylgn_r");
  for (int level = 0; level < ColourRamp::kLevels; ++level) EXPECT_EQ(turned.At(level), ramp.At(255 - level));
  // Published values of viridis at 0, 85 and 255 of 255.
  const ColourRamp viridis = *ColourRamp::Named("viridis");
  EXPECT_EQ(viridis.At(0), (ColourRamp::Colour{68, 1, 84}));
  const ColourRamp::Colour third = viridis.At(85);
  EXPECT_NEAR(third[0], 49, 2);
  EXPECT_NEAR(third[1], 104, 2);
  EXPECT_NEAR(third[2], 142, 2);
  EXPECT_FALSE(ColourRamp::Named("rainbow"));
  EXPECT_FALSE(ColourRamp::Named(""));
  EXPECT_FALSE(ColourRamp::Named("_r"));
  EXPECT_FALSE(ColourRamp::Named(std::string(10000, 'a')));
  for (const auto name : ColourRamp::Names()) EXPECT_TRUE(ColourRamp::Named(name)) << name;
}

TEST(ColourRampTest, ValuesBeyondTheRangeHaveItsEnds) {
  EXPECT_EQ(ColourRamp::LevelOf(-5, -1, 1), 0);
  EXPECT_EQ(ColourRamp::LevelOf(-1, -1, 1), 0);
  EXPECT_EQ(ColourRamp::LevelOf(0, -1, 1), 128);
  EXPECT_EQ(ColourRamp::LevelOf(1, -1, 1), 255);
  EXPECT_EQ(ColourRamp::LevelOf(1e30, -1, 1), 255);
}

TEST(ValueSummaryTest, CountsWhatNumpyCounts) {
  std::vector<float> values;
  for (int i = 0; i <= 100; ++i) values.push_back(static_cast<float>((i * 37) % 101));
  const ValueSummary summary = Summarise(values);
  EXPECT_EQ(summary.count, 101);
  EXPECT_EQ(summary.min, 0);
  EXPECT_EQ(summary.max, 100);
  EXPECT_DOUBLE_EQ(summary.mean, 50);
  EXPECT_DOUBLE_EQ(summary.std, std::sqrt(850.0));
  for (std::size_t i = 0; i < summary.percentiles.size(); ++i)
    EXPECT_DOUBLE_EQ(summary.percentiles[i], ValueSummary::kPercents[i]);
  std::int64_t counted = 0;
  for (const std::int64_t bin : summary.histogram) counted += bin;
  EXPECT_EQ(counted, 101);
  // numpy.percentile([1, 2, 4, 8], [25, 50]).
  const ValueSummary four = Summarise({8, 1, 4, 2});
  EXPECT_DOUBLE_EQ(four.percentiles[3], 1.75);
  EXPECT_DOUBLE_EQ(four.percentiles[4], 3.0);
}

TEST(ValueSummaryTest, TakesNothingAndTheSameAgain) {
  EXPECT_EQ(Summarise({}).count, 0);
  const ValueSummary same = Summarise(std::vector<float>(1000, 0.25f));
  EXPECT_EQ(same.std, 0);
  EXPECT_EQ(same.histogram[0], 1000);
  EXPECT_EQ(same.percentiles[8], 0.25);
}

TEST(QuantileBreaksTest, ClassesHaveAsManyValuesEach) {
  std::vector<float> values;
  for (int i = 0; i < 1000; ++i) values.push_back(static_cast<float>((i * 617) % 1000) / 1000.0f);
  const std::vector<double> breaks = QuantileBreaks(values, 5);
  ASSERT_EQ(breaks.size(), 4u);
  std::vector<int> counts(5, 0);
  for (const float value : values) ++counts[static_cast<std::size_t>(ClassOf(value, breaks))];
  for (const int count : counts) EXPECT_NEAR(count, 200, 1);
  EXPECT_TRUE(QuantileBreaks({}, 5).empty());
  EXPECT_TRUE(QuantileBreaks(std::vector<float>(10, 1.0f), 5).empty());  // one class
  // Most values are the same: no class is empty.
  EXPECT_EQ(QuantileBreaks({0, 0, 0, 0, 0, 0, 0, 1, 1, 1}, 4).size(), 1u);
  EXPECT_EQ(ClassOf(5, {}), 0);
}

}  // namespace
}  // namespace skyquilt::indices
