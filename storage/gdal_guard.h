// GDAL is registered once, with only the drivers that we use, and never reaches for the network. Thread-safe.
#pragma once

namespace skyquilt::storage {

void RegisterGdalOnce();

}  // namespace skyquilt::storage
