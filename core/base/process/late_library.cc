#include "core/base/process/late_library.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "core/base/process/file_descriptor.h"

// Of the trampolines that are linked; the linker makes both names. Null where there are none.
// NOLINTBEGIN(readability-identifier-naming): the linker's words
extern "C" {
[[gnu::weak, gnu::visibility("hidden")]] extern const SkyquiltLateTable* const __start_late_tables[];
[[gnu::weak, gnu::visibility("hidden")]] extern const SkyquiltLateTable* const __stop_late_tables[];
}
// NOLINTEND(readability-identifier-naming)

namespace skyquilt {
namespace {

void* Load(const SkyquiltLateTable& table) { return dlopen(table.soname, RTLD_LAZY | RTLD_LOCAL); }

std::string LastFault() {
  const char* const why = dlerror();
  return why != nullptr ? why : "no reason is known";
}

}  // namespace

Result<void> LoadLate(std::initializer_list<std::string_view> names) {
  for (const SkyquiltLateTable* const* table = __start_late_tables; table != __stop_late_tables; ++table) {
    std::string_view soname = (*table)->soname;  // or a path
    soname.remove_prefix(soname.rfind('/') + 1);
    const auto is_meant = [&](std::string_view name) { return soname.starts_with(name); };
    if (names.size() > 0 && std::none_of(names.begin(), names.end(), is_meant)) continue;
    if (Load(**table) == nullptr)
      return Error{ErrorCode::kUnavailable,
                   "The library " + std::string(soname) + " cannot be loaded: " + LastFault() +
                       ". Install the libraries that Skyquilt needs again.",
                   ""};
  }
  return {};
}

Result<void> TryLate() {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) return LoadLate();
  const FileDescriptor said(ends[0]);
  FileDescriptor to_say(ends[1]);
  const pid_t child = fork();
  if (child < 0) return LoadLate();
  if (child == 0) {
    const Result<void> loaded = LoadLate();
    const std::string why = loaded ? "" : loaded.error().message;
    const bool is_said = write(to_say.get(), why.data(), why.size()) == static_cast<ssize_t>(why.size());
    _exit(loaded && is_said ? 0 : 1);
  }
  to_say.Close();
  std::string why;
  std::array<char, 1024> part{};
  for (ssize_t got = 1; got != 0;) {
    got = read(said.get(), part.data(), part.size());
    if (got > 0) why.append(part.data(), static_cast<std::size_t>(got));
    if (got < 0 && errno != EINTR) break;
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (why.empty() && WIFEXITED(status) && WEXITSTATUS(status) == 0) return {};
  if (why.empty()) why = "The libraries that Skyquilt needs cannot be loaded. Install them again.";
  return Error{ErrorCode::kUnavailable, why, ""};
}

}  // namespace skyquilt

// Two threads may come at once: they find the same.
extern "C" void* SkyquiltLateFunction(const SkyquiltLateTable* table, std::size_t index) {
  void* const library = skyquilt::Load(*table);
  void* const function = library == nullptr ? nullptr : dlsym(library, table->names[index]);
  if (function == nullptr) {
    std::fprintf(
        stderr, "skyquilt: %s of %s cannot be loaded: %s. Install the libraries that Skyquilt needs again.\n",
        table->names[index], table->soname, skyquilt::LastFault().c_str());
    std::abort();
  }
  std::atomic_ref(table->slots[index]).store(function, std::memory_order_release);
  return function;
}
