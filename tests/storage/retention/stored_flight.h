// StoredFlightTest: a catalogue with one flight of one file in it, and what works on it.
#pragma once

#include "storage/catalogue/trash.h"
#include "storage/uploads/upload_spool.h"
#include "tests/storage/catalogue_fixture.h"

namespace skyquilt::storage {

class StoredFlightTest : public CatalogueFixture {
 protected:
  StoredFlightTest() { EXPECT_TRUE(catalogue_.AddFile(flight_, {"a.jpg", "stored", 7}, Now())); }
  void Publish() {
    Revision revision;
    revision.bounds = {10, 50, 10.1, 50.1};
    PublishMap(flight_, revision);
  }

  DataDir data_ = *DataDir::Open(dir_.path());
  PhotoStore store_{data_};
  UploadSpool spool_{*db_, catalogue_, store_};
  Trash trash_{*db_};
  std::string flight_ = catalogue_.AddFlight("field", "{}", Now(), "owner")->id;
};

}  // namespace skyquilt::storage
