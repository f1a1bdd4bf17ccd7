#include "server/commands/maps/compare.h"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "server/comparison/compare_methods.h"
#include "server/comparison/comparison_picture.h"
#include "server/terminal/fail.h"
#include "server/usage/length.h"
#include "storage/files/publish_file.h"

namespace skyquilt::server {
namespace {

namespace fs = std::filesystem;

struct CompareArguments {
  std::vector<fs::path> inputs;
  fs::path out_dir;
  fs::path truth;
  pipeline::MosaicOptions options;
  double max_memory_gib = 1.0;
};

// What `simulate` lays beside the photos; empty when the flight is a real one.
fs::path TruthBeside(const std::vector<fs::path>& inputs) {
  for (const fs::path& input : inputs) {
    const fs::path folder = fs::absolute(input).lexically_normal();
    const fs::path parent = folder.has_filename() ? folder.parent_path() : folder.parent_path().parent_path();
    for (const fs::path& place : {folder, parent}) {
      fs::path truth = place / "truth" / "poses.json";
      if (fs::exists(truth)) return truth;
    }
  }
  return {};
}

void Run(CompareArguments& arguments) {
  const auto files = flight::ListInputFiles(arguments.inputs);
  if (!files) Fail("skyquilt", files.error());
  arguments.options.max_memory_bytes = static_cast<std::int64_t>(arguments.max_memory_gib * (1 << 30));
  if (arguments.truth.empty()) arguments.truth = TruthBeside(arguments.inputs);
  std::ostringstream truth_json;
  if (!arguments.truth.empty()) truth_json << std::ifstream(arguments.truth, std::ios::binary).rdbuf();
  const auto outcomes = CompareMethods(*files, arguments.options, truth_json.str(), arguments.out_dir);
  if (!outcomes) Fail("skyquilt", outcomes.error());
  const Result<std::string> picture = ComparisonPng(*outcomes);
  if (!picture) Fail("skyquilt", picture.error());
  const std::string table = ComparisonMarkdown(*outcomes);
  for (const auto& [name, text] :
       {std::pair{"compare.md", table}, std::pair{"compare.json", ComparisonJson(*outcomes)},
        std::pair{"compare.png", *picture}}) {
    if (auto written = storage::WriteFileAtomically(arguments.out_dir / name, text); !written) {
      Fail("skyquilt", written.error());
    }
  }
  fmt::print("{}\n{}\n", table, (arguments.out_dir / "compare.png").string());
}

}  // namespace

void AddCompareCommand(CLI::App& app) {
  auto arguments = std::make_shared<CompareArguments>();
  CLI::App* command = app.add_subcommand(
      "compare", "Stitch one flight by every method and lay the maps and their figures side by side");
  command->add_option("IN", arguments->inputs, "Photos, logs, or folders of them, as for stitch")
      ->required()
      ->check(CLI::ExistingPath);
  command
      ->add_option("-o,--out", arguments->out_dir,
                   "Folder for compare.md, compare.json, compare.png and one map a method; made if missing")
      ->required();
  command
      ->add_option("--truth", arguments->truth,
                   "truth/poses.json of a simulated flight (default: found beside the photos)")
      ->check(CLI::ExistingFile);
  AddGsdOptions(*command, arguments->options.gsd_m, arguments->options.any_gsd);
  command
      ->add_option("--threads", arguments->options.threads,
                   "Threads; 0 takes all cores. The maps are the same with any number")
      ->capture_default_str();
  command->add_option("--max-memory", arguments->max_memory_gib, "Memory for photos and tiles in GiB")
      ->capture_default_str();
  command->footer(
      "Methods: imu places photos by their recorded poses and uses no pixel; features chains homographies\n"
      "from photo to photo and uses no pose (both of Iz and Unel); direct shifts whole pictures against each\n"
      "other; auto is what stitch does. Each runs in a process of its own, so that time and memory are its own.\n"
      "Where a log has raw inertial samples, reckon is the drift of dead reckoning between captures.\n"
      "Seam shift: how far two photos that meet disagree about where things are. Error, for simulated "
      "flights:\n"
      "nine of ten pixels lie nearer to their true place; relative: after the best shift, turn and scale.\n"
      "Example:\n  skyquilt simulate -o demo --noise xmp --relief-m 4\n  skyquilt compare demo/photos -o "
      "compared");
  command->callback([arguments] { Run(*arguments); });
}

}  // namespace skyquilt::server
