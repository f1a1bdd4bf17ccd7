#include "core/alignment/features/extract_all.h"

#include <atomic>
#include <utility>

#include "core/base/parallel_for.h"

namespace skyquilt::alignment {

std::vector<const PhotoFeatures*> Photographed::Readable() const {
  std::vector<const PhotoFeatures*> readable;
  for (std::size_t i = 0; i < features.size(); ++i) {
    readable.push_back(unreadable[i].empty() ? &features[i] : nullptr);
  }
  return readable;
}

Photographed ExtractAll(const poses::PosedFlight& posed, const flight::PhotoSource& source,
                        const FeatureOptions& options, FoundFeatures found, int threads, double last_fraction,
                        Progress& progress) {
  const std::size_t count = posed.photos.size();
  Photographed photographed{std::vector<PhotoFeatures>(count), std::vector<std::string>(count)};
  std::atomic<std::size_t> done{0};
  ParallelFor(count, threads, [&](std::size_t i) {
    if (progress.IsCancelled()) return;
    const flight::Photo& photo = posed.photos[i].photo;
    const auto known = found.find(photo.name);
    Result<PhotoFeatures> features =
        known != found.end() ? std::move(known->second) : ExtractFeatures(photo, source, options);
    if (features) {
      photographed.features[i] = *std::move(features);
    } else {
      photographed.unreadable[i] = features.error().message;
    }
    progress.Report(last_fraction * static_cast<double>(++done) / static_cast<double>(count),
                    "finding features");
  });
  return photographed;
}

}  // namespace skyquilt::alignment
