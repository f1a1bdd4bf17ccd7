// Whatever the bytes are, whether they are an elevation model is answered, and a chain of directories is not
// followed further than asked for.
#include <cstdio>
#include <cstdlib>

#include "core/flight/lists/file_kinds.h"
#include "core/flight/metadata/exif_table.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace skyquilt::flight;
  MemoryBytes source({data, size});
  const bool is_model = IsElevationModel(source);
  constexpr int kMost = 64;
  const skyquilt::Result<int> directories = CountTiffDirectories(source, kMost);
  if ((is_model && !directories) || (directories && *directories > kMost + 1)) {
    std::fprintf(stderr, "broken promise: directories are counted\n");
    std::abort();
  }
  return 0;
}
