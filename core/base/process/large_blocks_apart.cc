#include "core/base/process/large_blocks_apart.h"

#if defined(__GLIBC__)
#include <malloc.h>
#endif

namespace skyquilt {
namespace {

#if defined(__GLIBC__)
constexpr int kApartBytes = 128 << 10;
// Where glibc's own thresholds arrive after a few large blocks, which setting them once keeps them from.
constexpr int kUsualBytes = 32 << 20;
#endif

}  // namespace

LargeBlocksApart::LargeBlocksApart(bool is_wanted) : is_wanted_(is_wanted) {
#if defined(__GLIBC__)
  if (is_wanted_) mallopt(M_MMAP_THRESHOLD, kApartBytes);
#endif
}

LargeBlocksApart::~LargeBlocksApart() {
#if defined(__GLIBC__)
  if (!is_wanted_) return;
  mallopt(M_MMAP_THRESHOLD, kUsualBytes);
  mallopt(M_TRIM_THRESHOLD, 2 * kUsualBytes);
#endif
}

void ReturnFreedMemory() {
#if defined(__GLIBC__)
  malloc_trim(0);
#endif
}

}  // namespace skyquilt
