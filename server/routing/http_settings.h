// HttpSettings: where the server listens, and its limits. A value.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "server/routing/address_range.h"

namespace skyquilt::server {

struct HttpSettings {
  std::string address = "127.0.0.1";
  std::uint16_t port = 8080;                  // 0: any free one
  int threads = 2;                            // that serve sockets
  int read_threads = 4;                       // that read the catalogue and files
  int write_threads = 4;                      // that wait for the disk and for the catalogue's other writers
  int compute_threads = 2;                    // that make pictures, plans and verdicts
  std::size_t max_waiting = 64;               // requests for each kind of thread, beside those that run
  std::size_t max_of_client = 16;             // requests that wait or run, of one client and kind of thread
  std::vector<AddressRange> trusted_proxies;  // whose X-Forwarded headers are believed
  std::string public_url;  // "https://maps.example.org", for absolute links behind a proxy; empty: by Host
  std::string base_path;   // "/skyquilt": the path that it lies under at a proxy; empty: none
  std::vector<std::string> hosts;   // names that it goes by, besides those of loopback and the address
  bool always_checks_host = false;  // also where a token is asked for
  std::vector<std::string>
      cors_origins;  // whose pages may read answers; none: any, where a token is asked for
  std::chrono::seconds header_deadline{
      10};                                 // from the first byte of a request (or the connection) to its last
  std::chrono::seconds idle_deadline{60};  // between requests
  std::chrono::seconds slice_deadline{60};  // for each slice of a body, either way
  std::size_t max_header_bytes = 16 * 1024;
  std::uint64_t max_body_bytes = std::uint64_t{64} << 30;
  std::size_t max_connections = 8192;
  std::size_t connections_of_client = 256;  // 0: no bound
};

}  // namespace skyquilt::server
