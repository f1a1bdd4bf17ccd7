#include "server/routing/static_files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <vector>

#include "tests/support/temporary_folder.h"

namespace skyquilt::server {
namespace {

class PageTest : public testing::Test {
 protected:
  PageTest() {
    std::filesystem::create_directories(dir_.path() / "src");
    std::filesystem::create_directories(dir_.path() / "node_modules" / "x");
    for (const char* name : {"index.html", "embed.html", "style.css", "package.json", "src/main.js",
                             "src/.secret.js", "src/a.exe", "node_modules/x/a.js", "../outside.js"}) {
      std::ofstream(dir_.path() / name) << name;
    }
    std::filesystem::create_symlink("/etc/passwd", dir_.path() / "src" / "link.js");
  }
  ~PageTest() override { std::filesystem::remove(dir_.path() / ".." / "outside.js"); }

  api::Response Get(const std::string& path, const std::string& known = "") {
    api::Request request;
    request.path = path;
    if (!known.empty()) request.headers.Add("If-None-Match", known);
    return ServePage(dir_.path(), request);
  }

  test::TemporaryFolder dir_;
};

TEST_F(PageTest, ServesThePageWithItsTypeAndPolicy) {
  const api::Response index = Get("/");
  EXPECT_EQ(index.status, 200);
  EXPECT_EQ(index.headers.Find("Content-Type"), "text/html; charset=utf-8");
  EXPECT_NE(index.headers.Find("Content-Security-Policy").find("default-src 'self'"), std::string_view::npos);
  EXPECT_EQ(Get("/src/main.js").headers.Find("Content-Type"), "text/javascript; charset=utf-8");
  EXPECT_EQ(Get("/style.css", std::string(Get("/style.css").headers.Find("ETag"))).status, 304);
}

TEST_F(PageTest, LetsOthersFrameTheBareMapAlone) {
  const auto ancestors = [](const api::Response& response) {
    const std::string policy(response.headers.Find("Content-Security-Policy"));
    return policy.substr(std::min(policy.size(), policy.find("frame-ancestors")));
  };
  const std::string flight(26, 'a');
  const api::Response bare = Get("/embed/" + flight);
  EXPECT_EQ(bare.status, 200);
  EXPECT_EQ(bare.headers.Find("Content-Type"), "text/html; charset=utf-8");
  EXPECT_EQ(ancestors(bare), "frame-ancestors *");
  for (const char* path : {"/", "/index.html", "/embed.html", "/src/main.js"}) {
    EXPECT_EQ(ancestors(Get(path)), "frame-ancestors 'none'") << path;
  }
  const std::vector<std::string> others = {"/embed", "/embed/" + flight + "x", "/embed/main.js",
                                           "/embed/" + flight + "/main.js"};
  for (const std::string& path : others) {
    EXPECT_EQ(Get(path).status, 404) << path;
  }
}

TEST_F(PageTest, SendsTheCompressedFileBesideAFileToWhomTakesIt) {
  std::ofstream(dir_.path() / "src" / "main.js.gz") << "zipped";
  const auto encoding_for = [&](const std::string& accepted) {
    api::Request request;
    request.path = "/src/main.js";
    if (!accepted.empty()) request.headers.Add("Accept-Encoding", accepted);
    const api::Response response = ServePage(dir_.path(), request);
    EXPECT_EQ(response.status, 200);
    EXPECT_EQ(response.headers.Find("Content-Type"), "text/javascript; charset=utf-8");
    EXPECT_EQ(response.headers.Find("Vary"), "Accept-Encoding");
    return std::string(response.headers.Find("Content-Encoding"));
  };
  EXPECT_EQ(encoding_for("gzip, deflate, br"), "gzip");
  EXPECT_EQ(encoding_for("br, gzip;q=0.5"), "gzip");
  EXPECT_EQ(encoding_for("gzip;q=0, br"), "");
  EXPECT_EQ(encoding_for(""), "");
  std::ofstream(dir_.path() / "src" / "main.js.br") << "smaller";
  EXPECT_EQ(encoding_for("gzip, deflate, br"), "br");
  EXPECT_EQ(encoding_for("gzip, Br ;q=0.1"), "br");
  EXPECT_EQ(encoding_for("gzip, br;q=0"), "gzip");
  EXPECT_EQ(encoding_for("gzip, brotli, abr"), "gzip");
  EXPECT_EQ(encoding_for(", ;,"), "");
  EXPECT_EQ(Get("/src/main.js.gz").status, 404);
  EXPECT_EQ(Get("/src/main.js.br").status, 404);
}

TEST_F(PageTest, KeepsEverythingElseToItself) {
  for (const char* path : {"/package.json", "/src/.secret.js", "/src/a.exe", "/node_modules/x/a.js",
                           "/src/link.js", "/src", "/src/none.js", "/none.html"}) {
    EXPECT_EQ(Get(path).status, 404) << path;
  }
  for (const char* path : {"/../outside.js", "/src/../package.json", "/%2e%2e/outside.js", "/src//main.js"}) {
    EXPECT_EQ(Get(path).status, 400) << path;
  }
}

TEST(FindPageFolder, TakesOnlyAFolderWithAPage) {
  test::TemporaryFolder dir;
  EXPECT_FALSE(FindPageFolder(dir.path()));
  std::ofstream(dir.path() / "index.html") << "x";
  EXPECT_EQ(FindPageFolder(dir.path()), dir.path());
}

}  // namespace
}  // namespace skyquilt::server
