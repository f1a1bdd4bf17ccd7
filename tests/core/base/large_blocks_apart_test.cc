#include "core/base/process/large_blocks_apart.h"

#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <vector>

namespace skyquilt {
namespace {

long ResidentKib() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmRSS:")) return std::stol(line.substr(6));
  }
  return 0;
}

// What is left of many blocks when every second one is freed: the half of them, whatever lies between.
TEST(LargeBlocksApart, GivesFreedBlocksBackAtOnce) {
#if !defined(__GLIBC__) || defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "another allocator";
#else
  constexpr int kBlocks = 200;
  constexpr std::size_t kBytes = 256 << 10;
  const LargeBlocksApart apart(true);
  const long before_kib = ResidentKib();
  std::vector<std::vector<char> > blocks;
  for (int i = 0; i < kBlocks; ++i) blocks.emplace_back(kBytes, 'x');
  const long all_kib = ResidentKib() - before_kib;
  for (int i = 0; i < kBlocks; i += 2) std::vector<char>().swap(blocks[static_cast<std::size_t>(i)]);
  const long half_kib = ResidentKib() - before_kib;
  EXPECT_GT(all_kib, 45'000);
  EXPECT_LT(half_kib, 0.6 * static_cast<double>(all_kib));
#endif
}

}  // namespace
}  // namespace skyquilt
