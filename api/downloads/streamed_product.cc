#include "api/downloads/streamed_product.h"

#include <utility>

#include "api/downloads/send_file.h"
#include "core/base/try.h"

namespace skyquilt::api {
namespace {

class StreamedSource final : public BodySource {
 public:
  StreamedSource(const storage::OpenStreamed& streamed, std::uint64_t offset, std::uint64_t length)
      : in_use_(streamed.in_use), reader_(streamed.file, streamed.tiles, offset, length) {}
  std::uint64_t length() const override { return reader_.length(); }
  Result<std::size_t> Read(std::span<std::uint8_t> into) override { return reader_.Read(into); }

 private:
  const std::shared_ptr<const void> in_use_;
  storage::StreamedReader reader_;
};

}  // namespace

Result<storage::OpenStreamed> OpenStreamedProduct(Service& service, const std::string& prefix,
                                                  const std::string& name) {
  const bool is_pmtiles = name == kStreamedProducts[0];
  if (!is_pmtiles && name != kStreamedProducts[1])
    return Error{ErrorCode::kNotFound, "There is no such file.", prefix + name};
  SKYQUILT_TRY_ASSIGN(storage::LocalBlob tiles, service.store.blobs().Local(prefix + "mosaic.mbtiles"));
  // What is encoded anew may be encoded otherwise by another version.
  SKYQUILT_TRY_ASSIGN(storage::OpenStreamed streamed,
                      service.streamed_maps.Open(tiles.path, prefix + service.version,
                                                 is_pmtiles ? storage::StreamedFormat::kPmtiles
                                                            : storage::StreamedFormat::kGeotiff));
  streamed.in_use = std::move(tiles.in_use);
  return streamed;
}

Result<std::unique_ptr<BodySource>> ReadStreamed(const storage::OpenStreamed& streamed, std::uint64_t offset,
                                                 std::uint64_t length) {
  return std::unique_ptr<BodySource>(std::make_unique<StreamedSource>(streamed, offset, length));
}

Result<Response> SendStreamed(const Request& request, const storage::OpenStreamed& streamed,
                              const std::string& content_type) {
  return SendParts(
      request, streamed.file->length(), content_type, "\"" + streamed.identity + "\"",
      [&](std::uint64_t offset, std::uint64_t length) { return ReadStreamed(streamed, offset, length); });
}

}  // namespace skyquilt::api
