#include "server/watch/card_files.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

#include "tests/support/temporary_folder.h"

namespace skyquilt::server {
namespace {

TEST(CardFilesTest, ALookThatIsBrokenOffLeavesTheRestToTheNext) {
  const test::TemporaryFolder card;
  for (const char* name : {"a.txt", "b.txt", "c.txt"}) std::ofstream(card / name) << "no flight's";
  CardFiles files({card.path()}, std::chrono::milliseconds(0));
  const auto unread = [&] {
    return std::count_if(files.files().begin(), files.files().end(),
                         [](const auto& entry) { return entry.second.kind == CardKind::kUnread; });
  };
  int asked = 0;
  files.Look([&] { return ++asked < 2; });
  EXPECT_EQ(files.files().size(), 3u);
  EXPECT_EQ(unread(), 2);
  files.Look();
  EXPECT_EQ(unread(), 0);
}

TEST(CardFilesTest, FoldersThatMayNotBeReadAreNamed) {
  if (geteuid() == 0) GTEST_SKIP() << "who may read everything";
  const test::TemporaryFolder card;
  const std::filesystem::path closed = card.path() / "closed";
  std::filesystem::create_directory(closed);
  std::filesystem::permissions(closed, std::filesystem::perms::none);
  CardFiles files({card.path()}, std::chrono::milliseconds(0));
  files.Look();
  CardFiles of_it({closed}, std::chrono::milliseconds(0));
  of_it.Look();
  std::filesystem::permissions(closed, std::filesystem::perms::owner_all);
  EXPECT_EQ(files.denied(), std::vector<std::filesystem::path>{closed});
  EXPECT_EQ(of_it.denied(), std::vector<std::filesystem::path>{closed});
  files.Look();
  EXPECT_TRUE(files.denied().empty());
}

}  // namespace
}  // namespace skyquilt::server
