// StreamedMaps: the files that the maps of a server are offered as without lying on its disk, laid out once
// and kept in memory within a bound of bytes, those not asked for longest going first. A map never changes,
// so that what was laid out of it stays right. Any thread. Errors: kNotFound (no such map any more), those of
// laying out.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "core/base/result.h"
#include "storage/blobs/lru_memory.h"
#include "storage/exports/streamed/streamed_file.h"

namespace skyquilt::storage {

enum class StreamedFormat { kPmtiles, kGeotiff };

// A streamed file with the tileset that its pieces are made from, which may be unlinked meanwhile.
struct OpenStreamed {
  std::shared_ptr<const StreamedFile> file;
  std::shared_ptr<MapTiles> tiles;
  std::string identity;  // equal ones are equal bytes; fit for an entity tag
  std::shared_ptr<const void> in_use =
      nullptr;  // what keeps the tileset's file where it is, if anything does
};

class StreamedMaps {
 public:
  static constexpr std::size_t kUsualBytes = std::size_t{64} << 20;

  explicit StreamedMaps(std::size_t budget_bytes = kUsualBytes) : files_(budget_bytes) {}
  // `map`: a name of this revision of this flight that no other map ever has.
  Result<OpenStreamed> Open(const std::filesystem::path& mbtiles, const std::string& map,
                            StreamedFormat format);

 private:
  LruMemory<StreamedFile> files_;
};

}  // namespace skyquilt::storage
