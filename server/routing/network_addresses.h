// NetworkAddresses: the IP addresses of this machine, and where other machines reach this server. Asks the
// system each time (a laptop changes its network while the server runs); empty where that fails. And what an
// address's text says by itself. Any thread.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "server/routing/http_settings.h"

namespace skyquilt::server {

// "127.0.0.1", "::1": only this machine itself gets there.
bool IsLoopback(std::string_view address);
// As addresses of the Web have it: IPv6 in brackets.
std::string HostInUrl(const std::string& address);

// As text, of all interfaces, that of loopback among them.
std::vector<std::string> AddressesOfThisMachine();

// Of those, as which other machines on the network know this one, the likeliest first.
std::vector<std::string> NetworkHosts();

// "http://192.168.1.20:8080/skyquilt", without a slash at the end, the likeliest first: what links begin with
// that are handed to others. The operator's --public-url alone where there is one; none where the server
// listens to its own machine alone, nor where it listens everywhere and is asked from another machine, which
// may come by the port of a container: the machine's own addresses lead nobody there.
std::vector<std::string> AddressesForOthers(const HttpSettings& settings, int port,
                                            bool is_from_this_machine);

}  // namespace skyquilt::server
