#include "core/alignment/stages/extract_flight.h"

#include <utility>

#include "core/alignment/attempts/attempt_by_images.h"
#include "core/alignment/from_records/bundle_setup.h"
#include "core/alignment/from_records/gyro_lag.h"
#include "core/base/trace.h"

namespace skyquilt::alignment {
namespace {

constexpr double kLastFraction = 0.7;  // of the alignment's progress

}  // namespace

Error AlignmentCancelled() { return {ErrorCode::kCancelled, "the alignment was cancelled", ""}; }

Result<ExtractedFlight> ExtractFlight(const poses::PosedFlight& recorded, const flight::PhotoSource& source,
                                      const AlignOptions& options, FoundFeatures found, Progress& progress) {
  ExtractedFlight extracted = WithUnplaced(recorded);
  extracted.photographed = ExtractAll(extracted.posed, source, options.Features(), std::move(found),
                                      options.threads, kLastFraction, progress);
  if (progress.IsCancelled()) return AlignmentCancelled();
  extracted.readable = extracted.photographed.Readable();
  for (std::size_t i = 0; i < extracted.readable.size(); ++i) {
    TraceDecision(extracted.readable[i] ? "photo read" : "photo unreadable",
                  {{"photo", i}, {"keypoints", extracted.photographed.features[i].keypoints.size()}},
                  extracted.posed.photos[i].photo.name);
  }
  extracted.gyros = TieGyrosToRows(extracted.posed, extracted.readable, options.threads);
  std::vector<Eigen::Vector2d> places;
  for (const poses::PosedPhoto& photo : extracted.posed.photos) {
    places.push_back(photo.cam_from_enu.TargetOriginInSource().head<2>());
  }
  extracted.lines = FindLines(places);
  return extracted;
}

}  // namespace skyquilt::alignment
