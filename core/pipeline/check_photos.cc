#include "core/pipeline/check_photos.h"

#include <fmt/core.h>

#include <atomic>
#include <optional>

#include "core/base/parallel_for.h"

namespace skyquilt::pipeline {

Result<CheckedFlight> CheckPhotos(flight::Flight flight, const PhotoSource& source, int threads, Progress& progress) {
  const std::size_t count = flight.photos.size();
  std::vector<std::optional<Result<render::Thumbnail>>> made(count);
  std::atomic<std::size_t> done{0};
  ParallelFor(count, threads, [&](std::size_t i) {
    if (progress.IsCancelled()) return;
    made[i] = render::MakeThumbnail(source, flight.photos[i]);
    const std::size_t finished = ++done;
    progress.Report(static_cast<double>(finished) / static_cast<double>(count),
                    fmt::format("photo {} of {}", finished, count));
  });
  if (progress.IsCancelled()) return Error{ErrorCode::kCancelled, "the job was cancelled", ""};
  std::vector<flight::Photo> photos = std::move(flight.photos);
  CheckedFlight checked;
  checked.flight = std::move(flight);  // the logs and all else as they are
  checked.flight.photos.clear();
  for (std::size_t i = 0; i < count; ++i) {
    if (made[i]->ok()) {
      checked.flight.photos.push_back(std::move(photos[i]));
      checked.thumbnails.push_back(**std::move(made[i]));
    } else {
      checked.flight.left_out.push_back({photos[i].name, made[i]->error().code, made[i]->error().message});
    }
  }
  return checked;
}

}  // namespace skyquilt::pipeline
