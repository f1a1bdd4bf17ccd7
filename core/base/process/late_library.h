// Shared libraries that are loaded when the first of their functions is called: what the stubs of cmake/late
// call. A library that cannot be loaded ends the process with a message that names it, as the loader would
// have at the start. Any thread.
#pragma once

#include <cstddef>

// As cmake/late/x86_64.S lays it out.
struct SkyquiltLateTable {
  const char* soname;
  const char* const* names;
  void** slots;  // null: not called yet
};

extern "C" void* SkyquiltLateFunction(const SkyquiltLateTable* table, std::size_t index);
