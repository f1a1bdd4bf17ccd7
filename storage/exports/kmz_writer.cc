#include "storage/exports/kmz_writer.h"

#include <archive.h>
#include <archive_entry.h>
#include <fmt/core.h>

#include <memory>
#include <new>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/check.h"
#include "core/base/text/xml_text.h"
#include "core/base/try.h"
#include "core/geo/tile_id.h"
#include "core/geo/web_mercator.h"
#include "core/image/picture_codec.h"
#include "storage/db/sqlite_db.h"
#include "storage/exports/stored_tiles.h"
#include "storage/files/publish_file.h"
#include "storage/tilesets/mbtiles_reader.h"

namespace skyquilt::storage {
namespace {

// A tile gives way to finer ones when it is drawn larger than this.
constexpr int kMinPixels = 128;
// One moment for all entries, so that the same map gives the same file: the first that zip can tell.
constexpr std::int64_t kEntryTime = 315'532'800;

// A zip without compression: tiles are compressed already.
class ZipFile {
 public:
  explicit ZipFile(StreamFile& file) : archive_(archive_write_new(), archive_write_free) {
    if (!archive_) throw std::bad_alloc();
    const auto write = [](struct archive*, void* to, const void* bytes, std::size_t size) -> la_ssize_t {
      static_cast<StreamFile*>(to)->Write({static_cast<const char*>(bytes), size});
      return static_cast<la_ssize_t>(size);
    };
    Check(archive_write_set_format_zip(archive_.get()));
    Check(archive_write_zip_set_compression_store(archive_.get()));
    Check(archive_write_set_bytes_in_last_block(archive_.get(), 1));
    Check(archive_write_open(archive_.get(), &file, nullptr, write, nullptr));
  }
  void Add(const std::string& name, std::string_view content) {
    const std::unique_ptr<archive_entry, decltype(&archive_entry_free)> entry(archive_entry_new(),
                                                                              archive_entry_free);
    if (!entry) throw std::bad_alloc();
    archive_entry_set_pathname(entry.get(), name.c_str());
    archive_entry_set_size(entry.get(), static_cast<la_int64_t>(content.size()));
    archive_entry_set_filetype(entry.get(), AE_IFREG);
    archive_entry_set_perm(entry.get(), 0644);
    archive_entry_set_mtime(entry.get(), kEntryTime, 0);
    Check(archive_write_header(archive_.get(), entry.get()));
    if (archive_write_data(archive_.get(), content.data(), content.size()) < 0) Check(ARCHIVE_FATAL);
  }
  void Close() { Check(archive_write_close(archive_.get())); }

 private:
  // StreamFile keeps the disk's failures; what is left are this code's own.
  static void Check(int code) { SKYQUILT_CHECK(code == ARCHIVE_OK, "the zip writer refused an entry"); }
  std::unique_ptr<struct archive, decltype(&archive_write_free)> archive_;
};

std::string Name(const geo::TileId& tile, std::string_view extension) {
  return fmt::format("{}/{}/{}.{}", tile.z(), tile.x(), tile.y(), extension);
}

// North, south, east and west as KML wants them.
std::string Box(const geo::TileId& tile) {
  const geo::Bounds2 bounds = tile.BoundsInMerc();
  const geo::LatLon south_west = geo::LatLonFromMerc(bounds.min),
                    north_east = geo::LatLonFromMerc(bounds.max);
  return fmt::format("<north>{:.12f}</north><south>{:.12f}</south><east>{:.12f}</east><west>{:.12f}</west>",
                     north_east.lat_deg, south_west.lat_deg, north_east.lon_deg, south_west.lon_deg);
}

std::string Region(const geo::TileId& tile, int max_pixels) {
  return fmt::format(
      "<Region><LatLonAltBox>{}</LatLonAltBox><Lod><minLodPixels>{}</minLodPixels>"
      "<maxLodPixels>{}</maxLodPixels></Lod></Region>",
      Box(tile), kMinPixels, max_pixels);
}

std::string Link(const geo::TileId& tile, const std::string& folder) {
  return fmt::format(
      "<NetworkLink><name>{0}/{1}/{2}</name>{3}<Link><href>{4}{5}</href>"
      "<viewRefreshMode>onRegion</viewRefreshMode></Link></NetworkLink>\n",
      tile.z(), tile.x(), tile.y(), Region(tile, -1), folder, Name(tile, "kml"));
}

std::string Kml(const std::string& name, const std::string& content) {
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<kml "
         "xmlns=\"http://www.opengis.net/kml/2.2\"><Document>\n<name>" +
         XmlText(name) + "</name>\n" + content + "</Document></kml>\n";
}

// A tile's picture, and links to what is below it.
Result<std::string> KmlOf(const geo::TileId& tile, std::string_view extension, MbtilesReader& tiles) {
  std::string links;
  if (tile.z() < geo::kMaxZoom) {
    for (const geo::TileId& child : tile.Children()) {
      SKYQUILT_TRY_ASSIGN(const auto found, tiles.Find(child));
      if (found) links += Link(child, "../../");
    }
  }
  const std::string overlay = fmt::format(
      "{}<GroundOverlay><drawOrder>{}</drawOrder><Icon><href>{}.{}</href></Icon>"
      "<LatLonBox>{}</LatLonBox></GroundOverlay>\n",
      Region(tile, -1), tile.z(), tile.y(), extension, Box(tile));
  return Kml(Name(tile, "kml"), overlay + links);
}

// A tile as KML viewers show it.
struct KmlPicture {
  const char* extension = "jpg";
  std::string_view stored;
  std::vector<std::uint8_t> made;  // empty: as stored

  std::string_view bytes() const {
    return made.empty() ? stored : std::string_view(reinterpret_cast<const char*>(made.data()), made.size());
  }
};

Result<KmlPicture> PictureOf(std::string_view stored) {
  const auto format = image::PictureFormatOf(stored);
  if (format != image::PictureFormat::kWebp)
    return KmlPicture{format == image::PictureFormat::kPng ? "png" : "jpg", stored, {}};
  SKYQUILT_TRY_ASSIGN(image::RgbaImage picture, image::DecodePicture(stored));
  const auto shown =
      image::IsWebpWithAlpha(stored) ? image::PictureFormat::kPng : image::PictureFormat::kJpeg;
  return KmlPicture{image::ExtensionOf(shown), stored, image::EncodePicture(std::move(picture), shown)};
}

}  // namespace

Result<void> WriteKmz(const std::filesystem::path& mbtiles, const std::filesystem::path& path,
                      Progress& progress) {
  SKYQUILT_TRY_ASSIGN(auto tiles, MbtilesReader::Open(mbtiles));
  SKYQUILT_TRY_ASSIGN(auto db, SqliteDb::Open(mbtiles, OpenMode::kReadOnlyImmutable));
  SKYQUILT_TRY_ASSIGN(const std::int64_t count, CountTiles(db));
  if (count == 0)
    return Error{ErrorCode::kCorrupt,
                 "The tileset " + mbtiles.string() + " holds no tiles. Stitch the flight again.", ""};

  SKYQUILT_TRY_ASSIGN(auto file, StreamFile::Create(path));
  ZipFile zip(*file);
  // A KMZ opens with its first KML: links to the tiles of the coarsest zoom.
  {
    SKYQUILT_TRY_ASSIGN(auto walk, TileWalk::Of(db));
    std::string links;
    std::optional<int> coarsest;
    while (true) {
      SKYQUILT_TRY_ASSIGN(const bool more, walk.Next());
      if (!more || walk.tile().z() != coarsest.value_or(walk.tile().z())) break;
      coarsest = walk.tile().z();
      links += Link(walk.tile(), "");
    }
    const auto name = tiles->metadata().find("name");
    zip.Add("doc.kml", Kml(name != tiles->metadata().end() ? name->second : "Map", links));
  }
  SKYQUILT_TRY_ASSIGN(auto walk, TileWalk::Of(db));
  for (std::int64_t done = 1;; ++done) {
    if (progress.IsCancelled()) return Error{ErrorCode::kCancelled, "The job was cancelled.", ""};
    SKYQUILT_TRY_ASSIGN(const bool more, walk.Next());
    if (!more) break;
    SKYQUILT_TRY_ASSIGN(const KmlPicture picture, PictureOf(walk.bytes()));
    SKYQUILT_TRY_ASSIGN(const std::string kml, KmlOf(walk.tile(), picture.extension, *tiles));
    zip.Add(Name(walk.tile(), "kml"), kml);
    zip.Add(Name(walk.tile(), picture.extension), picture.bytes());
    progress.Report(static_cast<double>(done) / static_cast<double>(count), "writing KMZ");
  }
  zip.Close();
  return file->Publish();
}

}  // namespace skyquilt::storage
