#include "storage/folder/object_store/check_maps.h"

#include <fmt/format.h>

#include <algorithm>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/parallel_for.h"
#include "core/base/try.h"
#include "storage/blobs/sha256.h"
#include "storage/catalogue/catalogue.h"
#include "storage/jobs/map_products.h"

namespace skyquilt::storage {
namespace {

constexpr int kComparedSideBySide = 4;

// Under their keys.
Result<std::vector<MapProduct>> AllProducts(CatalogueDb& db, DataCheck& check) {
  const Catalogue catalogue(db);
  std::vector<MapProduct> all;
  SKYQUILT_TRY_ASSIGN(const std::vector<std::string> ids, catalogue.FlightIds());
  for (const std::string& id : ids) {
    SKYQUILT_TRY_ASSIGN(const std::vector<std::int64_t> revisions, catalogue.Revisions(id));
    for (const std::int64_t revision : revisions) {
      SKYQUILT_TRY_ASSIGN(std::vector<MapProduct> products, KnownProducts(db, id, revision));
      if (products.empty()) ++check.maps_without_sums;
      for (MapProduct& product : products)
        all.push_back({RevisionPrefix(id, revision) + product.name, std::move(product.sha256)});
    }
  }
  return all;
}

}  // namespace

Result<void> CheckMaps(CatalogueDb& db, BlobStore& blobs, DataCheck& check, Progress& progress) {
  SKYQUILT_TRY_ASSIGN(const std::vector<MapProduct> products, AllProducts(db, check));
  progress.BeginStage("compare");
  std::mutex mutex;
  std::optional<Error> failure;
  std::size_t done = 0;
  ParallelFor(products.size(), kComparedSideBySide, [&](std::size_t i) {
    {
      const std::lock_guard lock(mutex);
      if (!failure && progress.IsCancelled())
        failure = Error{ErrorCode::kCancelled, "The check was stopped.", ""};
      if (failure) return;
    }
    const std::string &key = products[i].name, &sha256 = products[i].sha256;
    const auto read = [&]() -> Result<std::string> {
      SKYQUILT_TRY_ASSIGN(const BlobInfo blob, blobs.Find(key));
      return Sha256OfBlob(blobs, blob);
    };
    const Result<std::string> sum = read();
    const std::lock_guard lock(mutex);
    if (!sum && sum.error().code == ErrorCode::kNotFound) {
      check.missing.push_back(key + " (of a map)");
    } else if (!sum && sum.error().code == ErrorCode::kCorrupt) {
      check.changed.push_back(fmt::format("{}: {}", key, sum.error().message));
    } else if (!sum) {
      if (!failure) failure = sum.error();
    } else if (*sum != sha256) {
      check.changed.push_back(fmt::format("{}: SHA-256 {} instead of {}", key, *sum, sha256));
    }
    ++done;
    progress.Report(static_cast<double>(done) / static_cast<double>(products.size()),
                    fmt::format("{} of {} files", done, products.size()));
  });
  if (failure) return *failure;
  std::sort(check.changed.begin(), check.changed.end());
  return {};
}

}  // namespace skyquilt::storage
