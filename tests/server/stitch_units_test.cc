// A flight that is cut into units becomes the map that one process makes of it, however it is cut.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>

#include "core/flight/read_flight.h"
#include "core/geo/boundary.h"
#include "core/pipeline/check_photos.h"
#include "core/pipeline/report/flight_facts.h"
#include "core/pipeline/units/flight_cut.h"
#include "core/pipeline/units/map_units.h"
#include "core/simulate/simulate_flight.h"
#include "server/jobs/stitch_job.h"
#include "server/jobs/stitch_unit.h"
#include "storage/db/sqlite_db.h"
#include "storage/files/publish_file.h"
#include "storage/tilesets/map_keeper.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::server {
namespace {

namespace fs = std::filesystem;

using Tiles = std::map<std::tuple<std::int64_t, std::int64_t, std::int64_t>, std::string>;

Tiles TilesOf(const fs::path& mbtiles) {
  Tiles tiles;
  auto db = storage::SqliteDb::Open(mbtiles, storage::OpenMode::kReadOnlyImmutable);
  EXPECT_TRUE(db.ok()) << db.error().message;
  auto query = db->Prepare("SELECT zoom_level, tile_column, tile_row, tile_data FROM tiles");
  EXPECT_TRUE(query.ok());
  while (*query->Step()) {
    const auto bytes = query->ColumnBlob(3);
    tiles[{query->ColumnInt64(0), query->ColumnInt64(1), query->ColumnInt64(2)}] = {bytes.begin(),
                                                                                    bytes.end()};
  }
  return tiles;
}

std::string BytesOf(const fs::path& path) {
  auto bytes = storage::ReadWholeFile(path);
  EXPECT_TRUE(bytes.ok()) << path;
  return bytes ? *bytes : std::string();
}

class StitchUnits : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new test::TemporaryFolder;
    simulate::SimulateOptions simulated;
    simulated.trajectory.photos = 12;
    simulated.intrinsics = camera::Intrinsics::Centered(800, 600, 620.0);
    simulated.write_world = false;
    SilentProgress progress;
    ASSERT_TRUE(simulate::SimulateFlight(simulated, folder_->path(), progress).ok());
    files_ = *flight::ListInputFiles({*folder_ / "photos"});
    StitchJobOptions options;
    options.mosaic = Options();
    options.write_cog = options.write_pmtiles = true;
    const auto whole = test::ValueOf(StitchToDirectory(files_, options, *folder_ / "whole", progress));
    ASSERT_EQ(whole.photos_aligned, 12);
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }

  static pipeline::MosaicOptions Options() {
    pipeline::MosaicOptions options;
    options.threads = 2;
    options.boundary = boundary_;
    return options;
  }

  static Result<UnitDone> Run(const UnitFiles& units, const UnitToDo& todo,
                              const std::vector<flight::InputFile>& files) {
    fs::create_directories(units.Folder(todo.kind, todo.number));
    SilentProgress progress;
    return StitchUnit(files, todo, units, units.Folder(todo.kind, todo.number), Options(), progress);
  }

  // What a worker that has none of the photos fetches for a range.
  static std::vector<flight::InputFile> ShownIn(const UnitFiles& units, int number, int renders,
                                                std::int64_t blocks) {
    const auto shown = pipeline::ParseShown(BytesOf(units.Shown()));
    EXPECT_TRUE(shown.ok() && shown->of_blocks.size() == static_cast<std::size_t>(blocks));
    const std::set<std::string> names = shown->NamesIn(pipeline::RangeOf(number, renders, blocks));
    std::vector<flight::InputFile> files;
    std::copy_if(files_.begin(), files_.end(), std::back_inserter(files),
                 [&](const flight::InputFile& file) { return names.count(file.name) > 0; });
    return files;
  }

  // Every unit, and the map of them in `root`/map.
  static void Stitch(const fs::path& root, int looks, int renders) {
    const UnitFiles units(root / "units");
    for (int number = 0; number < looks; ++number) {
      const auto range = pipeline::RangeOf(number, looks, files_.size());
      const auto begin = files_.begin();
      const auto looked = Run(units, {UnitKind::kLook, number, looks},
                              {begin + static_cast<int>(range.first), begin + static_cast<int>(range.end)});
      ASSERT_TRUE(looked.ok()) << looked.error().message;
    }
    const auto placed = Run(units, {.kind = UnitKind::kPlace, .looks = looks}, files_);
    ASSERT_TRUE(placed.ok()) << placed.error().message;
    ASSERT_GT(placed->blocks, renders);
    StitchJobOptions options;
    options.mosaic = Options();
    options.write_cog = options.write_pmtiles = true;
    options.facts_file = units.Facts();
    for (int number = 0; number < renders; ++number) {
      const auto rendered = Run(
          units, {.kind = UnitKind::kRender, .number = number, .count = renders, .blocks = placed->blocks},
          ShownIn(units, number, renders, placed->blocks));
      ASSERT_TRUE(rendered.ok()) << rendered.error().message;
      options.part_dirs.push_back(units.Folder(UnitKind::kRender, number));
    }
    SilentProgress progress;
    const auto map = test::ValueOf(StitchToDirectory(files_, options, root / "map", progress));
    EXPECT_EQ(map.blocks_kept, map.blocks);
    EXPECT_EQ(map.photos_aligned, 12);
  }

  static test::TemporaryFolder* folder_;
  static std::vector<flight::InputFile> files_;
  static std::optional<geo::Boundary> boundary_;  // of maps made from now on
};

test::TemporaryFolder* StitchUnits::folder_ = nullptr;
std::vector<flight::InputFile> StitchUnits::files_;
std::optional<geo::Boundary> StitchUnits::boundary_;

TEST_F(StitchUnits, TheMapIsThatOfOneProcess) {
  Stitch(*folder_ / "3", 3, 4);
  EXPECT_TRUE(TilesOf(*folder_ / "whole" / "mosaic.mbtiles") ==
              TilesOf(*folder_ / "3" / "map" / "mosaic.mbtiles"));
  for (const char* name :
       {"photos.geojson", "locate.json", "mosaic.mbtiles", "mosaic.tif", "mosaic.pmtiles", "thumbnail.png"}) {
    EXPECT_TRUE(BytesOf(*folder_ / "whole" / name) == BytesOf(*folder_ / "3" / "map" / name)) << name;
  }
}

TEST_F(StitchUnits, AMapCutToABoundaryIsThatOfOneProcess) {
  SilentProgress progress;
  StitchJobOptions options;
  options.mosaic = Options();
  const auto uncut = test::ValueOf(pipeline::ParseFacts(*storage::MapKeeper::FactsOf(*folder_ / "whole")));
  const geo::Wgs84 middle = uncut.flight.frame.origin();
  const double half_deg = 12.0 / 111'320.0;
  boundary_ = geo::Boundary{{{{{middle.lat_deg - half_deg, middle.lon_deg - half_deg},
                               {middle.lat_deg - half_deg, middle.lon_deg + half_deg},
                               {middle.lat_deg + half_deg, middle.lon_deg},
                               {middle.lat_deg - half_deg, middle.lon_deg - half_deg}}}}};
  options.mosaic.boundary = boundary_;
  const auto cut = test::ValueOf(StitchToDirectory(files_, options, *folder_ / "whole cut", progress));
  EXPECT_NEAR(cut.area_m2, 0.5 * 24.0 * 24.0 * std::cos(geo::DegToRad(middle.lat_deg)), 3.0);
  Stitch(*folder_ / "cut", 2, 2);
  boundary_.reset();
  EXPECT_TRUE(TilesOf(*folder_ / "whole cut" / "mosaic.mbtiles") ==
              TilesOf(*folder_ / "cut" / "map" / "mosaic.mbtiles"));
  EXPECT_TRUE(BytesOf(*folder_ / "whole cut" / "locate.json") == BytesOf(*folder_ / "whole" / "locate.json"));
}

TEST_F(StitchUnits, AnotherCutGivesTheSameBytes) {
  Stitch(*folder_ / "one", 1, 1);
  Stitch(*folder_ / "five", 5, 7);
  for (const char* name :
       {"mosaic.mbtiles", "mosaic.pmtiles", "mosaic.tif", "photos.geojson", "locate.json"}) {
    EXPECT_TRUE(BytesOf(*folder_ / "one" / "map" / name) == BytesOf(*folder_ / "five" / "map" / name))
        << name;
  }
}

// What a worker lost on its way is looked at again by whoever needs it.
TEST_F(StitchUnits, DamagedPartsAreToldOrMadeAnew) {
  const fs::path root = *folder_ / "damaged";
  Stitch(root, 2, 2);
  const UnitFiles units(root / "units");
  std::string found = BytesOf(units.Found(1));
  for (const std::size_t length : {std::size_t{0}, std::size_t{7}, found.size() / 2, found.size() - 1}) {
    ASSERT_TRUE(storage::WriteFileAtomically(units.Found(1), found.substr(0, length)).ok());
    EXPECT_EQ(test::ErrorOf(Run(units, {.kind = UnitKind::kPlace, .looks = 2}, files_)).code,
              ErrorCode::kCorrupt);
  }
  fs::remove(units.Found(1));
  EXPECT_EQ(Run(units, {.kind = UnitKind::kPlace, .looks = 2}, files_).error().code, ErrorCode::kNotFound);
  const auto beyond = Run(units, {.kind = UnitKind::kRender, .count = 1, .blocks = 1 << 20}, files_);
  EXPECT_EQ(beyond.error().code, ErrorCode::kInvalidArgument);

  // A range that is gone is rendered by the one that puts the map together.
  fs::remove_all(units.Folder(UnitKind::kRender, 1));
  StitchJobOptions options;
  options.mosaic = Options();
  options.facts_file = units.Facts();
  options.part_dirs = {units.Folder(UnitKind::kRender, 0), units.Folder(UnitKind::kRender, 1)};
  SilentProgress progress;
  const auto map = test::ValueOf(StitchToDirectory(files_, options, root / "again", progress));
  EXPECT_LT(map.blocks_kept, map.blocks);
  EXPECT_TRUE(TilesOf(*folder_ / "whole" / "mosaic.mbtiles") == TilesOf(root / "again" / "mosaic.mbtiles"));
}

TEST_F(StitchUnits, AUnitIsWholeWhereAllThatItLeavesIsThere) {
  const fs::path root = *folder_ / "whole units";
  Stitch(root, 1, 1);
  const UnitFiles units(root / "units");
  for (const UnitKind kind : {UnitKind::kLook, UnitKind::kPlace, UnitKind::kRender}) {
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(units.Folder(kind, 0)))
      names.insert(entry.path().filename().string());
    EXPECT_TRUE(IsWhole(kind, names)) << UnitKindName(kind);
    for (const std::string& name : names) {
      std::set<std::string> fewer = names;
      fewer.erase(name);
      EXPECT_FALSE(IsWhole(kind, fewer)) << UnitKindName(kind) << " without " << name;
    }
    EXPECT_FALSE(IsWhole(kind, {}));
  }
}

TEST_F(StitchUnits, ARangeShowsSomeOfThePhotosAndAllRangesAllOfThem) {
  const fs::path root = *folder_ / "shown";
  Stitch(root, 1, 6);
  const UnitFiles units(root / "units");
  const auto shown = test::ValueOf(pipeline::ParseShown(BytesOf(units.Shown())));
  const std::size_t blocks = shown.of_blocks.size();
  std::set<std::string> all;
  std::size_t fewest = files_.size();
  for (std::size_t unit = 0; unit < 6; ++unit) {
    const std::set<std::string> names = shown.NamesIn(pipeline::RangeOf(unit, 6, blocks));
    fewest = std::min(fewest, names.size());
    all.insert(names.begin(), names.end());
  }
  EXPECT_EQ(all.size(), files_.size());
  EXPECT_LT(fewest, files_.size());
  EXPECT_TRUE(shown.NamesIn({blocks, blocks + 9}).empty());
}

TEST_F(StitchUnits, ShownPhotosThatAreDamagedAreRefused) {
  pipeline::ShownPhotos shown{{"a.jpg", "b.jpg"}, {{0, 1}, {}, {1}}};
  const std::string bytes = pipeline::WriteShown(shown);
  const auto read = test::ValueOf(pipeline::ParseShown(bytes));
  EXPECT_EQ(read.names, shown.names);
  EXPECT_EQ(read.of_blocks, shown.of_blocks);
  for (std::size_t length = 0; length < bytes.size(); ++length)
    EXPECT_EQ(pipeline::ParseShown(bytes.substr(0, length)).error().code, ErrorCode::kCorrupt) << length;
  shown.of_blocks[1] = {2};
  EXPECT_EQ(pipeline::ParseShown(pipeline::WriteShown(shown)).error().code, ErrorCode::kCorrupt);
}

TEST_F(StitchUnits, PartsOfNoPossibleSizeAreRefused) {
  const auto is_refused = [](auto spoil) {
    pipeline::FoundFiles found, read;
    found.digests["a.jpg"] = {};
    pipeline::CheckedPhoto& photo = found.photos["a.jpg"];
    photo.features.emplace().keypoints.resize(3);
    photo.features->descriptors.resize(3);
    spoil(*photo.features);
    const Result<void> parsed = pipeline::ParseFound(pipeline::WriteFound(found), read);
    return !parsed && parsed.error().code == ErrorCode::kCorrupt;
  };
  EXPECT_FALSE(is_refused([](auto&) {}));
  EXPECT_TRUE(is_refused([](auto& features) { features.descriptors.pop_back(); }));
  EXPECT_TRUE(is_refused([](auto& features) { features.detail.resize(7); }));
  EXPECT_TRUE(is_refused([](auto& features) { features.thumbnail.width_px = 1 << 20; }));
  EXPECT_TRUE(is_refused(
      [](auto& features) { features.keypoints.resize(70'000), features.descriptors.resize(70'000); }));
}

}  // namespace
}  // namespace skyquilt::server
