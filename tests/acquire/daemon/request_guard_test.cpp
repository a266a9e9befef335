// SPDX-License-Identifier: Apache-2.0
// Names that look like this machine's and are not; by hand.
#include "acquire/daemon/request_guard.h"

#include <gtest/gtest.h>

namespace dermap {
namespace {

TEST(RequestGuard, KnowsWhatNoOtherMachineReaches) {
  for (const char* address : {"127.0.0.1", "127.8.4.2", "::1", "localhost"})
    EXPECT_TRUE(IsLoopback(address)) << address;
  for (const char* address : {"0.0.0.0", "192.168.1.2", "127.0.0.1.evil.example", "127.evil.example",
                              "::", "", "localhost.evil.example"})
    EXPECT_FALSE(IsLoopback(address)) << address;
}

TEST(RequestGuard, TakesOnlyOurOwnNamesAndPort) {
  for (const char* host : {"127.0.0.1:8460", "localhost:8460", "[::1]:8460", "127.0.0.2:8460"})
    EXPECT_TRUE(HostIsOurs(host, "127.0.0.2", 8460)) << host;
  for (const char* host : {"evil.example:8460", "127.0.0.1:80", "127.0.0.1", "127.0.0.1:84600", "",
                           "localhost:8460.evil.example"})
    EXPECT_FALSE(HostIsOurs(host, "127.0.0.2", 8460)) << host;
  EXPECT_TRUE(HostIsOurs("localhost", "127.0.0.1", 80)) << "browsers leave this port out";
  EXPECT_TRUE(OriginIsOurs("", "localhost:8460"));
  EXPECT_TRUE(OriginIsOurs("http://localhost:8460", "localhost:8460"));
  for (const char* origin :
       {"null", "http://evil.example", "http://localhost:8461", "https://localhost:8460"})
    EXPECT_FALSE(OriginIsOurs(origin, "localhost:8460")) << origin;
}

TEST(RequestGuard, TellsTokensApart) {
  EXPECT_TRUE(SameToken("a-token-to-guard-it", "a-token-to-guard-it"));
  for (const char* given : {"", "a", "a-token-to-guard-i", "a-token-to-guard-itt", "A-token-to-guard-it",
                            "a-token-to-guard-ita-token-to-guard-it"})
    EXPECT_FALSE(SameToken(given, "a-token-to-guard-it")) << given;
  EXPECT_FALSE(SameToken("x", ""));
}

TEST(RequestGuard, GivesEveryHelmAnotherKey) {
  const std::string key = RandomKey();
  EXPECT_EQ(key.size(), 32u);
  EXPECT_NE(key, RandomKey());
}

}  // namespace
}  // namespace dermap
