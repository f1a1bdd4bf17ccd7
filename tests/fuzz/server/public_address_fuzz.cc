// What a proxy says of how the server is reached, and targets below a base path.
#include <cstdint>
#include <string>

#include "core/base/check.h"
#include "server/routing/public_address.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace skyquilt::server;
  const std::string text(reinterpret_cast<const char*>(data), size);
  const std::size_t half = text.size() / 2;
  HttpSettings settings;
  settings.trusted_proxies.push_back(*AddressRange::From("10.0.0.0/8"));
  RequestHead head;
  settings.hosts = {text.substr(0, half)};
  head.host = "inner";
  head.headers.Add("X-Forwarded-Host", text.substr(0, half));
  head.headers.Add("X-Forwarded-Prefix", text.substr(half));
  const PublicAddress address = PublicAddressOf(head, "10.0.0.1", settings);
  SKYQUILT_CHECK(address.base_url.find_first_of("<>\"' \r\n?#") == std::string::npos, "not an address");
  SKYQUILT_CHECK(IsBasePath(address.base_path), "not a base path");
  (void)WithoutBasePath(text, address.base_path);
  return 0;
}
