// The archive that is never on the disk: any part of it is a part of the whole.
#include "api/downloads/zip_layout.h"

#include <gtest/gtest.h>

#include <fstream>
#include <random>

#include "tests/support/temporary_folder.h"

namespace skyquilt::api {
namespace {

std::string ReadAll(const std::shared_ptr<const ZipLayout>& layout, std::uint64_t offset,
                    std::uint64_t length, std::size_t slice_bytes) {
  auto source = ReadZip(layout, offset, length);
  EXPECT_TRUE(source);
  std::string bytes;
  std::vector<std::uint8_t> slice(slice_bytes);
  while (true) {
    const auto got = (*source)->Read(slice);
    EXPECT_TRUE(got);
    if (!got || *got == 0) return bytes;
    bytes.append(slice.begin(), slice.begin() + static_cast<std::ptrdiff_t>(*got));
  }
}

TEST(ZipLayout, AnyPartIsAPartOfTheWhole) {
  test::TemporaryFolder scratch;
  const auto path = scratch.path() / "big";
  std::ofstream(path) << std::string(100'000, 'x') << "end";
  const auto planned =
      PlanZip({{"a.txt", "hello", {}, {}}, {"folder/big", "", path, {}}, {"empty", "", {}, {}}});
  ASSERT_TRUE(planned);
  const auto layout = std::make_shared<const ZipLayout>(*planned);
  const std::string whole = ReadAll(layout, 0, layout->length, 4096);
  ASSERT_EQ(whole.size(), layout->length);
  EXPECT_TRUE(whole.starts_with("PK\3\4"));
  EXPECT_NE(whole.find("folder/big"), std::string::npos);
  std::mt19937 random(3);
  for (int i = 0; i < 200; ++i) {
    const std::uint64_t offset = random() % layout->length;
    const std::uint64_t length = 1 + random() % (layout->length - offset);
    EXPECT_EQ(ReadAll(layout, offset, length, 1 + random() % 9000), whole.substr(offset, length));
  }
  // The same files make the same bytes; a file that has gone is said.
  EXPECT_EQ(PlanZip({{"a.txt", "hello", {}, {}}, {"folder/big", "", path, {}}, {"empty", "", {}, {}}})
                ->pieces.back()
                .bytes,
            layout->pieces.back().bytes);
  std::filesystem::remove(path);
  EXPECT_EQ(PlanZip({{"b", "", path, {}}}).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(ReadZip(layout, 0, layout->length).error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace skyquilt::api
