#include "api/http/router.h"

#include <gtest/gtest.h>

#include <thread>

namespace skyquilt::api {
namespace {

Handler Answering(int status) {
  return [status](const Request&) {
    Response response;
    response.status = status;
    return response;
  };
}

Router Sample() {
  Router router;
  router.Add(Method::kGet, "/flights", Answering(1));
  router.Add(Method::kPost, "/flights", Answering(2));
  router.Add(Method::kGet, "/flights/{id}", Answering(3));
  router.Add(Method::kGet, "/flights/{id}/files", Answering(4));
  router.Add(Method::kPut, "/flights/{flight}/files/{name}", Answering(5));
  router.Add(Method::kGet, "/flights/latest", Answering(6));
  router.AddQuick(Method::kGet, "/", Answering(7));
  return router;
}

int StatusOf(const Router::Match& match) {
  return match.route == nullptr ? 0 : match.route->handler({}).status;
}

TEST(Router, FindsTheHandlerAndItsParameters) {
  const Router router = Sample();
  EXPECT_EQ(StatusOf(router.Find(Method::kGet, {"flights"})), 1);
  EXPECT_EQ(StatusOf(router.Find(Method::kPost, {"flights"})), 2);
  EXPECT_EQ(StatusOf(router.Find(Method::kGet, {})), 7);
  const auto match = router.Find(Method::kPut, {"flights", "7", "files", "a b.jpg"});
  EXPECT_EQ(StatusOf(match), 5);
  ASSERT_EQ(match.parameters.size(), 2u);
  EXPECT_EQ(match.parameters[0], (std::pair<std::string, std::string>("flight", "7")));
  EXPECT_EQ(match.parameters[1], (std::pair<std::string, std::string>("name", "a b.jpg")));
}

TEST(Router, PrefersALiteralAndStillFindsTheWayBack) {
  const Router router = Sample();
  EXPECT_EQ(StatusOf(router.Find(Method::kGet, {"flights", "latest"})), 6);
  EXPECT_EQ(StatusOf(router.Find(Method::kGet, {"flights", "latest", "files"})), 4);
}

TEST(Router, SaysWhichMethodsAPathTakes) {
  const Router router = Sample();
  const auto match = router.Find(Method::kDelete, {"flights"});
  EXPECT_EQ(match.route, nullptr);
  EXPECT_EQ(match.allow, "GET, HEAD, POST, OPTIONS");
  EXPECT_EQ(router.Allowed({"flights", "7", "files", "a"}), "PUT, OPTIONS");
  EXPECT_EQ(router.Allowed({"nothing"}), "");
  EXPECT_EQ(router.Find(Method::kGet, {"nothing"}).allow, "");
}

TEST(Router, FallsBackForPagesOnly) {
  Router router = Sample();
  router.SetFallback(Answering(9));
  EXPECT_EQ(StatusOf(router.Find(Method::kGet, {"style.css"})), 9);
  EXPECT_EQ(router.Find(Method::kPost, {"style.css"}).route, nullptr);
}

TEST(RouterConcurrency, IsReadByManyThreadsAtOnce) {
  const Router router = Sample();
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&] {
      for (int i = 0; i < 2000; ++i) {
        ASSERT_EQ(StatusOf(router.Find(Method::kGet, {"flights", std::to_string(i)})), 3);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
}

}  // namespace
}  // namespace skyquilt::api
