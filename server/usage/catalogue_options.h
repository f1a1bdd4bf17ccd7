// --catalogue and --catalogue-password-file, which several commands take: where the catalogue lies, if not in
// the data folder (storage/db/postgres/catalogue_place).
#pragma once

#include <string>
#include <utility>
#include <vector>

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

}  // namespace skyquilt::server
