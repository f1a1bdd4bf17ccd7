// How the server is named in its answers, behind proxies that are trusted and others.
#include "server/routing/public_address.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "server/routing/network_addresses.h"

namespace skyquilt::server {
namespace {

RequestHead Head(std::initializer_list<std::pair<const char*, const char*>> headers) {
  RequestHead head;
  head.host = "inner:8080";
  for (const auto& [name, value] : headers) head.headers.Add(name, value);
  return head;
}

HttpSettings Trusting() {
  HttpSettings settings;
  settings.trusted_proxies.push_back(*AddressRange::From("10.0.0.0/8"));
  settings.hosts = {"maps.example.org"};
  return settings;
}

TEST(PublicAddress, IsWhatTheRequestCameTo) {
  HttpSettings settings;
  EXPECT_EQ(PublicAddressOf(Head({}), "10.1.1.1", settings).base_url, "http://inner:8080");
  settings.base_path = "/skyquilt";
  EXPECT_EQ(PublicAddressOf(Head({}), "10.1.1.1", settings).base_url, "http://inner:8080/skyquilt");
  settings.public_url = "https://maps.example.org";
  EXPECT_EQ(PublicAddressOf(Head({}), "10.1.1.1", settings).base_url, "https://maps.example.org/skyquilt");
  settings.public_url = "https://maps.example.org/skyquilt";
  EXPECT_EQ(PublicAddressOf(Head({}), "10.1.1.1", settings).base_url, "https://maps.example.org/skyquilt");
}

TEST(NetworkAddresses, AreThoseThatOthersReach) {
  HttpSettings settings;
  for (const char* own : {"127.0.0.1", "127.0.0.2", "::1"}) {
    settings.address = own;
    EXPECT_TRUE(AddressesForOthers(settings, 8080, true).empty()) << own;
  }
  settings.base_path = "/skyquilt";
  settings.address = "192.168.1.20";
  EXPECT_EQ(AddressesForOthers(settings, 8080, true),
            std::vector<std::string>{"http://192.168.1.20:8080/skyquilt"});
  settings.address = "fd00::1";
  EXPECT_EQ(AddressesForOthers(settings, 80, true), std::vector<std::string>{"http://[fd00::1]:80/skyquilt"});
  settings.address = "0.0.0.0";
  for (const std::string& address : AddressesForOthers(settings, 8080, true)) {
    EXPECT_FALSE(address.starts_with("http://127.")) << address;
    EXPECT_TRUE(address.ends_with(":8080/skyquilt")) << address;
  }
  EXPECT_TRUE(AddressesForOthers(settings, 8080, false).empty()) << "by a container's port, perhaps";
  const std::vector<std::string> own = AddressesOfThisMachine();
  EXPECT_NE(std::find(own.begin(), own.end(), "127.0.0.1"), own.end());
  settings.public_url = "https://maps.example.org";
  EXPECT_EQ(AddressesForOthers(settings, 8080, false),
            std::vector<std::string>{"https://maps.example.org/skyquilt"});
}

TEST(PublicAddress, BelievesTrustedProxiesAlone) {
  const RequestHead head = Head({{"X-Forwarded-Proto", "https"},
                                 {"X-Forwarded-Host", "maps.example.org, inner"},
                                 {"X-Forwarded-Prefix", "/drone/maps/"}});
  const PublicAddress believed = PublicAddressOf(head, "10.1.1.1", Trusting());
  EXPECT_EQ(believed.base_url, "https://maps.example.org/drone/maps");
  EXPECT_EQ(believed.base_path, "/drone/maps");
  EXPECT_EQ(PublicAddressOf(head, "192.168.1.1", Trusting()).base_url, "http://inner:8080");
  EXPECT_EQ(PublicAddressOf(head, "10.1.1.1", HttpSettings()).base_url, "http://inner:8080");
}

TEST(PublicAddress, PassesOverWhatIsNoAddress) {
  for (const char* host : {"", "a\"b", "<script>", "a/b", "a b", "a@b", "maps.example.org:99999999999",
                           "[::1]evil.example", "evil.example", "maps.example.org.evil.example"}) {
    const auto head = Head({{"X-Forwarded-Host", host}});
    EXPECT_EQ(PublicAddressOf(head, "10.1.1.1", Trusting()).base_url, "http://inner:8080") << host;
  }
  for (const char* prefix :
       {"x", "//evil", "/a//b", "/..", "/a/../b", "/a?b", "/a\"b", "/a%2e", "/", "/a b"}) {
    const auto head = Head({{"X-Forwarded-Prefix", prefix}});
    EXPECT_EQ(PublicAddressOf(head, "10.1.1.1", Trusting()).base_path, "") << prefix;
  }
}

TEST(HostName, IsTheNameWithoutItsPort) {
  const std::pair<const char*, const char*> hosts[] = {{"localhost", "localhost"},
                                                       {"maps.example.org:8443", "maps.example.org"},
                                                       {"a_b-c.local.", "a_b-c.local."},
                                                       {"192.0.2.7:1", "192.0.2.7"},
                                                       {"[::1]", "::1"},
                                                       {"[::1]:65535", "::1"},
                                                       {"[2001:db8::7]:80", "2001:db8::7"}};
  for (const auto& [host, name] : hosts) EXPECT_EQ(NameOfHost(host), name) << host;
}

TEST(HostName, IsNothingElse) {
  const std::string long_label = std::string(64, 'a') + ".org";
  for (const std::string& host : {std::string(),
                                  std::string("[::1]evil.example"),
                                  std::string("[::1]:80:80"),
                                  std::string("[::1"),
                                  std::string("[]"),
                                  std::string("[127.0.0.1]"),
                                  std::string("[::g]"),
                                  std::string("::1"),
                                  std::string("127.0.0.1:99999999999"),
                                  std::string("a:65536"),
                                  std::string("a:0"),
                                  std::string("a:"),
                                  std::string("a:8o"),
                                  std::string(":80"),
                                  std::string("."),
                                  std::string("a..b"),
                                  std::string(".a"),
                                  std::string("a b"),
                                  std::string("a]"),
                                  std::string("a@b"),
                                  std::string("::1\0", 4),
                                  std::string("[::1\0]", 6),
                                  long_label,
                                  std::string(256, 'a')}) {
    EXPECT_FALSE(NameOfHost(host)) << host;
    EXPECT_FALSE(IsOwnHost(host, Trusting())) << host;
  }
}

TEST(HostName, IsOneOfTheServersOwn) {
  const HttpSettings settings = Trusting();
  for (const char* host : {"localhost:80", "127.0.0.1", "[::1]:80", "MAPS.example.org:8443"})
    EXPECT_TRUE(IsOwnHost(host, settings)) << host;
  for (const char* host : {"localhost.evil.example", "127.evil.example", "192.0.2.7", "org", "[2001:db8::7]"})
    EXPECT_FALSE(IsOwnHost(host, settings)) << host;
}

TEST(PublicAddress, BasePathsAreTakenOffTargets) {
  EXPECT_EQ(WithoutBasePath("/skyquilt/tiles/x?rev=1", "/skyquilt"), "/tiles/x?rev=1");
  EXPECT_EQ(WithoutBasePath("/skyquilt/", "/skyquilt"), "/");
  EXPECT_EQ(WithoutBasePath("/skyquiltx/tiles", "/skyquilt"), "/skyquiltx/tiles");
  EXPECT_EQ(WithoutBasePath("/tiles", "/skyquilt"), "/tiles");
  EXPECT_EQ(WithoutBasePath("/skyquilt/tiles", ""), "/skyquilt/tiles");
  EXPECT_TRUE(IsBaseWithoutSlash("/skyquilt?a=b", "/skyquilt"));
  EXPECT_FALSE(IsBaseWithoutSlash("/skyquilt/", "/skyquilt"));
  EXPECT_FALSE(IsBaseWithoutSlash("", ""));
}

TEST(PublicAddress, HeadersNameThePathOnce) {
  api::Headers headers{{"Location", "/api/v1/jobs/x"}};
  headers.Add("Link", "</api/v1/flights?cursor=x>; rel=\"next\"");
  PutBasePath(headers, "/skyquilt");
  PutBasePath(headers, "/skyquilt");
  EXPECT_EQ(headers.Find("Location"), "/skyquilt/api/v1/jobs/x");
  EXPECT_EQ(headers.Find("Link"), "</skyquilt/api/v1/flights?cursor=x>; rel=\"next\"");
  api::Headers elsewhere{{"Location", "https://example.org/x"}};
  PutBasePath(elsewhere, "/skyquilt");
  EXPECT_EQ(elsewhere.Find("Location"), "https://example.org/x");
}

}  // namespace
}  // namespace skyquilt::server
