#include "server/webhooks/post_message.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netdb.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdint>
#include <cstring>
#include <memory>

#include "storage/blobs/curl_transfer.h"

namespace skyquilt::server {
namespace {

using storage::SetOption;

constexpr long kPatienceMs = 10'000;

struct FreeUrl {
  void operator()(CURLU* url) const { curl_url_cleanup(url); }
};

bool IsPublic(const in_addr& address) {
  const std::uint32_t bits = ntohl(address.s_addr);
  const auto within = [&](std::uint32_t network, int prefix) {
    return (bits ^ network) >> (32 - prefix) == 0;
  };
  constexpr std::pair<std::uint32_t, int> kNotPublic[] = {
      {0x00000000, 8},  {0x0a000000, 8},  {0x64400000, 10}, {0x7f000000, 8},  {0xa9fe0000, 16},
      {0xac100000, 12}, {0xc0000000, 24}, {0xc0000200, 24}, {0xc0a80000, 16}, {0xc6120000, 15},
      {0xc6336400, 24}, {0xcb007100, 24}, {0xe0000000, 3}};
  for (const auto& [network, prefix] : kNotPublic) {
    if (within(network, prefix)) return false;
  }
  return true;
}

// Only what is allotted to the public at large; everything else, and what carries an IPv4 address inside, is
// not.
bool IsPublic(const in6_addr& address) {
  const std::uint8_t* bytes = address.s6_addr;
  if ((bytes[0] & 0xe0) != 0x20) return false;             // 2000::/3
  if (bytes[0] == 0x20 && bytes[1] == 0x02) return false;  // 6to4
  if (bytes[0] != 0x20 || bytes[1] != 0x01) return true;
  const bool is_for_documents = bytes[2] == 0x0d && bytes[3] == 0xb8;
  return bytes[2] >= 0x02 && !is_for_documents;  // below: Teredo and other protocols
}

// `place`: of a sockaddr of this family.
bool IsPublic(int family, const void* place) {
  if (family == AF_INET) {
    sockaddr_in address{};
    std::memcpy(&address, place, sizeof(address));
    return IsPublic(address.sin_addr);
  }
  if (family != AF_INET6) return false;
  sockaddr_in6 address{};
  std::memcpy(&address, place, sizeof(address));
  return IsPublic(address.sin6_addr);
}

// Of what a connection is about to be made to.
struct Gate {
  bool may_go_private = false;
  bool has_refused = false;
};

// libcurl asks for each socket with the very address that it will connect to.
curl_socket_t OpenIfAllowed(void* gate_of, curlsocktype, curl_sockaddr* to) {
  auto& gate = *static_cast<Gate*>(gate_of);
  // curl_sockaddr ends with a short sockaddr, behind which libcurl keeps the rest of a longer one.
  const char* place = reinterpret_cast<const char*>(to) + offsetof(curl_sockaddr, addr);
  if (!gate.may_go_private && !IsPublic(to->family, place)) {
    gate.has_refused = true;
    return CURL_SOCKET_BAD;
  }
  return socket(to->family, to->socktype | SOCK_CLOEXEC, to->protocol);
}

// The answer's status is enough: its body ends the transfer.
std::size_t TakeNoBody(char*, std::size_t, std::size_t, void*) { return 0; }

// Empty where the address has none.
std::string HostOf(const std::string& address) {
  const std::unique_ptr<CURLU, FreeUrl> url(curl_url());
  char* host = nullptr;
  if (curl_url_set(url.get(), CURLUPART_URL, address.c_str(), 0) != CURLUE_OK ||
      curl_url_get(url.get(), CURLUPART_HOST, &host, 0) != CURLUE_OK) {
    return "";
  }
  std::string copy = host;
  curl_free(host);
  return copy;
}

}  // namespace

Result<void> CheckReceiver(const std::string& url) {
  const std::string written = HostOf(url);
  if (written.empty()) return Error{ErrorCode::kUnprocessable, "The address has no host.", url};
  std::string host = written;
  if (host.front() == '[') host = host.substr(1, host.find_first_of("%]") - 1);
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  // A name that is not known now may be when there is something to tell, and is looked at then.
  if (getaddrinfo(host.c_str(), nullptr, &hints, &found) != 0) return {};
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> owner(found, &freeaddrinfo);
  for (const addrinfo* one = found; one != nullptr; one = one->ai_next) {
    if (IsPublic(one->ai_family, one->ai_addr)) return {};
  }
  return Error{
      ErrorCode::kUnprocessable,
      fmt::format(
          "{} leads to a private address, which this server tells nothing. Its operator changes that with "
          "serve --webhooks any.",
          written)};
}

Result<void> PostMessage(const OutgoingMessage& message) {
  const std::string host = HostOf(message.url);
  if (host.empty()) return Error{ErrorCode::kInvalidArgument, "The address has no host.", message.url};
  const storage::CurlTransfer owner = storage::NewTransfer();
  CURL* transfer = owner.get();
  const storage::CurlHeaders headers = storage::CurlHeadersOf(message.headers);
  Gate gate{message.may_go_private};
  storage::CurlWords said{};
  storage::SetUsualOptions(transfer, message.url, headers, said);
  SetOption(transfer, CURLOPT_PROXY, "");  // the environment's would stand between the check and the receiver
  SetOption(transfer, CURLOPT_HTTP_VERSION, static_cast<long>(CURL_HTTP_VERSION_1_1));
  SetOption(transfer, CURLOPT_POST, 1L);
  SetOption(transfer, CURLOPT_POSTFIELDSIZE_LARGE, static_cast<curl_off_t>(message.body.size()));
  SetOption(transfer, CURLOPT_POSTFIELDS, message.body.c_str());
  SetOption(transfer, CURLOPT_OPENSOCKETFUNCTION, &OpenIfAllowed);
  SetOption(transfer, CURLOPT_OPENSOCKETDATA, &gate);
  SetOption(transfer, CURLOPT_WRITEFUNCTION, &TakeNoBody);
  SetOption(transfer, CURLOPT_TIMEOUT_MS, kPatienceMs);
  const CURLcode sent = curl_easy_perform(transfer);
  long status = 0;
  curl_easy_getinfo(transfer, CURLINFO_RESPONSE_CODE, &status);
  if (status == 0) {
    if (gate.has_refused)
      return Error{ErrorCode::kForbidden, fmt::format("{} leads to a private address.", host)};
    const std::string why = storage::CurlWordsOf(said, sent);
    if (sent == CURLE_OPERATION_TIMEDOUT)
      return Error{ErrorCode::kUnavailable, fmt::format("{} did not answer in time.", host), why};
    return Error{ErrorCode::kUnavailable, fmt::format("{} did not answer.", host), why};
  }
  if (status < 200 || status > 299)
    return Error{ErrorCode::kUnavailable, fmt::format("{} answered {}.", host, status)};
  return {};
}

}  // namespace skyquilt::server
