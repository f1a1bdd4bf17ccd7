#include "core/base/digest.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "tests/support/temporary_folder.h"

namespace skyquilt {
namespace {

TEST(Digest, OfAFileTellsItsBytes) {
  const test::TemporaryFolder folder;
  const Digest one = *DigestOfFile(folder.Write("one", "a flight"));
  EXPECT_EQ(*DigestOfFile(folder.Write("same", "a flight")), one);
  EXPECT_NE(*DigestOfFile(folder.Write("other", "b flight")), one);
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
