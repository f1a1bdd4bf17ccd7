#include "storage/jobs/map_products.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include "core/base/try.h"
#include "storage/blobs/range_cache.h"
#include "storage/blobs/sha256.h"
#include "storage/files/data_dir.h"
#include "storage/files/publish_file.h"

namespace skyquilt::storage {
namespace {

namespace fs = std::filesystem;

}  // namespace

Result<std::vector<MapProduct>> ProductsIn(const fs::path& folder) {
  std::vector<MapProduct> products;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    std::error_code unknown;
    if (!entry.is_regular_file(unknown)) continue;
    const std::string name = entry.path().filename().string();
    if (!IsReadByRanges(name)) {
      SKYQUILT_TRY_ASSIGN(std::string sha256, Sha256OfFile(entry.path()));
      products.push_back({name, std::move(sha256)});
      continue;
    }
    Sha256Sum whole, of_sums;
    SKYQUILT_TRY_ASSIGN(const std::string sums, RangeSumsOfFile(entry.path(), &whole));
    of_sums.Add(sums);
    products.push_back({name, whole.Finish()});
    products.push_back({RangeSumsKey(name), of_sums.Finish()});
  }
  if (error) return FileError("cannot read", folder, error.value());
  std::sort(products.begin(), products.end(),
            [](const MapProduct& a, const MapProduct& b) { return a.name < b.name; });
  return products;
}

Result<void> EnterProducts(SqlConnection& db, const std::string& flight_id, std::int64_t revision,
                           const std::vector<MapProduct>& products) {
  SKYQUILT_TRY_ASSIGN(Statement enter, db.Prepare("INSERT INTO product(flight_id,revision,name,sha256)"
                                                  " VALUES(?,?,?,?)"));
  for (const MapProduct& product : products) {
    SKYQUILT_TRY(enter.BindAll(flight_id, revision, product.name, product.sha256).Run());
  }
  return {};
}

Result<void> ForgetProducts(SqlConnection& db) { return db.Exec("DELETE FROM product"); }

Result<std::vector<MapProduct>> KnownProducts(CatalogueDb& db, const std::string& flight_id,
                                              std::int64_t revision) {
  const auto access = db.Read();
  return access->All(RowOf<MapProduct, std::string, std::string>,
                     "SELECT name, sha256 FROM product WHERE flight_id=? AND revision=? ORDER BY name",
                     flight_id, revision);
}

Result<std::optional<std::string>> PublishedSum(CatalogueDb& db, const std::string& key) {
  const std::optional<FlightBlob> blob = FlightBlobOf(key);
  const std::optional<std::int64_t> revision = blob ? RevisionOfFolder(blob->folder) : std::nullopt;
  if (!revision) return std::optional<std::string>();
  const bool is_below = blob->name.find('/') != std::string::npos;
  if (is_below && !blob->name.starts_with("ranges/")) return std::optional<std::string>();
  const auto access = db.Read();
  SKYQUILT_TRY_ASSIGN(Statement query,
                      access->Query("SELECT coalesce(max(CASE WHEN name=?3 THEN sha256 END), ''), count(*)"
                                    " FROM product WHERE flight_id=?1 AND revision=?2",
                                    blob->flight_id, *revision, blob->name));
  SKYQUILT_TRY(query.Step());
  if (query.ColumnInt64(1) == 0) return std::optional<std::string>();
  return std::optional<std::string>(query.ColumnText(0));
}

}  // namespace skyquilt::storage
