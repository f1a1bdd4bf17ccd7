#include "storage/caches/preview_cache.h"

#include <utility>

#include "core/base/try.h"

namespace skyquilt::storage {

Result<std::shared_ptr<const OpenPreview>> PreviewCache::Get(const std::string& flight_id) {
  const auto now = std::chrono::steady_clock::now();
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(flight_id);
  if (found != entries_.end() && now - found->second.checked < kFreshFor) return found->second.open;
  SKYQUILT_TRY_ASSIGN(const std::optional<Preview> preview, previews_.Find(flight_id));
  if (!preview) {
    entries_.erase(flight_id);
    return Error{ErrorCode::kNotFound, "This flight has no preview.", ""};
  }
  std::shared_ptr<PreviewTiles> tiles;
  if (found != entries_.end() && found->second.open->preview.folder == preview->folder) {
    tiles = found->second.open->tiles;
  } else {
    SKYQUILT_TRY_ASSIGN(tiles, PreviewTiles::OpenToRead(dir_.Flight(flight_id) / preview->folder));
  }
  // The old ones are mostly of flights that have their maps: none is worth keeping.
  if (entries_.size() >= kMaxOpen) entries_.clear();
  auto open = std::make_shared<const OpenPreview>(OpenPreview{*preview, std::move(tiles)});
  entries_[flight_id] = {open, now};
  return open;
}

}  // namespace skyquilt::storage
