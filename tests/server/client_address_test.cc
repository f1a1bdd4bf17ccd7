#include "server/routing/client_address.h"

#include <gtest/gtest.h>

namespace skyquilt::server {
namespace {

std::string Of(const std::string& peer, const std::string& forwarded = "",
               const std::vector<std::string>& proxies = {}) {
  HttpSettings settings;
  for (const std::string& proxy : proxies) settings.trusted_proxies.push_back(*AddressRange::From(proxy));
  api::Headers headers;
  if (!forwarded.empty()) headers.Add("X-Forwarded-For", forwarded);
  return ClientAddress(peer, headers, settings);
}

TEST(ClientAddress, IsTheOtherEndOfTheConnection) {
  EXPECT_EQ(Of("192.0.2.7"), "192.0.2.7");
  EXPECT_EQ(Of("::ffff:192.0.2.7"), "192.0.2.7");
}

TEST(ClientAddress, HasNoShareOnThisMachine) {
  EXPECT_EQ(Of("127.0.0.1"), "");
  EXPECT_EQ(Of("127.0.0.2"), "");
  EXPECT_EQ(Of("::1"), "");
}

TEST(IsFromThisMachine, BelievesNoProxyOnIt) {
  EXPECT_TRUE(IsFromThisMachine("127.0.0.1", {}));
  EXPECT_TRUE(IsFromThisMachine("::1", {}));
  for (const char* peer : {"192.0.2.7", "::ffff:192.0.2.7", "", "x"})
    EXPECT_FALSE(IsFromThisMachine(peer, {})) << peer;
  for (const char* name : {"X-Forwarded-For", "x-forwarded-host", "Forwarded", "Via", "X-Real-IP",
                           "X-Forwarded-Proto", "x-forwarded-prefix"}) {
    EXPECT_FALSE(IsFromThisMachine("127.0.0.1", {{name, "x"}})) << name;
  }
}

TEST(ClientAddress, CountsAHouseholdOfIpv6AsOne) {
  EXPECT_EQ(Of("2001:db8:1:2:3:4:5:6"), Of("2001:db8:1:2:ffff::1"));
  EXPECT_NE(Of("2001:db8:1:2::1"), Of("2001:db8:1:3::1"));
}

TEST(ClientAddress, IsKnownOfANeighbourToo) {
  EXPECT_EQ(Of("fe80::1%eth0"), "fe80::1");
  EXPECT_EQ(Of("fe80::2%eth0"), "fe80::2");
  EXPECT_EQ(Of("fe80::1%2", "198.51.100.1", {"fe80::/10"}), "198.51.100.1");
}

TEST(ClientAddress, BelievesNoHeaderOfAStranger) {
  EXPECT_EQ(Of("192.0.2.7", "198.51.100.1"), "192.0.2.7");
  EXPECT_EQ(Of("127.0.0.1", "198.51.100.1"), "");
}

TEST(ClientAddress, BelievesATrustedProxyAsFarAsItKnows) {
  EXPECT_EQ(Of("127.0.0.1", "198.51.100.1", {"127.0.0.1"}), "198.51.100.1");
  // What stands before the last stranger anybody can have written.
  EXPECT_EQ(Of("127.0.0.1", "203.0.113.9, 198.51.100.1", {"127.0.0.1"}), "198.51.100.1");
  EXPECT_EQ(Of("127.0.0.1", "198.51.100.1, 192.0.2.50", {"127.0.0.1", "192.0.2.50"}), "198.51.100.1");
  EXPECT_EQ(Of("127.0.0.1", "198.51.100.1,nonsense", {"127.0.0.1"}), "");
  EXPECT_EQ(Of("192.0.2.50", "", {"192.0.2.50"}), "");  // for many: it would be bounded as one
}

TEST(ClientAddress, TrustsAWholeNetworkWhereToldTo) {
  EXPECT_EQ(Of("172.18.0.3", "198.51.100.1", {"172.16.0.0/12"}), "198.51.100.1");
  EXPECT_EQ(Of("172.32.0.3", "198.51.100.1", {"172.16.0.0/12"}), "172.32.0.3");
  EXPECT_EQ(Of("fd00::5", "198.51.100.1", {"fc00::/7"}), "198.51.100.1");
}

TEST(AddressRange, ContainsWhatSharesItsFirstBits) {
  const AddressRange range = *AddressRange::From("10.1.128.0/17");
  EXPECT_TRUE(range.Contains(*ParseAddress("10.1.255.255")));
  EXPECT_TRUE(range.Contains(*ParseAddress("::ffff:10.1.200.1")));
  EXPECT_FALSE(range.Contains(*ParseAddress("10.1.127.255")));
  EXPECT_FALSE(AddressRange::From("0.0.0.0/0")->Contains(*ParseAddress("2001:db8::1")));
  EXPECT_TRUE(AddressRange::From("::/0")->Contains(*ParseAddress("192.0.2.1")));
  EXPECT_TRUE(AddressRange::From("192.0.2.1")->Contains(*ParseAddress("192.0.2.1")));
  EXPECT_FALSE(AddressRange::From("192.0.2.1")->Contains(*ParseAddress("192.0.2.3")));
}

TEST(AddressRange, RefusesWhatIsNone) {
  for (const char* text : {"", "localhost", "1.2.3", "1.2.3.4:80", "[::1]", "256.0.0.1", "1.2.3.4/",
                           "1.2.3.4/33", "1.2.3.4/-1", "1.2.3.4/8x", "::1/129", "/8"}) {
    EXPECT_FALSE(AddressRange::From(text)) << text;
  }
}

}  // namespace
}  // namespace skyquilt::server
