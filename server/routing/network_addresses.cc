#include "server/routing/network_addresses.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <ifaddrs.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>

#include "server/routing/public_address.h"

namespace skyquilt::server {
namespace {

std::string AddressText(int family, const void* bytes) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  return inet_ntop(family, bytes, text.data(), text.size()) == nullptr ? "" : text.data();
}

// The address of this machine on the way to the rest of the world; "" without such a way. Nothing is sent.
std::string AddressOfMainRoute() {
  const int socket_fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (socket_fd < 0) return "";
  sockaddr_in there{};
  there.sin_family = AF_INET;
  there.sin_port = htons(9);
  inet_pton(AF_INET, "192.0.2.1", &there.sin_addr);  // of documentation (RFC 5737): nobody's
  sockaddr_in here{};
  socklen_t size = sizeof(here);
  const bool is_known = connect(socket_fd, reinterpret_cast<const sockaddr*>(&there), sizeof(there)) == 0 &&
                        getsockname(socket_fd, reinterpret_cast<sockaddr*>(&here), &size) == 0;
  close(socket_fd);
  return is_known ? AddressText(AF_INET, &here.sin_addr) : "";
}

bool IsForOthers(const std::string& address) {
  return address.find(':') == std::string::npos && !address.starts_with("127.") &&
         !address.starts_with("169.254.");
}

}  // namespace

bool IsLoopback(std::string_view address) { return address.starts_with("127.") || address == "::1"; }

std::string HostInUrl(const std::string& address) {
  return address.find(':') == std::string::npos ? address : "[" + address + "]";
}

std::vector<std::string> AddressesOfThisMachine() {
  std::vector<std::string> addresses;
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) return addresses;
  for (const ifaddrs* one = list; one != nullptr; one = one->ifa_next) {
    if (one->ifa_addr == nullptr) continue;
    const int family = one->ifa_addr->sa_family;
    if (family == AF_INET) {
      addresses.push_back(
          AddressText(family, &reinterpret_cast<const sockaddr_in*>(one->ifa_addr)->sin_addr));
    } else if (family == AF_INET6) {
      addresses.push_back(
          AddressText(family, &reinterpret_cast<const sockaddr_in6*>(one->ifa_addr)->sin6_addr));
    }
  }
  freeifaddrs(list);
  return addresses;
}

std::vector<std::string> NetworkHosts() {
  std::vector<std::string> hosts = AddressesOfThisMachine();
  std::erase_if(hosts, [](const std::string& host) { return !IsForOthers(host); });
  const auto main = std::find(hosts.begin(), hosts.end(), AddressOfMainRoute());
  if (main != hosts.end()) std::rotate(hosts.begin(), main, main + 1);
  return hosts;
}

std::vector<std::string> AddressesForOthers(const HttpSettings& settings, int port,
                                            bool is_from_this_machine) {
  if (!settings.public_url.empty()) return {PublicAddressOf({}, "", settings).base_url};
  std::vector<std::string> hosts = {settings.address};
  if (settings.address == "0.0.0.0" || settings.address == "::") {
    hosts = is_from_this_machine ? NetworkHosts() : std::vector<std::string>();
  } else if (IsLoopback(settings.address)) {
    hosts.clear();
  }
  std::vector<std::string> addresses;
  for (const std::string& host : hosts)
    addresses.push_back(fmt::format("http://{}:{}{}", HostInUrl(host), port, settings.base_path));
  return addresses;
}

}  // namespace skyquilt::server
