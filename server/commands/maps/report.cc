#include <fmt/chrono.h>
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>

#include "core/base/try.h"
#include "core/flight/bytes/text_fields.h"
#include "server/commands/arguments.h"
#include "server/commands/commands.h"
#include "server/reports/map_picture.h"
#include "server/reports/print_pdf.h"
#include "server/reports/report_page.h"
#include "server/terminal/fail.h"
#include "server/terminal/terminal_progress.h"
#include "storage/files/publish_file.h"

namespace skyquilt::server {
namespace {

namespace fs = std::filesystem;

constexpr const char* kReportCommand = "skyquilt report";

struct ReportArguments {
  fs::path map_dir;
  fs::path out;
  int picture_px = kReportPicturePx;
  bool overwrite = false;
};

bool IsPdf(const fs::path& out) {
  const std::string ending = flight::LowerCase(out.extension().string());
  if (ending == ".html" || ending == ".htm") return false;
  if (ending == ".pdf") return true;
  Refuse(kReportCommand,
         out.string() + " would be of a kind that is not written here; reports end in .html, .htm or .pdf.");
}

Result<void> WritePdf(const std::string& page, const fs::path& out, const fs::path& work_dir) {
  const fs::path html = work_dir / "report.html", pdf = work_dir / "report.pdf";
  SKYQUILT_TRY(storage::WriteFileAtomically(html, page));
  const TerminalProgress progress;  // hears Ctrl-C
  SKYQUILT_TRY(PrintPdf(html, pdf, work_dir, [&] { return !progress.IsCancelled(); }));
  std::error_code error;
  fs::rename(pdf, out, error);
  if (error) return storage::FileError("cannot write", out, error.value());
  return {};
}

void Run(const ReportArguments& arguments) {
  const fs::path out = fs::absolute(arguments.out);
  const bool is_pdf = IsPdf(arguments.out);
  CheckOutFile(kReportCommand, out, arguments.overwrite);
  const Result<std::string> report = storage::ReadWholeFile(arguments.map_dir / "report.json");
  if (!report)
    Fail(kReportCommand, {ErrorCode::kNotFound,
                          arguments.map_dir.string() +
                              " has no report.json. Name the folder that \"skyquilt stitch -o\" wrote."});
  const WorkFolder work(kReportCommand, HiddenBeside(out));
  const MapPixels pixels = OrFail(kReportCommand, [&] {
    TerminalProgress progress;
    return MakeMapPixels(arguments.map_dir, arguments.picture_px, 0, work.path(), progress);
  }());
  const MapPicture picture = EncodeMapPicture(pixels);
  const auto now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  const std::string page =
      OrFail(kReportCommand, ReportPage(*report, picture, fmt::format("{:%Y-%m-%d}", fmt::localtime(now))));
  OrFail(kReportCommand, is_pdf ? WritePdf(page, out, work.path()) : storage::WriteFileAtomically(out, page));
  fmt::print("{} ({:.1f} MB)\n", out.string(), static_cast<double>(fs::file_size(out)) / 1e6);
}

}  // namespace

void AddReportCommand(CLI::App& app) {
  const auto arguments = std::make_shared<ReportArguments>();
  CLI::App* command = app.add_subcommand(
      "report", "Write a page about a finished map: picture, scale, accuracy, what was left out");
  command->add_option("MAP", arguments->map_dir, "Folder that \"stitch\" wrote")
      ->required()
      ->check(CLI::ExistingDirectory);
  command
      ->add_option(
          "-o,--out", arguments->out,
          "File to write, to be mailed or printed: .html, or .pdf where WeasyPrint or Chromium is installed")
      ->required();
  command->add_option("--picture-px", arguments->picture_px, "Longer side of the map's picture in pixels")
      ->check(CLI::Range(200, 4000))
      ->capture_default_str();
  command->add_flag("--overwrite", arguments->overwrite, "Replace the file if it is there");
  command->footer(
      "\nExample:\n"
      "  skyquilt report map -o report.html\n"
      "  skyquilt report map -o report.pdf");
  command->callback([arguments] { Run(*arguments); });
}

}  // namespace skyquilt::server
