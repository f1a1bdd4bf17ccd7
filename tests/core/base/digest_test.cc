#include "core/base/digest.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>

#include "tests/support/temporary_folder.h"

namespace skyquilt {
namespace {

TEST(Digest, OfAFileTellsItsBytes) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "one") << "a flight";
  std::ofstream(folder / "same") << "a flight";
  std::ofstream(folder / "other") << "b flight";
  EXPECT_EQ(*DigestOfFile(folder / "one"), *DigestOfFile(folder / "same"));
  EXPECT_NE(*DigestOfFile(folder / "one"), *DigestOfFile(folder / "other"));
}

// Their bytes never end, or never come.
TEST(Digest, RefusesWhatIsNoRegularFile) {
  const test::TemporaryFolder folder;
  std::filesystem::create_symlink("/dev/zero", folder / "zero.jpg");
  ASSERT_EQ(mkfifo((folder / "pipe.jpg").c_str(), 0600), 0);
  for (const auto* name : {"zero.jpg", "pipe.jpg", "absent.jpg", "."}) {
    const auto digest = DigestOfFile(folder / name);
    ASSERT_FALSE(digest) << name;
    EXPECT_EQ(digest.error().code, ErrorCode::kIo);
  }
}

}  // namespace
}  // namespace skyquilt
