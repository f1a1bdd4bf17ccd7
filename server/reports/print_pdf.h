// PrintPdf: an HTML page as PDF, by whichever printing program this machine has (WeasyPrint, Chromium, Chrome
// or wkhtmltopdf: they are found by name and not part of Skyquilt; where one fails, the next is tried).
// Blocking, two minutes at most. Errors: kUnavailable (there is none; says what to install), kTimeout,
// kCancelled, kOutOfSpace, kIo, kInternal (it failed; its last words are told).
#pragma once

#include <filesystem>
#include <functional>

#include "core/base/result.h"

namespace skyquilt::server {

bool CanPrintPdf();

// `html`: a page that needs no other file. `work_dir`: a folder for what the program puts down. `go_on`:
// asked some times a second.
Result<void> PrintPdf(const std::filesystem::path& html, const std::filesystem::path& pdf,
                      const std::filesystem::path& work_dir, const std::function<bool()>& go_on = {});

// Such an error for whoever asked a server: of a program that failed or is not there its words are the log's;
// time that was over, a full disk and the like are told as they are.
Error ReportNotPrinted(const Error& why);

}  // namespace skyquilt::server
