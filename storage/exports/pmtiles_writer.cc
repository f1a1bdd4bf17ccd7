#include "storage/exports/pmtiles_writer.h"

#include <memory>
#include <string>

#include "core/base/try.h"
#include "storage/db/sqlite_db.h"
#include "storage/exports/streamed/streamed_pmtiles.h"
#include "storage/files/stream_file.h"
#include "storage/tilesets/mbtiles_reader.h"

namespace skyquilt::storage {

Result<void> WritePmtiles(const std::filesystem::path& mbtiles, const std::filesystem::path& path,
                          Progress& progress) {
  SKYQUILT_TRY_ASSIGN(auto db, SqliteDb::Open(mbtiles, OpenMode::kReadOnlyImmutable));
  SKYQUILT_TRY_ASSIGN(const std::shared_ptr<const StreamedFile> streamed, LayOutPmtiles(db));
  SKYQUILT_TRY_ASSIGN(const auto tiles, MbtilesReader::Open(mbtiles));
  SKYQUILT_TRY_ASSIGN(auto file, StreamFile::Create(path));
  file->Write(streamed->head());
  for (std::size_t i = 0; i < streamed->PieceCount(); ++i) {
    if (progress.IsCancelled()) return Error{ErrorCode::kCancelled, "The job was cancelled.", ""};
    SKYQUILT_TRY_ASSIGN(const std::string bytes, streamed->MakePiece(i, *tiles));
    file->Write(bytes);
    progress.Report(static_cast<double>(i + 1) / static_cast<double>(streamed->PieceCount()),
                    "writing PMTiles");
  }
  return file->Publish();
}

}  // namespace skyquilt::storage
