#include "core/alignment/align_flight.h"

#include <utility>

#include "core/alignment/stages/attempt_steps.h"
#include "core/base/scoped_timer.h"
#include "core/base/try.h"

namespace skyquilt::alignment {

Result<AlignedFlight> AlignFlight(const poses::PosedFlight& recorded, const flight::PhotoSource& source,
                                  const AlignOptions& options, AlignReport& report, Progress& progress,
                                  FoundFeatures found) {
  report = {};
  ScopedTimer timer(report.total_s);
  SKYQUILT_TRY_ASSIGN(const ExtractedFlight extracted,
                      ExtractFlight(recorded, source, options, std::move(found), progress));
  SKYQUILT_TRY_ASSIGN(Attempt matched, MatchByRecords(extracted, options, progress));
  SKYQUILT_TRY_ASSIGN(Attempt placed, PlaceByEvidence(extracted, std::move(matched), options, progress));
  SKYQUILT_TRY_ASSIGN(AlignedFlight flight,
                      Conclude(extracted, FinishAttempt(std::move(placed), options, progress), report));
  progress.Report(1.0, "aligned");
  return flight;
}

}  // namespace skyquilt::alignment
