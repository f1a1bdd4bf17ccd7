#include "server/webhooks/post_message.h"

#include <gtest/gtest.h>

namespace skyquilt::server {
namespace {

TEST(IsPublicAddress, RefusesWhatLeadsInside) {
  for (const char* address : {"127.0.0.1",
                              "127.8.9.1",
                              "10.0.0.1",
                              "172.16.0.1",
                              "172.31.255.255",
                              "192.168.1.1",
                              "169.254.169.254",
                              "100.64.0.1",
                              "0.0.0.0",
                              "192.0.2.7",
                              "198.18.0.1",
                              "224.0.0.1",
                              "255.255.255.255",
                              "::",
                              "::1",
                              "fe80::1",
                              "fc00::1",
                              "fd12::1",
                              "ff02::1",
                              "::ffff:127.0.0.1",
                              "::ffff:8.8.8.8",
                              "64:ff9b::7f00:1",
                              "2002:7f00:1::",
                              "2001::1",
                              "2001:db8::1",
                              "localhost",
                              "",
                              "2130706433",
                              "0x7f.1"}) {
    EXPECT_FALSE(IsPublicAddress(address)) << address;
  }
}

TEST(IsPublicAddress, LetsThePublicThrough) {
  for (const char* address :
       {"8.8.8.8", "172.15.0.1", "172.32.0.1", "192.167.0.1", "100.63.0.1", "100.128.0.1", "1.1.1.1",
        "223.255.255.254", "2606:4700::1111", "2a00:1450:4001:80b::200e"}) {
    EXPECT_TRUE(IsPublicAddress(address)) << address;
  }
}

TEST(PostMessage, RefusesAPrivateAddressBeforeItConnects) {
  const auto posted = PostMessage({"http://127.0.0.1:9/", {}, "{}", false});
  EXPECT_EQ(posted.error().code, ErrorCode::kForbidden);
  EXPECT_EQ(PostMessage({"http://:80/", {}, "{}", true}).error().code, ErrorCode::kInvalidArgument);
}

}  // namespace
}  // namespace skyquilt::server
