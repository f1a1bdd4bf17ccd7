// StageCosts: the durations of the stages of finished jobs, from which the duration of the next one is
// predicted. Any thread. Errors: kUnavailable, kOutOfSpace, kIo.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "storage/db/catalogue_db.h"

namespace skyquilt::storage {

struct JobCost {
  std::string job_id;
  int photos = 0;
  std::vector<std::pair<std::string, double>> stages_s;  // in no order that matters
  double TotalS() const;
};

class StageCosts {
 public:
  explicit StageCosts(CatalogueDb& db) : db_(db) {}
  Result<void> Add(const JobCost& cost);
  // Newest first.
  Result<std::vector<JobCost>> Latest(int jobs) const;

 private:
  CatalogueDb& db_;
};

// Of a job of so many photos. By what a photo cost in the jobs before; the bar holds four in five of them.
struct Expectation {
  double total_s = 0.0;
  double low_s = 0.0;
  double high_s = 0.0;
  std::vector<std::pair<std::string, double>> shares;  // of each stage in the whole; their sum is one
};
// Nothing without jobs to go by.
std::optional<Expectation> ExpectationFrom(const std::vector<JobCost>& costs, int photos);

}  // namespace skyquilt::storage
