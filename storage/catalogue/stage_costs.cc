#include "storage/catalogue/stage_costs.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "core/base/median.h"
#include "core/base/try.h"

namespace skyquilt::storage {
namespace {

// A bar around the one job there is to go by.
constexpr double kMinSpread = 0.25;

double Quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(std::lround(share * static_cast<double>(values.size() - 1)))];
}

}  // namespace

double JobCost::TotalS() const {
  return std::accumulate(stages_s.begin(), stages_s.end(), 0.0,
                         [](double sum, const auto& stage) { return sum + stage.second; });
}

Result<void> StageCosts::Add(const JobCost& cost) {
  const auto db = db_.Lock();
  SKYQUILT_TRY_ASSIGN(Transaction transaction, Transaction::Begin(*db, cost.job_id));
  {
    SKYQUILT_TRY_ASSIGN(
        Statement insert,
        db->Prepare("INSERT INTO stage_cost VALUES(?,?,?,?) ON CONFLICT(job_id,stage) DO UPDATE SET"
                    " photos=excluded.photos, seconds=excluded.seconds"));
    for (const auto& [stage, seconds] : cost.stages_s) {
      SKYQUILT_TRY(insert.BindAll(cost.job_id, stage, cost.photos, seconds).Run());
    }
  }
  return transaction.Commit();
}

Result<std::vector<JobCost>> StageCosts::Latest(int jobs) const {
  const auto db = db_.Read();
  // Ids grow by time.
  SKYQUILT_TRY_ASSIGN(
      Statement query,
      db->Query("SELECT job_id, photos, stage, seconds FROM stage_cost WHERE job_id IN"
                " (SELECT DISTINCT job_id FROM stage_cost ORDER BY job_id DESC LIMIT ?) ORDER BY job_id DESC",
                jobs));
  std::vector<JobCost> costs;
  SKYQUILT_TRY(query.Each([&](const Statement& row) {
    if (costs.empty() || costs.back().job_id != row.ColumnText(0)) {
      costs.push_back({std::string(row.ColumnText(0)), static_cast<int>(row.ColumnInt64(1)), {}});
    }
    costs.back().stages_s.emplace_back(row.ColumnText(2), row.ColumnDouble(3));
  }));
  return costs;
}

std::optional<Expectation> ExpectationFrom(const std::vector<JobCost>& costs, int photos) {
  std::vector<double> a_photo_s;
  std::map<std::string, std::vector<double>> stages_s;
  for (const JobCost& cost : costs) {
    if (cost.photos < 1 || cost.TotalS() <= 0.0) continue;
    a_photo_s.push_back(cost.TotalS() / cost.photos);
    for (const auto& [stage, seconds] : cost.stages_s) stages_s[stage].push_back(seconds / cost.photos);
  }
  if (a_photo_s.empty()) return std::nullopt;
  Expectation expectation;
  const double usual_s = Median(a_photo_s);
  expectation.total_s = usual_s * photos;
  expectation.low_s = std::min(Quantile(a_photo_s, 0.1), usual_s * (1.0 - kMinSpread)) * photos;
  expectation.high_s = std::max(Quantile(a_photo_s, 0.9), usual_s * (1.0 + kMinSpread)) * photos;
  double sum = 0.0;
  for (auto& [stage, seconds] : stages_s) {
    expectation.shares.emplace_back(stage, Median(seconds));
    sum += expectation.shares.back().second;
  }
  if (sum <= 0.0) return std::nullopt;
  for (auto& [stage, share] : expectation.shares) share /= sum;
  return expectation;
}

}  // namespace skyquilt::storage
