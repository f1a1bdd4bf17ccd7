#include "server/usage/catalogue_options.h"

#include <stdlib.h>

#include <CLI/CLI.hpp>

#include "server/terminal/fail.h"

namespace skyquilt::server {

std::pair<CLI::Option*, CLI::Option*> AddCatalogueOptions(CLI::App& command,
                                                          const CatalogueOptions& options) {
  CLI::Option* url = command.add_option(
      "--catalogue", options.url,
      "Where the catalogue and the queue lie: postgresql://USER@HOST/DATABASE, for several servers and workers on one "
      "catalogue (default: in the data folder)");
  CLI::Option* password_file = command.add_option(
      "--catalogue-password-file", options.password_file,
      "File with the password of --catalogue (default: PGPASSWORD, PGPASSFILE or ~/.pgpass)");
  return {url, password_file};
}

storage::CataloguePlace PlaceOf(const char* program, const std::string& url,
                                const std::string& password_file) {
  const Result<storage::CataloguePlace> place = storage::CataloguePlaceFrom(url, password_file);
  if (!place) Fail(program, place.error());
  return *place;
}

std::vector<std::string> WordsOfPlace(const storage::CataloguePlace& place) {
  if (!place.IsPostgres()) return {};
  if (!place.password.empty()) setenv("PGPASSWORD", place.password.c_str(), 1);
  std::string url = place.url;
  if (!place.schema.empty())
    url += (url.find('?') == std::string::npos ? "?schema=" : "&schema=") + place.schema;
  return {"--catalogue", url};
}

}  // namespace skyquilt::server
