#include "server/reports/print_pdf.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <sstream>
#include <string>
#include <system_error>
#include <vector>

#include "core/base/text/percent.h"
#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "server/sandbox/spawn_process.h"
#include "storage/files/publish_file.h"

namespace skyquilt::server {
namespace {

namespace fs = std::filesystem;

constexpr const char* kUsualPath = "/usr/bin:/bin";
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
  words.push_back("file://" + PercentEncoded(html.string(), "/-._~"));
  return words;
}

// Along PATH; empty where it is not.
std::string FindProgram(const char* name) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? kUsualPath : path);
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
  const char* const path = std::getenv("PATH");
  std::string failures;
  for (const PrinterName& printer : kPrinters) {
    ProgramToRun program;
    program.path = FindProgram(printer.program);
    if (program.path.empty()) continue;
    program.words = WordsFor(printer.kind, html, pdf, work_dir);
    // No TMPDIR of its own: Chromium has sockets there, whose paths may have no more than a hundred
    // characters.
    program.environment = {std::string("PATH=") + (path == nullptr ? kUsualPath : path),
                           "HOME=" + work_dir.string(), "LC_ALL=C.UTF-8"};
    program.log = work_dir / "print.log";
    SKYQUILT_TRY_ASSIGN(const int status, RunProgram(program, go_on));
    std::error_code missing;
    if (status == 0 && fs::file_size(pdf, missing) > 0 && !missing) return {};
    failures += fmt::format("{}{} could not print the report ({}){}", failures.empty() ? "" : " ",
                            printer.program, HowItEnded(status), LastWords(program.log));
    fs::remove(pdf, missing);  // the next one may be of more use
  }
  if (!failures.empty()) return Error{ErrorCode::kInternal, failures};
  return Error{ErrorCode::kUnavailable,
               "A PDF is printed by WeasyPrint or Chromium, and neither is installed here. Install one "
               "(apt install weasyprint), or write report.html and print it from any browser."};
}

Error ReportNotPrinted(const Error& why) {
  if (why.code != ErrorCode::kInternal && why.code != ErrorCode::kUnavailable) return why;
  const auto remark =
      CanPrintPdf() ? flight::RemarkCode::kReportNotPrinted : flight::RemarkCode::kExportWithoutPrinter;
  return flight::Because(why.code, remark, why.message);
}

}  // namespace skyquilt::server
