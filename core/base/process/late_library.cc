#include "core/base/process/late_library.h"

#include <dlfcn.h>

#include <atomic>
#include <cstdio>
#include <cstdlib>

// Two threads may come at once: they find the same.
extern "C" void* SkyquiltLateFunction(const SkyquiltLateTable* table, std::size_t index) {
  void* const library = dlopen(table->soname, RTLD_LAZY | RTLD_LOCAL);
  void* const function = library == nullptr ? nullptr : dlsym(library, table->names[index]);
  if (function == nullptr) {
    const char* const why = dlerror();
    std::fprintf(stderr, "skyquilt: %s of %s cannot be loaded: %s. Install Skyquilt's libraries again.\n",
                 table->names[index], table->soname, why != nullptr ? why : "no reason is known");
    std::abort();
  }
  std::atomic_ref(table->slots[index]).store(function, std::memory_order_release);
  return function;
}
