#include "core/pipeline/check_photos.h"

#include <fmt/core.h>

#include <algorithm>
#include <atomic>
#include <utility>

#include "core/base/parallel_for.h"
#include "core/base/scoped_timer.h"
#include "core/base/trace.h"
#include "core/base/try.h"
#include "core/flight/remarks/because.h"

namespace skyquilt::pipeline {

namespace {

Result<CheckedPhoto> Check(const flight::Photo& photo, const flight::PhotoSource& source,
                           const std::optional<alignment::FeatureOptions>& features) {
  int denominator = render::ThumbnailDenominator(photo);
  if (features) denominator = std::min(denominator, alignment::DenominatorOf(photo, *features));
  double decode_s = 0.0;
  SKYQUILT_TRY_ASSIGN(const image::DecodedImage decoded, [&] {
    const TraceSpan span("decode small", photo.name);
    ScopedTimer timer(decode_s);
    return source.Decode(photo, denominator);
  }());
  const TraceSpan span("thumbnail and features", photo.name);
  CheckedPhoto checked{render::MakeThumbnail(photo, decoded), {}};
  if (!features) return checked;
  // A photo too small for features is a matter of the alignment, not of whether it is damaged.
  if (auto found = alignment::FeaturesOf(photo, decoded, *features)) {
    checked.features = *std::move(found);
    checked.features->decode_s = decode_s;
  }
  return checked;
}

}  // namespace

Result<CheckedFlight> CheckPhotos(flight::Flight flight, const flight::PhotoSource& source,
                                  const std::optional<alignment::FeatureOptions>& features, int threads,
                                  Progress& progress, CheckedPhotos known) {
  const std::size_t count = flight.photos.size();
  std::vector<std::optional<Result<CheckedPhoto>>> made(count);
  std::atomic<std::size_t> done{0};
  ParallelFor(count, threads, [&](std::size_t i) {
    if (progress.IsCancelled()) return;
    if (const auto found = known.find(flight.photos[i].name); found != known.end()) {
      made[i] = std::move(found->second);  // names are unique: no other thread takes this one
      ++done;
      return;
    }
    made[i] = Check(flight.photos[i], source, features);
    const std::size_t finished = ++done;
    progress.Report(static_cast<double>(finished) / static_cast<double>(count),
                    fmt::format("photo {} of {}", finished, count));
  });
  if (progress.IsCancelled()) return Error{ErrorCode::kCancelled, "The job was cancelled.", ""};
  std::vector<flight::Photo> photos = std::move(flight.photos);
  CheckedFlight checked;
  checked.flight = std::move(flight);  // the logs and all else as they are
  checked.flight.photos.clear();
  for (std::size_t i = 0; i < count; ++i) {
    if (made[i]->ok()) {
      checked.flight.photos.push_back(std::move(photos[i]));
      CheckedPhoto& one = **made[i];
      checked.thumbnails.push_back(std::move(one.thumbnail));
      if (one.features) checked.features.emplace(checked.flight.photos.back().name, *std::move(one.features));
    } else {
      checked.flight.left_out.push_back(
          {photos[i].name, made[i]->error().code, flight::WhyOf(made[i]->error())});
    }
  }
  return checked;
}

}  // namespace skyquilt::pipeline
