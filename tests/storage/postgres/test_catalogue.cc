#include "tests/storage/postgres/test_catalogue.h"

#include <cstdlib>

namespace skyquilt::storage {

bool TestsPostgres() { return std::getenv("SKYQUILT_TEST_POSTGRES") != nullptr; }

CataloguePlace TestPlace(const std::filesystem::path& path) {
  const char* url = std::getenv("SKYQUILT_TEST_POSTGRES");
  std::string schema = "t";
  // Of a path as test::TemporaryFolder makes it: /tmp/skyquilt_test_AbCdEf/catalogue.db; schemas have no
  // capitals.
  for (const char c : path.parent_path().filename().string() + path.filename().string()) {
    if (c >= 'A' && c <= 'Z') {
      schema += "_" + std::string(1, static_cast<char>(c - 'A' + 'a'));
    } else if ((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9')) {
      schema += c;
    }
  }
  return *CataloguePlaceFrom(std::string(url != nullptr ? url : "") + "&schema=" + schema.substr(0, 48));
}

Result<std::unique_ptr<CatalogueDb>> OpenTestCatalogue(const std::filesystem::path& path, int readers,
                                                       const std::string& node) {
  if (!TestsPostgres()) return CatalogueDb::Open(path, readers);
  return CatalogueDb::OpenPostgres(TestPlace(path), node, /*may_make=*/true, readers);
}

}  // namespace skyquilt::storage
