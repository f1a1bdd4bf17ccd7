// The bytes of resumable uploads where photos lie elsewhere than in the data folder: chunks, each a blob of
// its own below uploads/, put before the catalogue says that its bytes have come. The catalogue's row lists
// them in order ("<key>:<bytes>;..."), so that any machine goes on with an upload, and that of two which
// write the same bytes at once only one counts. Any thread. Errors: kCorrupt, kOutOfSpace, kIo, those of the
// blobs.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "storage/blobs/blob_store.h"
#include "storage/db/catalogue_db.h"

namespace skyquilt::storage {

struct UploadChunk {
  std::string key;
  std::int64_t bytes = 0;
};

// A key that no chunk had, for bytes of an upload from `offset` on.
std::string NewChunkKey(const std::string& upload_id, std::int64_t offset);
std::string ChunksText(const std::vector<UploadChunk>& chunks);
Result<std::vector<UploadChunk>> ParseChunks(std::string_view text);

// An upload that came at once is its flight's file already, under this stored name: "=<stored name>".
std::string WholeText(const std::string& stored_name);
// Empty: it is in chunks.
std::string WholeIn(std::string_view text);

// Chunks that no row lists, and that are older than `age` by the store's own clock; how many went.
Result<int> SweepChunks(CatalogueDb& db, BlobStore& blobs, std::chrono::seconds age);

}  // namespace skyquilt::storage
