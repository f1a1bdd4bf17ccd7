#include "server/reports/print_pdf.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <boost/process/args.hpp>
#include <boost/process/child.hpp>
#include <boost/process/group.hpp>
#include <boost/process/io.hpp>
#include <chrono>
#include <cstdlib>
#include <sstream>
#include <string>
#include <system_error>
#include <vector>

#include "storage/files/publish_file.h"

namespace skyquilt::server {
namespace {

namespace fs = std::filesystem;
namespace process = boost::process;

constexpr std::chrono::minutes kPrintTime{2};
constexpr std::chrono::milliseconds kPrintPollInterval{200};
constexpr std::size_t kMaxWordsBytes = 300;

enum class Printer { kWeasyPrint, kChromium, kWkHtml };
struct PrinterName {
  const char* program;
  Printer kind;
};
constexpr std::array kPrinters = {
    PrinterName{"weasyprint", Printer::kWeasyPrint},         PrinterName{"chromium", Printer::kChromium},
    PrinterName{"chromium-browser", Printer::kChromium},     PrinterName{"google-chrome", Printer::kChromium},
    PrinterName{"google-chrome-stable", Printer::kChromium}, PrinterName{"wkhtmltopdf", Printer::kWkHtml}};

std::vector<std::string> WordsFor(Printer kind, const fs::path& html, const fs::path& pdf,
                                  const fs::path& work_dir) {
  if (kind == Printer::kWeasyPrint) return {html.string(), pdf.string()};
  if (kind == Printer::kWkHtml) return {"--quiet", "--disable-javascript", html.string(), pdf.string()};
  std::vector<std::string> words = {"--headless",
                                    "--disable-gpu",
                                    "--disable-extensions",
                                    "--no-first-run",
                                    "--no-pdf-header-footer",
                                    "--user-data-dir=" + (work_dir / "profile").string(),
                                    "--print-to-pdf=" + pdf.string()};
  // Root has no user namespace to put it into; the page is ours and holds no script.
  if (geteuid() == 0) words.emplace_back("--no-sandbox");
  words.push_back("file://" + html.string());
  return words;
}

// Along PATH; empty where it is not.
std::string FindProgram(const char* name) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "/usr/bin:/bin" : path);
  for (std::string folder; std::getline(folders, folder, ':');) {
    const fs::path program = fs::path(folder) / name;
    std::error_code none;
    if (!folder.empty() && fs::is_regular_file(program, none) && access(program.c_str(), X_OK) == 0)
      return program.string();
  }
  return {};
}

// What the program said last; nothing where that cannot be read.
std::string LastWords(const fs::path& log) {
  const Result<std::string> text = storage::ReadWholeFile(log);
  std::istringstream lines(text ? *text : "");
  std::string last;
  for (std::string line; std::getline(lines, line);)
    if (!line.empty()) last = line;
  return last.empty() ? "." : ": " + last.substr(0, kMaxWordsBytes);
}

}  // namespace

bool CanPrintPdf() {
  return std::any_of(kPrinters.begin(), kPrinters.end(),
                     [](const PrinterName& printer) { return !FindProgram(printer.program).empty(); });
}

Result<void> PrintPdf(const fs::path& html, const fs::path& pdf, const fs::path& work_dir,
                      const std::function<bool()>& go_on) {
  for (const PrinterName& printer : kPrinters) {
    const std::string program = FindProgram(printer.program);
    if (program.empty()) continue;
    const fs::path log = work_dir / "print.log";
    try {
      process::group group;
      process::child child(program, process::args(WordsFor(printer.kind, html, pdf, work_dir)),
                           process::std_in<process::null, process::std_out> process::null,
                           process::std_err > log.string(), group);
      const auto end = std::chrono::steady_clock::now() + kPrintTime;
      const auto stop = [&] {
        group.terminate();
        child.wait();
      };
      while (!child.wait_for(kPrintPollInterval)) {
        if (go_on && !go_on()) {
          stop();
          return Error{ErrorCode::kCancelled, "The report was cancelled.", ""};
        }
        if (std::chrono::steady_clock::now() < end) continue;
        stop();
        return Error{ErrorCode::kTimeout,
                     fmt::format("{} took more than {} minutes to print the report.", printer.program,
                                 kPrintTime.count()),
                     ""};
      }
      std::error_code missing;
      if (child.exit_code() == 0 && fs::file_size(pdf, missing) > 0 && !missing) return {};
      return Error{ErrorCode::kInternal,
                   fmt::format("{} could not print the report{}", printer.program, LastWords(log)), ""};
    } catch (const process::process_error& failed) {
      return Error{ErrorCode::kInternal, fmt::format("{} could not be started.", printer.program),
                   failed.what()};
    }
  }
  return Error{ErrorCode::kUnavailable,
               "A PDF is printed by WeasyPrint or Chromium, and neither is installed here. Install one "
               "(apt install weasyprint), or write report.html and print it from any browser.",
               ""};
}

}  // namespace skyquilt::server
