// RegisterGdalOnce: makes GDAL ready for the formats it reads and writes here, with a small block cache and
// no side files. Any thread, any number of times.
#pragma once

namespace skyquilt::storage {

void RegisterGdalOnce();

}  // namespace skyquilt::storage
