#include "storage/jobs/map_products.h"

#include <algorithm>
#include <charconv>
#include <string_view>
#include <system_error>
#include <utility>

#include "core/base/try.h"
#include "storage/blobs/range_cache.h"
#include "storage/blobs/sha256.h"
#include "storage/tilesets/publish_file.h"

namespace skyquilt::storage {
namespace {

namespace fs = std::filesystem;

// "flights/<id>/r7/mosaic.tif", taken apart.
struct ProductKey {
  std::string flight_id;
  std::int64_t revision = 0;
  std::string name;
};

std::optional<ProductKey> ProductOf(std::string_view key) {
  constexpr std::string_view kFlights = "flights/", kSums = "ranges/";
  if (!key.starts_with(kFlights)) return std::nullopt;
  key.remove_prefix(kFlights.size());
  const std::size_t id_end = key.find('/');
  if (id_end == std::string_view::npos) return std::nullopt;
  const std::string_view rest = key.substr(id_end + 1);
  const std::size_t folder_end = rest.find('/');
  if (folder_end == std::string_view::npos || folder_end < 2 || rest[0] != 'r') return std::nullopt;
  ProductKey product{std::string(key.substr(0, id_end)), 0, std::string(rest.substr(folder_end + 1))};
  const char* const end = rest.data() + folder_end;
  const auto parsed = std::from_chars(rest.data() + 1, end, product.revision);
  if (parsed.ec != std::errc() || parsed.ptr != end) return std::nullopt;
  const bool is_below = product.name.find('/') != std::string::npos;
  if (is_below && !product.name.starts_with(kSums)) return std::nullopt;
  return product;
}

}  // namespace

Result<std::vector<MapProduct>> ProductsIn(const fs::path& folder) {
  std::vector<MapProduct> products;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    std::error_code unknown;
    if (!entry.is_regular_file(unknown)) continue;
    const std::string name = entry.path().filename().string();
    SKYQUILT_TRY_ASSIGN(std::string sha256, Sha256OfFile(entry.path()));
    products.push_back({name, std::move(sha256)});
    if (!IsReadByRanges(name)) continue;
    SKYQUILT_TRY_ASSIGN(const std::string sums, RangeSumsOfFile(entry.path()));
    Sha256Sum sum;
    sum.Add(sums);
    products.push_back({RangeSumsKey(name), sum.Finish()});
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
    enter.Bind(1, flight_id).Bind(2, revision).Bind(3, product.name);
    SKYQUILT_TRY(enter.Bind(4, product.sha256).Run());
  }
  return {};
}

Result<void> ForgetProducts(SqlConnection& db) { return db.Exec("DELETE FROM product"); }

Result<std::vector<MapProduct>> KnownProducts(CatalogueDb& db, const std::string& flight_id,
                                              std::int64_t revision) {
  const auto access = db.Read();
  SKYQUILT_TRY_ASSIGN(
      Statement query,
      access->Prepare("SELECT name, sha256 FROM product WHERE flight_id=? AND revision=? ORDER BY name"));
  query.Bind(1, flight_id).Bind(2, revision);
  std::vector<MapProduct> products;
  while (true) {
    SKYQUILT_TRY_ASSIGN(const bool row, query.Step());
    if (!row) return products;
    products.push_back({std::string(query.ColumnText(0)), std::string(query.ColumnText(1))});
  }
}

Result<std::optional<std::string>> PublishedSum(CatalogueDb& db, const std::string& key) {
  const std::optional<ProductKey> product = ProductOf(key);
  if (!product) return std::optional<std::string>();
  const auto access = db.Read();
  SKYQUILT_TRY_ASSIGN(Statement query,
                      access->Prepare("SELECT coalesce(max(CASE WHEN name=?3 THEN sha256 END), ''), count(*)"
                                      " FROM product WHERE flight_id=?1 AND revision=?2"));
  query.Bind(1, product->flight_id).Bind(2, product->revision).Bind(3, product->name);
  SKYQUILT_TRY(query.Step());
  if (query.ColumnInt64(1) == 0) return std::optional<std::string>();
  return std::optional<std::string>(query.ColumnText(0));
}

}  // namespace skyquilt::storage
