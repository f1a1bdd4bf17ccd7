#include "server/jobs/out_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/file.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <system_error>
#include <utility>

#include "core/base/digest.h"
#include "core/base/text/printable.h"
#include "core/base/try.h"
#include "core/flight/read_flight.h"
#include "core/pipeline/report/flight_facts.h"
#include "core/pipeline/report/odm_exports.h"
#include "core/render/map_layer.h"
#include "server/inputs/film_frames.h"
#include "storage/files/publish_file.h"
#include "storage/tilesets/map_keeper.h"

namespace skyquilt::server {
namespace {

namespace fs = std::filesystem;

constexpr const char* kGeoTxt = "geo.txt";

// One that cannot be read may be anybody's.
bool IsGeoTxtOfMap(const fs::path& path) {
  const Result<std::string> text = storage::ReadWholeFile(path);
  return text && pipeline::IsOdmGeoTxt(*text);
}

// Every file that StitchToDirectory writes or removes.
std::vector<std::string> ProductNames() {
  std::vector<std::string> names = {"mosaic.mbtiles",   "mosaic.pmtiles", "mosaic.tif",
                                    "mosaic_utm.tif",   "mosaic.kmz",     "thumbnail.png",
                                    "report.json",      "photos.geojson", "locate.json",
                                    "cameras.json",     kGeoTxt,          "layers.json",
                                    "bands.tif",        "dsm.tif",        "dsm_photos.tif",
                                    "dtm.tif",          "dtm_ground.tif", "contours.gpkg",
                                    "contours.geojson", "contours.dxf",   "dsm_hillshade.tif"};
  for (const render::MapLayer layer : render::kMapLayers) names.push_back(render::LayerFileName(layer));
  return names;
}

std::optional<std::string> FirstProductIn(const fs::path& folder) {
  std::error_code none;  // what cannot be read cannot be replaced either: writing it reports why
  for (const std::string& name : ProductNames()) {
    if (fs::exists(fs::symlink_status(folder / name, none))) return name;
  }
  return std::nullopt;
}

// Of a finished map, what nobody gave this time.
struct Missing {
  std::vector<std::string> photos;   // and films: that it shows
  std::vector<std::string> records;  // lists, logs and the like, not by name either (one may be edited)
};

Missing MissingOf(const fs::path& out_dir, const pipeline::FlightFacts& facts,
                  const std::vector<flight::InputFile>& files) {
  std::set<Digest> given;
  std::set<std::string> given_names;
  for (const flight::InputFile& file : files) {
    given_names.insert(file.name);
    // One that cannot be read is no photo of the map; the run itself says what is wrong with it.
    if (const Result<Digest> digest = DigestOfFile(file.path)) given.insert(*digest);
  }
  std::set<std::string> pictures;
  for (const alignment::AlignedPhoto& shown : facts.flight.photos) pictures.insert(shown.photo.name);
  for (const flight::LeftOutPhoto& photo : facts.flight.left_out) pictures.insert(photo.name);
  Missing missing;
  std::map<std::string, Digest> digest_of;
  std::set<std::string> frames;
  for (const pipeline::NamedDigest& input : facts.inputs) {
    digest_of[input.file.name] = input.digest;
    const bool is_frame = IsFrameOf(out_dir, input.file);
    if (is_frame) frames.insert(input.file.name);
    if (!is_frame && !pictures.contains(input.file.name) && !given.contains(input.digest) &&
        !given_names.contains(input.file.name))
      missing.records.push_back(input.file.name);
  }
  for (const FilmSource& film : SourcesOfFrames(out_dir)) {
    // Where the map has no frames, those of one before it lie there still.
    if (!frames.empty() && !given.contains(film.digest)) missing.photos.push_back(film.file.name);
  }
  for (const alignment::AlignedPhoto& shown : facts.flight.photos) {
    if (frames.contains(shown.photo.name)) continue;
    const auto known = digest_of.find(shown.photo.name);
    if (known == digest_of.end() || !given.contains(known->second))
      missing.photos.push_back(shown.photo.name);
  }
  return missing;
}

// What the finished map was made with that was not asked for now: "--quality 60 (now 85)". A ground size of
// which nothing is said now stays that of the map. Empty: nothing.
std::string OtherOptions(const pipeline::FlightFacts& facts, const pipeline::MosaicOptions& options) {
  constexpr double kSameGsd = 1e-3;  // of it
  std::vector<std::string> others;
  const std::map<std::string, std::string> now = options.InWords();
  const auto said = [](const std::string& value) { return value.empty() ? std::string("none") : value; };
  for (const auto& [name, was] : facts.asked) {
    const auto is = now.find(name);
    if (is != now.end() && is->second != was)
      others.push_back(fmt::format("{} {} (now {})", name, said(was), said(is->second)));
  }
  if (options.gsd_m && facts.appearance) {
    const double was_m = facts.appearance->gsd_m;
    if (std::abs(*options.gsd_m - was_m) > kSameGsd * was_m)
      others.push_back(fmt::format("--gsd {:.4g} (now {:.4g})", was_m, *options.gsd_m));
  }
  if (facts.boundary != options.boundary)
    others.push_back(!facts.boundary    ? "no --boundary"
                     : options.boundary ? "another --boundary"
                                        : "a --boundary");
  return fmt::format("{}", fmt::join(others, ", "));
}

Error Refusal(const fs::path& out_dir, const std::string& what) {
  return {ErrorCode::kConflict,
          fmt::format(
              "{} {} Nothing was changed. Choose another folder with -o, or say --overwrite to replace it.",
              out_dir.string(), what)};
}

}  // namespace

Result<void> CheckOutFolder(const fs::path& out_dir, const std::vector<flight::InputFile>& files,
                            const pipeline::MosaicOptions& options) {
  const std::optional<std::string> product = FirstProductIn(out_dir);
  if (!product) return {};
  const Result<std::string> bytes = storage::MapKeeper::StatedFacts(out_dir);
  if (!bytes) {
    return Refusal(
        out_dir,
        fmt::format("has {} already, and no readable mosaic.state that says of which photos.", *product));
  }
  const Result<pipeline::FlightFacts> facts = pipeline::ParseFacts(*bytes);
  // Of another version nothing is read, and no map is of no photos.
  if (!facts || facts->flight.photos.empty())
    return Refusal(out_dir,
                   "has a map whose mosaic.state is damaged or of another version of Skyquilt, so its photos "
                   "are not known.");
  SKYQUILT_TRY(CheckListStays(out_dir));
  const Missing missing = MissingOf(out_dir, *facts, files);
  const std::string others = OtherOptions(*facts, options);
  if (missing.photos.empty() && !others.empty())
    return Refusal(out_dir, fmt::format("has the finished map of these photos, made with {}.", others));
  if (missing.photos.empty() && !missing.records.empty()) {
    return Refusal(
        out_dir,
        fmt::format("has the finished map of these photos, made with {} more ({}{}) that {} not "
                    "given now.",
                    Counted(missing.records.size(), "file"), missing.records.front(),
                    missing.records.size() > 1 ? ", ..." : "", missing.records.size() > 1 ? "are" : "is"));
  }
  if (missing.photos.empty()) return {};
  return Refusal(out_dir,
                 fmt::format("has the finished map of other photos: {} of its {} photos are not among "
                             "those given (first {}). To add photos to it, say --append.",
                             missing.photos.size(), facts->flight.photos.size(), missing.photos.front()));
}

bool IsOfMap(const fs::path& file, const fs::path& root) {
  static const std::vector<std::string> names = ProductNames();
  std::error_code none;  // what is gone is of no map
  const fs::path folder = file.parent_path();
  if (IsFrameOf(folder.parent_path(), {"", file})) return !fs::equivalent(root, folder, none);
  const std::string name = file.filename().string();
  const bool is_named_so =
      name.starts_with("mosaic.state") || std::find(names.begin(), names.end(), name) != names.end();
  return is_named_so && fs::exists(folder / "mosaic.state", none) && (name != kGeoTxt || IsGeoTxtOfMap(file));
}

Result<void> CheckPhotosStay(const fs::path& out_dir, const std::vector<flight::InputFile>& files) {
  SKYQUILT_TRY_ASSIGN(const std::string bytes, storage::MapKeeper::StatedFacts(out_dir));
  SKYQUILT_TRY_ASSIGN(const pipeline::FlightFacts facts, pipeline::ParseFacts(bytes));
  const Missing missing = MissingOf(out_dir, facts, files);
  if (missing.photos.empty()) return {};
  return Error{
      ErrorCode::kConflict,
      fmt::format(
          "{}: {} of the map there {} now (first {}), as on a card that was emptied. Nothing was changed. A "
          "map can only be added to where its photos still are; for one of others choose another folder "
          "with -o.",
          out_dir.string(), Counted(missing.photos.size(), "photo"),
          missing.photos.size() == 1 ? "is another file" : "are other files", missing.photos.front())};
}

Result<void> CheckListStays(const fs::path& out_dir) {
  const fs::path list = out_dir / kGeoTxt;
  std::error_code none;
  if (!fs::exists(fs::symlink_status(list, none)) || IsGeoTxtOfMap(list)) return {};
  return Error{
      ErrorCode::kConflict,
      fmt::format("{} was not written with the map there, and the map's own would replace it. Nothing "
                  "was changed. Move it to another folder, from where it can be given as a list of "
                  "positions.",
                  list.string())};
}

Result<std::vector<flight::InputFile>> FilesOfFlight(const std::vector<fs::path>& inputs) {
  std::vector<fs::path> passed_over, denied;
  const auto passes_over = [&](const fs::path& file, const fs::path& root) {
    if (!IsOfMap(file, root)) return false;
    passed_over.push_back(file);
    return true;
  };
  auto files =
      flight::ListInputFiles(inputs, passes_over, [&](const fs::path& folder) { denied.push_back(folder); });
  if (!denied.empty()) {
    fmt::print(stderr, "Not read, for want of permission: {} ({} first).\n", Counted(denied.size(), "folder"),
               Printable(denied.front().string()));
  }
  if (!passed_over.empty()) {
    fmt::print(stderr,
               "Not read, as parts of a map that was made there: {} ({} first). A file that is given by "
               "itself counts.\n",
               Counted(passed_over.size(), "file"), Printable(passed_over.front().string()));
  }
  return files;
}

Result<FileDescriptor> TakeOutFolder(const fs::path& out_dir) {
  FileDescriptor folder(open(out_dir.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (folder.is_open() && flock(folder.get(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    return Error{
        ErrorCode::kConflict,
        fmt::format("{}: another run makes its map just now. Nothing was changed. Wait until that has "
                    "ended, or choose another folder.",
                    out_dir.string())};
  }
  return Result<FileDescriptor>(std::move(folder));
}

Result<void> CheckNoInputIsReplaced(const fs::path& out_dir, const std::vector<flight::InputFile>& files) {
  // Beside a state of ours the products are ours too, whatever folder was given to read; but not a list that
  // somebody put there.
  const bool has_map = storage::MapKeeper::StatedFacts(out_dir).ok();
  if (has_map && IsGeoTxtOfMap(out_dir / kGeoTxt)) return {};
  const std::vector<std::string> names = has_map ? std::vector<std::string>{kGeoTxt} : ProductNames();
  for (const flight::InputFile& file : files) {
    for (const std::string& name : names) {
      std::error_code none;  // a product that is not there yet replaces nothing
      if (!fs::equivalent(file.path, out_dir / name, none)) continue;
      return Error{
          ErrorCode::kConflict,
          fmt::format("{} is one of the files given and would be replaced by the map's own {}. Nothing "
                      "was changed. Choose another folder with -o.",
                      file.path.string(), name)};
    }
  }
  return {};
}

pipeline::MapHeights HeightsIn(const fs::path& out_dir) {
  std::error_code none;
  if (fs::exists(out_dir / "dtm_ground.tif", none)) return pipeline::MapHeights::kGround;
  return fs::exists(out_dir / "dsm_photos.tif", none) ? pipeline::MapHeights::kSurface
                                                      : pipeline::MapHeights::kNone;
}

}  // namespace skyquilt::server
