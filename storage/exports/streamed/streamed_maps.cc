#include "storage/exports/streamed/streamed_maps.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <utility>

#include "core/base/try.h"
#include "storage/exports/cog_writer.h"
#include "storage/exports/pmtiles_writer.h"
#include "storage/tilesets/mbtiles_reader.h"

namespace skyquilt::storage {

Result<OpenStreamed> StreamedMaps::Open(const std::filesystem::path& mbtiles, const std::string& map,
                                        StreamedFormat format) {
  const bool is_pmtiles = format == StreamedFormat::kPmtiles;
  const std::string name = map + (is_pmtiles ? "-pmtiles" : "-tif");
  SKYQUILT_TRY_ASSIGN(std::shared_ptr<MbtilesReader> tiles, MbtilesReader::Open(mbtiles));
  std::shared_ptr<const StreamedFile> file = files_.Find(name);
  if (file == nullptr) {
    SKYQUILT_TRY_ASSIGN(auto db, SqliteDb::Open(mbtiles, OpenMode::kReadOnlyImmutable));
    SKYQUILT_TRY_ASSIGN(file,
                        is_pmtiles ? LayOutPmtiles(db, tiles->metadata()) : LayOutCog(db, tiles->metadata()));
    files_.Keep(name, file, file->memory_bytes());
  }
  // The name may be of any characters.
  std::string identity =
      fmt::format("{:016x}-{:016x}", XXH3_64bits(name.data(), name.size()), file->digest());
  return OpenStreamed{std::move(file), std::move(tiles), std::move(identity)};
}

}  // namespace skyquilt::storage
