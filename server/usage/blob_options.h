// The options that say where photos and maps lie, for every command that has them: --blobs and --cache-bytes;
// and the words that hand them on to a process that is started with them.
#pragma once

#include <string>
#include <vector>

#include "storage/blobs/open_blobs.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace skyquilt::server {

struct BlobOptions {
  CLI::Option* address;
  CLI::Option* cache_bytes;
};
BlobOptions AddBlobOptions(CLI::App& command, storage::BlobPlace& place);

std::vector<std::string> BlobWords(const storage::BlobPlace& place);

}  // namespace skyquilt::server
