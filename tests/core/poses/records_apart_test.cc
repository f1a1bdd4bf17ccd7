// How far surveyed points may put a flight from where its photos were recorded.
#include "core/poses/evidence/records_apart.h"

#include <gtest/gtest.h>

namespace skyquilt::poses {
namespace {

struct Records {
  std::vector<flight::RecordedPosition> records;
  std::vector<RecordedResidual> residuals;

  explicit Records(std::size_t count) : records(count) {
    for (std::size_t i = 0; i < count; ++i) records[i].position = {46.8, 7.1 + 1e-4 * static_cast<double>(i)};
  }
  std::optional<RecordsApart> Apart(const Eigen::Vector2d& by_m) {
    residuals.clear();
    for (const flight::RecordedPosition& record : records) residuals.push_back({by_m, &record});
    return RecordsApartOf(residuals);
  }
};

TEST(RecordsApartOf, IsAContradictionBeyondWhatReceiversErrBy) {
  Records plain(8);
  EXPECT_FALSE(plain.Apart({6.0, 6.0})->IsContradiction());
  EXPECT_TRUE(plain.Apart({-20.0, 0.0})->IsContradiction());
  EXPECT_FALSE(plain.Apart({800.0, 0.0})->IsElsewhere()) << "a datum taken for another";
  EXPECT_TRUE(plain.Apart({0.0, 1200.0})->IsElsewhere());
  Records poor(8);
  for (auto& record : poor.records) record.sigma_horizontal_m = 8.0;
  EXPECT_FALSE(poor.Apart({-20.0, 0.0})->IsContradiction()) << "they say that they are poor";
  Records fixed(8);
  for (auto& record : fixed.records) record.is_rtk_fixed = true;
  EXPECT_FALSE(fixed.Apart({0.3, 0.0})->IsContradiction());
  EXPECT_TRUE(fixed.Apart({2.0, 0.0})->IsContradiction());
}

TEST(RecordsApartOf, IsNotMisledByAFewAndSaysNothingOfFewer) {
  Records records(8);
  records.Apart({1.0, 0.0});
  records.residuals[3].residual_m = {5000.0, 0.0};
  EXPECT_LT(RecordsApartOf(records.residuals)->apart_m.norm(), 2.0);
  Records two(2);
  EXPECT_FALSE(two.Apart({500.0, 0.0}));
}

// A receiver that repeats its last fix says nothing of where the flight went from there.
TEST(RecordsApartOf, TakesNothingFromPhotosThatShareOnePosition) {
  Records stale(8);
  for (auto& record : stale.records) record.position = stale.records.front().position;
  EXPECT_FALSE(stale.Apart({40.0, 0.0}));
  Records moved_on(8);
  for (auto& record : moved_on.records) record.is_repeated = true;
  EXPECT_FALSE(moved_on.Apart({40.0, 0.0})) << "guessed from a fix of before";
}

}  // namespace
}  // namespace skyquilt::poses
