#include "server/routing/address_range.h"

#include <arpa/inet.h>

#include <algorithm>
#include <string>

#include "core/base/text/plain_text.h"

namespace skyquilt::server {
namespace {

constexpr int kMappedBits = 96;  // before the bits of an IPv4 address

}  // namespace

std::optional<AddressBytes> ParseAddress(std::string_view text) {
  // Of a link-local address the system says the network, too: fe80::1%eth0.
  const std::string address(text.substr(0, text.find('%')));
  AddressBytes bytes{};
  if (inet_pton(AF_INET6, address.c_str(), bytes.data()) == 1) return bytes;
  bytes = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff};
  if (inet_pton(AF_INET, address.c_str(), &bytes[12]) == 1) return bytes;
  return std::nullopt;
}

std::optional<AddressRange> AddressRange::From(std::string_view text) {
  const std::size_t slash = text.find('/');
  const std::string_view address = text.substr(0, slash);
  const std::optional<AddressBytes> first = ParseAddress(address);
  if (!first) return std::nullopt;
  AddressRange range{*first, 128};
  if (slash == std::string_view::npos) return range;
  const int before = address.find(':') == std::string_view::npos ? kMappedBits : 0;
  const std::optional<int> bits = ParseNumber<int>(text.substr(slash + 1));
  if (!bits || *bits < 0 || before + *bits > 128) return std::nullopt;
  range.bits = before + *bits;
  return range;
}

bool AddressRange::Contains(const AddressBytes& address) const {
  const auto whole = static_cast<std::size_t>(bits / 8);
  if (!std::equal(first.begin(), first.begin() + static_cast<std::ptrdiff_t>(whole), address.begin()))
    return false;
  const int rest = bits % 8;
  return rest == 0 || ((first[whole] ^ address[whole]) >> (8 - rest)) == 0;
}

}  // namespace skyquilt::server
