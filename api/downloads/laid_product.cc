#include "api/downloads/laid_product.h"

#include <utility>

#include "api/downloads/send_file.h"
#include "core/base/try.h"

namespace skyquilt::api {
namespace {

class LaidSource final : public BodySource {
 public:
  LaidSource(const storage::OpenLaid& laid, std::uint64_t offset, std::uint64_t length)
      : in_use_(laid.in_use), reader_(laid.file, laid.tiles, offset, length) {}
  std::uint64_t length() const override { return reader_.length(); }
  Result<std::size_t> Read(std::span<std::uint8_t> into) override { return reader_.Read(into); }

 private:
  const std::shared_ptr<const void> in_use_;
  storage::LaidReader reader_;
};

}  // namespace

Result<storage::OpenLaid> OpenLaidProduct(Service& service, const std::string& prefix,
                                          const std::string& name) {
  const bool is_pmtiles = name == kLaidProducts[0];
  if (!is_pmtiles && name != kLaidProducts[1])
    return Error{ErrorCode::kNotFound, "There is no such file.", prefix + name};
  SKYQUILT_TRY_ASSIGN(storage::LocalBlob tiles, service.store.blobs().Local(prefix + "mosaic.mbtiles"));
  // What is encoded anew may be encoded otherwise by another version.
  SKYQUILT_TRY_ASSIGN(
      storage::OpenLaid laid,
      service.laid_maps.Open(tiles.path, prefix + service.version,
                             is_pmtiles ? storage::LaidFormat::kPmtiles : storage::LaidFormat::kGeotiff));
  laid.in_use = std::move(tiles.in_use);
  return laid;
}

Result<std::unique_ptr<BodySource>> ReadLaid(const storage::OpenLaid& laid, std::uint64_t offset,
                                             std::uint64_t length) {
  return std::unique_ptr<BodySource>(std::make_unique<LaidSource>(laid, offset, length));
}

Result<Response> SendLaid(const Request& request, const storage::OpenLaid& laid,
                          const std::string& content_type) {
  return SendParts(
      request, laid.file->length(), content_type, "\"" + laid.identity + "\"",
      [&](std::uint64_t offset, std::uint64_t length) { return ReadLaid(laid, offset, length); });
}

}  // namespace skyquilt::api
