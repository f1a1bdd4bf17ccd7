// Shared libraries that are loaded when the first of their functions is called (cmake/Late.cmake): what their
// trampolines call, and a way to have them beforehand. A library that cannot be loaded at a call ends the
// process with a message that names it, as the loader would have at the start. Any thread.
#pragma once

#include <cstddef>
#include <initializer_list>
#include <string_view>

#include "core/base/result.h"

namespace skyquilt {

// Loads the libraries whose names begin so ("libproj.so"), or all where none is named: by who will soon be
// allowed to open no files. Nothing to do where all are linked. Error: kUnavailable, with the library's name.
Result<void> LoadLate(std::initializer_list<std::string_view> names = {});
// Whether all can be loaded, tried in a process of its own: who serves finds a missing one at the start, and
// most servers never need the 50 MiB that they take. Before the first thread. Error: as LoadLate.
Result<void> TryLate();

}  // namespace skyquilt

// As cmake/late/x86_64.S lays it out.
struct SkyquiltLateTable {
  const char* soname;
  const char* const* names;
  void** slots;  // null: not called yet
};

extern "C" void* SkyquiltLateFunction(const SkyquiltLateTable* table, std::size_t index);
