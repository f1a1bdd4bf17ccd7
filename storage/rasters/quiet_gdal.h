// QuietGdal: while it lives, GDAL's and PROJ's words on this thread are kept for our own sentences and not
// printed; afterwards they are forgotten. One thread; they nest.
#pragma once

#include <cpl_error.h>

namespace skyquilt::storage {

class QuietGdal {
 public:
  QuietGdal() {
    CPLErrorReset();
    CPLPushErrorHandler(CPLQuietErrorHandler);
  }
  ~QuietGdal() {
    CPLPopErrorHandler();
    CPLErrorReset();
  }
  QuietGdal(const QuietGdal&) = delete;
  QuietGdal& operator=(const QuietGdal&) = delete;
};

}  // namespace skyquilt::storage
