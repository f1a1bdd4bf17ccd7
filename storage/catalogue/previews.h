// Previews: which flights have a preview, its progress, and which photos wait to be drawn. A flight has a
// preview while it has no map: publishing the map ends it in the same transaction. The tiles themselves are
// in PreviewTiles. Any thread, any number of processes, of which one draws. Errors: kUnavailable, kIo.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/geo/lat_lon_bounds.h"
#include "storage/catalogue/catalogue.h"
#include "storage/db/catalogue_db.h"

namespace skyquilt::storage {

struct Preview {
  std::string flight_id;
  std::string folder;  // below the flight's, with PreviewTiles in it; another one after a start from new
  std::int64_t edition = 0;
  std::int64_t photos = 0;  // that are drawn
  int min_zoom = 0;
  int max_zoom = 0;
  geo::LatLonBounds bounds;
  geo::LatLonBounds changed;  // what the latest edition changed
};

// Photos to draw.
struct PreviewWork {
  std::string flight_id;
  std::vector<StoredFile> fresh;
  std::vector<StoredFile> tried;  // before them: they say which way the flight goes
};

class Previews {
 public:
  explicit Previews(CatalogueDb& db) : db_(db) {}

  // Files that nobody tried yet, at most `limit` and of one flight, the one of which least is drawn. They
  // count as tried from now on: a photo that kills whoever draws it is not taken up again.
  Result<std::optional<PreviewWork>> Claim(int limit);
  // These turned out to have no part in the preview: it does not depend on them.
  Result<void> Forgo(const std::vector<StoredFile>& files);
  Result<std::optional<Preview>> Find(const std::string& flight_id) const;
  // Shows an edition. False: the flight is gone, has its map by now, or was begun anew; nothing is shown
  // then.
  Result<bool> Show(const Preview& preview);

 private:
  CatalogueDb& db_;
};

// The name of a new preview folder; all have names that begin so.
inline constexpr const char* kPreviewFolderPrefix = "preview-";
std::string NewPreviewFolder();

}  // namespace skyquilt::storage
