// What the queues know of units that were made from the same.
#include "storage/jobs/unit_inputs.h"

#include <fmt/format.h>

#include "storage/blobs/sha256.h"
#include "storage/jobs/unit_queue.h"

namespace skyquilt::storage {
namespace {

// Of a job named j that failed after ?1: what its units made serves one other, `but_for` itself. Whoever used
// it and failed as well may have failed by it, and whoever was cut since knows better.
std::string MayBeTakenOver(std::string_view but_for) {
  return fmt::format(
      " j.units_of=j.id AND j.state='failed' AND j.error_code<>'corrupt' AND j.finished_us>=?1 AND NOT EXISTS("
      "SELECT 1 FROM job n WHERE n.flight_id=j.flight_id AND n.id>j.id{} AND (n.state='successful' OR"
      " n.error_code='corrupt' OR n.units_of<>''))",
      but_for);
}

// With its length, so that "ab" and "c" are not "a" and "bc".
void AddText(Sha256Sum& sum, std::string_view text) {
  sum.Add(fmt::format("{}:", text.size()));
  sum.Add(text);
}

}  // namespace

std::string DigestOf(const UnitInputs& inputs) {
  Sha256Sum sum;
  AddText(sum, inputs.options);
  AddText(sum, fmt::format("{} {}", inputs.looks, inputs.files.size()));
  for (const StoredFile& file : inputs.files) {
    AddText(sum, file.name);
    AddText(sum, file.stored_name);
  }
  return fmt::format("{}:{}", inputs.version, sum.Finish());
}

Result<void> UnitQueue::MakeAs(const std::string& job_id, std::string_view version) {
  const auto db = db_.Lock();
  return db->Change("UPDATE job SET made_from='' WHERE id=?1 AND made_from<>'' AND made_from NOT LIKE ?2",
                    job_id, fmt::format("{}:%", version));
}

Result<std::optional<std::string>> UnitQueue::TakeOver(const Lease& lease, std::string_view made_from,
                                                       Time by_machine) {
  return db_.Again([&]() -> Result<std::optional<std::string>> {
    const auto db = db_.Lock();
    const Time now = db_.SharedTime(by_machine, *db);
    return db->First(
        FirstColumn<std::string>,
        std::string("UPDATE job SET made_from=?4, units_of=coalesce((SELECT j.units_of FROM job j WHERE"
                    " j.flight_id=job.flight_id AND j.id<>job.id AND j.made_from=?4 AND") +
            MayBeTakenOver(" AND n.id<>?2") +
            " ORDER BY j.id DESC LIMIT 1), id) WHERE id=?2 AND lease_token=?3 AND state='running'"
            " RETURNING units_of",
        ToUs(now - kUnitsKept), lease.job_id, lease.token, made_from);
  });
}

Result<std::string> UnitQueue::UnitsOf(const std::string& job_id) const {
  const auto db = db_.Read();
  return db->Text("SELECT units_of FROM job WHERE id=?", job_id);
}

Result<std::vector<std::string>> JobQueue::UnitsOfUse(Time by_machine) const {
  constexpr std::chrono::hours kLonger{1};  // so that nobody takes over what a sweep takes away
  const auto db = db_.Read();
  const Time now = db_.SharedTime(by_machine, *db);
  return db->AllText(std::string("SELECT DISTINCT j.units_of FROM job j WHERE (j.units_of<>''"
                                 " AND j.state IN ('accepted','running')) OR (") +
                         MayBeTakenOver("") + ")",
                     ToUs(now - kUnitsKept - kLonger));
}

}  // namespace skyquilt::storage
