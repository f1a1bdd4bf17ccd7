// Where a server's data lies, if not in its folder, as options that several commands take: --catalogue with
// --catalogue-password-file (storage/db/postgres/catalogue_place), and --blobs with --cache-bytes for photos
// and maps. And the words that hand them on to a process that is started with them.
#pragma once

#include <string>
#include <vector>

#include "storage/blobs/open_blobs.h"
#include "storage/db/postgres/catalogue_place.h"

namespace CLI {
class App;
}

namespace skyquilt::server {

struct CatalogueOptions {
  std::string url;  // empty: in the data folder
  std::string password_file;
};
// `options` outlives the command line.
void AddCatalogueOptions(CLI::App& command, CatalogueOptions& options);

// What they say. A mistake ends the command (Fail).
storage::CataloguePlace PlaceOf(const char* program, const CatalogueOptions& options);
// The words by which a process that this one starts finds the same catalogue. A password goes by the
// environment (PGPASSWORD), never by a command line: called before there are threads.
std::vector<std::string> WordsOfPlace(const storage::CataloguePlace& place);

// `place` outlives the command line. The address alone is for who reads and writes none of them.
void AddBlobAddress(CLI::App& command, storage::BlobPlace& place);
void AddBlobOptions(CLI::App& command, storage::BlobPlace& place);
std::vector<std::string> BlobWords(const storage::BlobPlace& place);

}  // namespace skyquilt::server
