// LargeBlocksApart: while one lives, blocks of 128 KiB and more are memory of their own, which the system has
// back as soon as they are freed. For phases that hold many of them and let go of some: glibc would keep
// these in its heap, where one small block behind holds all before it. Costs a page fault per 4 KiB of each
// new block, so not for phases that take and give back pictures. Of the whole process; does nothing where the
// C library is another.
#pragma once

namespace skyquilt {

class LargeBlocksApart {
 public:
  // `is_wanted` false: as if there were none.
  explicit LargeBlocksApart(bool is_wanted);
  ~LargeBlocksApart();
  LargeBlocksApart(const LargeBlocksApart&) = delete;
  LargeBlocksApart& operator=(const LargeBlocksApart&) = delete;

 private:
  const bool is_wanted_;
};

// Hands back what is free at the heap's pages.
void ReturnFreedMemory();

}  // namespace skyquilt
