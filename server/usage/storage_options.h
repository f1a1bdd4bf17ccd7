// Where a server's data lies, if not in its folder, as options that several commands take: --catalogue with
// --catalogue-password-file (storage/db/postgres/catalogue_place), and --blobs with --cache-bytes for photos
// and maps. And the words that hand them on to a process that is started with them.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "storage/blobs/open_blobs.h"
#include "storage/db/postgres/catalogue_place.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace skyquilt::server {

// Where the two are kept; outlives the command line.
struct CatalogueOptions {
  std::string& url;
  std::string& password_file;
};
std::pair<CLI::Option*, CLI::Option*> AddCatalogueOptions(CLI::App& command, const CatalogueOptions& options);

// What they say. A mistake ends the command (Fail).
storage::CataloguePlace PlaceOf(const char* program, const std::string& url,
                                const std::string& password_file);
// The words by which a process that this one starts finds the same catalogue. A password goes by the
// environment (PGPASSWORD), never by a command line: called before there are threads.
std::vector<std::string> WordsOfPlace(const storage::CataloguePlace& place);

struct BlobOptions {
  CLI::Option* address;
  CLI::Option* cache_bytes;
};
BlobOptions AddBlobOptions(CLI::App& command, storage::BlobPlace& place);

std::vector<std::string> BlobWords(const storage::BlobPlace& place);

}  // namespace skyquilt::server
