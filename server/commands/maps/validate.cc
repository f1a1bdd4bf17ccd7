#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/base/text/json_io.h"
#include "core/base/text/printable.h"
#include "server/commands/commands.h"
#include "server/terminal/fail.h"
#include "server/terminal/terminal_progress.h"
#include "storage/validation/validate_map.h"

namespace skyquilt::server {
namespace {

using storage::FileVerdict;
using storage::Severity;

struct ValidateArguments {
  std::filesystem::path map;
  bool quick = false, as_json = false, strict = false;
};

int CountOf(const std::vector<FileVerdict>& verdicts, Severity severity) {
  int count = 0;
  for (const FileVerdict& verdict : verdicts) {
    for (const storage::Finding& finding : verdict.findings) count += finding.severity == severity ? 1 : 0;
  }
  return count;
}

void PrintText(const std::vector<FileVerdict>& verdicts, bool is_sound) {
  for (const FileVerdict& verdict : verdicts) {
    std::string line = verdict.file + ": " + verdict.kind;
    if (verdict.tiles)
      line += fmt::format(", {}, zoom {} to {}", Counted(*verdict.tiles, "tile"), verdict.min_zoom,
                          verdict.max_zoom);
    fmt::print("{}\n", Printable(line));
    for (const storage::Finding& finding : verdict.findings)
      fmt::print("  {}: {}\n", storage::SeverityName(finding.severity), Printable(finding.what));
  }
  fmt::print("{}: {}, {}\n", is_sound ? "Sound" : "Not sound",
             Counted(CountOf(verdicts, Severity::kError), "error"),
             Counted(CountOf(verdicts, Severity::kWarning), "warning"));
}

void PrintJson(const std::vector<FileVerdict>& verdicts, const std::string& map, bool is_sound) {
  using nlohmann::ordered_json;
  ordered_json files = ordered_json::array();
  for (const FileVerdict& verdict : verdicts) {
    ordered_json file = {{"file", verdict.file}, {"kind", verdict.kind}};
    if (verdict.tiles) {
      file["tiles"] = *verdict.tiles;
      file["min_zoom"] = verdict.min_zoom;
      file["max_zoom"] = verdict.max_zoom;
      if (verdict.tile_size_px > 0) file["tile_size_px"] = verdict.tile_size_px;
    }
    if (verdict.bounds) file["bounds"] = verdict.bounds->ToArray();
    file["findings"] = ordered_json::array();
    for (const storage::Finding& finding : verdict.findings)
      file["findings"].push_back(
          {{"severity", storage::SeverityName(finding.severity)}, {"what", finding.what}});
    files.push_back(std::move(file));
  }
  const ordered_json all = {{"map", map},
                            {"sound", is_sound},
                            {"errors", CountOf(verdicts, Severity::kError)},
                            {"warnings", CountOf(verdicts, Severity::kWarning)},
                            {"files", std::move(files)}};
  fmt::print("{}\n", JsonText(all, 2));
}

void Run(const ValidateArguments& arguments) {
  const auto verdicts = OrFail("skyquilt validate", [&] {
    TerminalProgress progress;
    return storage::ValidateMap(arguments.map, arguments.quick, progress);
  }());
  const bool is_sound = CountOf(verdicts, Severity::kError) == 0 &&
                        (!arguments.strict || CountOf(verdicts, Severity::kWarning) == 0);
  if (arguments.as_json) {
    PrintJson(verdicts, arguments.map.string(), is_sound);
  } else {
    PrintText(verdicts, is_sound);
  }
  if (!is_sound) throw CLI::RuntimeError(1);
}

}  // namespace

void AddValidateCommand(CLI::App& app) {
  const auto arguments = std::make_shared<ValidateArguments>();
  CLI::App* command =
      app.add_subcommand("validate", "Say whether a map is sound: ours, or a file of anybody");
  command
      ->add_option("MAP", arguments->map,
                   "Folder that \"stitch\" wrote, or an MBTiles, PMTiles or GeoTIFF of any program")
      ->required()
      ->check(CLI::ExistingPath);
  command->add_flag("--quick", arguments->quick, "Decode one picture in fifty, not all");
  command->add_flag("--strict", arguments->strict, "Warnings count as errors");
  command->add_flag("--json", arguments->as_json, "Print JSON");
  command->footer(
      "\nErrors are what makes programs fail or show something wrong: damage, missing pieces, tiles that lie\n"
      "elsewhere than the file says. Warnings are what makes a map slow or odd, such as a GeoTIFF without\n"
      "overviews. Nothing is changed. Ends with 0 when the map is sound, with 1 when it is not or cannot be read.\n"
      "Examples:\n"
      "  skyquilt validate map\n"
      "  skyquilt validate orthophoto.tif --json");
  command->callback([arguments] { Run(*arguments); });
}

}  // namespace skyquilt::server
