#include "server/manual/manual_page.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string_view>
#include <vector>

#include "core/base/text/xml_text.h"

namespace skyquilt::server {
namespace {

// Text of man(7): what would be a request or an escape is not one.
std::string Roff(std::string_view text) {
  const std::string escaped = Escaped(text, {{'\\', "\\e"},
                                             {'-', "\\-"},
                                             {'"', "\\(dq"},
                                             {'\'', "\\(aq"},
                                             {'^', "\\(ha"},
                                             {'~', "\\(ti"},
                                             {'`', "\\(ga"},
                                             {'\n', " "}});
  return escaped.starts_with('.') ? "\\&" + escaped : escaped;
}

std::string Bold(std::string_view text) { return "\\fB" + Roff(text) + "\\fR"; }
std::string Italic(std::string_view text) { return "\\fI" + Roff(text) + "\\fR"; }

std::string Sentence(std::string_view text) {
  const bool has_end = text.ends_with('.') || text.ends_with('?') || text.ends_with('!');
  return Roff(text) + (has_end ? "" : ".");
}

std::string SynopsisOf(const DescribedCommand& command) {
  std::string text = Bold(command.Words());
  for (const DescribedOption& option : command.options) {
    if (option.is_required) text += fmt::format(" {} {}", Bold(option.names.back()), Italic(option.value));
  }
  if (!command.options.empty()) text += fmt::format(" [{}]...", Italic("OPTION"));
  for (const DescribedOption& argument : command.arguments) {
    const std::string several = argument.takes_several ? "..." : "";
    const std::string name = Italic(argument.names.front()) + several;
    text += argument.is_required ? " " + name : " [" + name + "]";
  }
  if (!command.commands.empty()) text += " " + Italic("COMMAND") + " ...";
  return text + "\n";
}

// "INT in [0 - 64]", as the library says it: "0 to 64".
std::string RangeIn(const std::string& bounds) {
  if (bounds == "POSITIVE") return "more than 0";
  const std::size_t begin = bounds.rfind(" in [");
  const std::size_t dash = bounds.rfind(" - ");
  if (begin == std::string::npos || dash == std::string::npos || dash < begin || !bounds.ends_with(']'))
    return bounds;
  const std::size_t first = begin + 5;
  const std::size_t second = dash + 3;
  return bounds.substr(first, dash - first) + " to " + bounds.substr(second, bounds.size() - 1 - second);
}

// As the library names its checks of files and folders.
bool IsOfWhatExists(const std::string& bounds) {
  return bounds == "FILE" || bounds == "DIR" || bounds == "PATH(existing)";
}

std::string Paragraph(const DescribedOption& option) {
  std::vector<std::string> names;
  const bool is_argument = !option.names.front().starts_with('-');
  for (const std::string& name : option.names) names.push_back(is_argument ? Italic(name) : Bold(name));
  std::string head = fmt::format("{}", fmt::join(names, ", "));
  if (!option.value.empty() && !is_argument)
    head += " " + Italic(option.value) + (option.takes_several ? "..." : "");
  std::string text = fmt::format(".TP\n{}\n", head);
  if (!option.about.empty()) text += Sentence(option.about) + "\n";
  if (!option.words.empty()) {
    std::vector<std::string> words;
    for (const std::string& word : option.words) words.push_back(Bold(word));
    text += fmt::format("One of: {}.\n", fmt::join(words, ", "));
  }
  if (IsOfWhatExists(option.bounds)) {
    text += "It must exist.\n";
  } else if (!option.bounds.empty()) {
    text += fmt::format("Takes {}.\n", Roff(RangeIn(option.bounds)));
  }
  if (!option.default_value.empty()) text += fmt::format("Default: {}.\n", Bold(option.default_value));
  if (option.is_required) text += "Required.\n";
  if (!option.variable.empty()) text += fmt::format("Environment: {}.\n", Bold(option.variable));
  return text;
}

std::string Paragraphs(const char* title, const std::vector<DescribedOption>& options) {
  if (options.empty()) return "";
  std::string text = title;
  for (const DescribedOption& option : options) text += Paragraph(option);
  return text;
}

std::string ListOfCommands(const DescribedCommand& command) {
  std::string text = ".SH COMMANDS\n";
  for (const DescribedCommand& below : command.commands)
    text += fmt::format(".TP\n{}\n{}\n", Bold(below.path.back()), Sentence(below.about));
  return text;
}

struct Footer {
  std::string sentences, examples;
};

Footer FooterOf(const DescribedCommand& command) {
  Footer footer;
  std::string_view rest = command.footer;
  while (!rest.empty()) {
    const std::string_view line = rest.substr(0, rest.find('\n'));
    rest.remove_prefix(std::min(line.size() + 1, rest.size()));
    if (line.starts_with("  ")) {
      footer.examples += Roff(line.substr(2)) + "\n";
    } else if (!line.empty() && !line.starts_with("Example")) {
      footer.sentences += (footer.sentences.empty() ? ".PP\n" : "") + Roff(line) + "\n";
    }
  }
  if (!footer.examples.empty()) footer.examples = ".EX\n" + footer.examples + ".EE\n";
  return footer;
}

// `skyquilt token add` stands in the page of `skyquilt token`.
std::string CommandsBelow(const DescribedCommand& command) {
  std::string text = ".SH COMMANDS\n";
  for (const DescribedCommand& below : command.commands) {
    text += fmt::format(".SS {}\n{}.PP\n{}\n", Roff(below.Words()), SynopsisOf(below), Sentence(below.about));
    text += FooterOf(below).sentences;
    text += Paragraphs("", below.arguments) + Paragraphs("", below.options);
  }
  return text;
}

constexpr std::string_view kExamples = R"(.SH EXAMPLES
Serve at http://127.0.0.1:8080, and upload a folder of photos to it:
.PP
.EX
skyquilt serve \-\-data data
skyquilt upload DCIM \-\-server http://127.0.0.1:8080
.EE
.PP
Make a map without a server:
.PP
.EX
skyquilt stitch DCIM \-o map
.EE
.PP
Let others in who have a token, which is printed once:
.PP
.EX
skyquilt token add field\-team \-\-data data \-\-scope upload
skyquilt serve \-\-data data \-\-listen 0.0.0.0:8080
.EE
)";

constexpr std::string_view kExitStatus = R"(.SH EXIT STATUS
.TP
.B 0
It is done.
.TP
.B 1
It could not be done, and standard error says why and what to do; or \fBvalidate\fR found that a map is not sound.
.TP
.B 2
\fBinspect\fR found no photo that can be placed, or \fBdata\fR something that is not in order.
.TP
.B 3
\fBworker \-\-once\fR found nothing to do.
.TP
.B 64
The command line names a command or option that does not exist.
.TP
.B 70
The machine ran out of something.
.TP
.B 104 to 114
A value or an option does not fit, or one is missing.
.TP
.B 130
It was cancelled.
)";

constexpr std::string_view kServeFiles = R"(.SH FILES
.TP
.I /etc/skyquilt.conf
Options of the service of the Debian package, one "name = value" per line, as
.B \-\-config
takes them.
What the environment or the command line say comes first.
.TP
.I /etc/default/skyquilt
Variables for the service, such as keys of an S3 store; not there unless you make it.
.TP
.I /var/lib/skyquilt
The data folder of the service.
)";

std::string SeeAlso(const DescribedCommand& command, const DescribedCommand& program) {
  std::vector<std::string> pages;
  if (!command.path.empty()) pages.push_back("\\fBskyquilt\\fR(1)");
  for (const DescribedCommand& other : program.commands) {
    if (command.path.empty()) pages.push_back(fmt::format("{}(1)", Bold(NameOfManualPage(other))));
  }
  return fmt::format(".SH SEE ALSO\n{}\n", fmt::join(pages, ",\n"));
}

}  // namespace

std::string NameOfManualPage(const DescribedCommand& command) {
  std::string name = "skyquilt";
  for (const std::string& word : command.path) name += "-" + word;
  return name;
}

std::string ManualPage(const DescribedCommand& command, const DescribedCommand& program,
                       const std::string& version, const std::string& day) {
  const std::string name = NameOfManualPage(command);
  const bool is_program = command.path.empty();
  std::string title = name;
  for (char& letter : title)
    letter = 'a' <= letter && letter <= 'z' ? static_cast<char>(letter - 32) : letter;
  std::string text =
      fmt::format(".\\\" Made by \"skyquilt man\".\n.TH {} 1 {} \"Skyquilt {}\" \"User Commands\"\n",
                  Roff(title), day, version);
  const std::size_t colon = is_program ? command.about.find(": ") : std::string::npos;
  const std::string about = colon == std::string::npos ? command.about : command.about.substr(colon + 2);
  text += fmt::format(".SH NAME\n{} \\- {}\n.SH SYNOPSIS\n{}", Roff(name), Roff(about), SynopsisOf(command));
  text += fmt::format(".SH DESCRIPTION\n{}\n", Sentence(command.about));
  const Footer footer = FooterOf(command);
  text += footer.sentences;
  if (is_program) {
    text +=
        "Each command has a page of its own; \\fBskyquilt\\fR \\fICOMMAND\\fR \\fB\\-\\-help\\fR says the same.\n";
    text += ListOfCommands(command);
  } else if (!command.commands.empty()) {
    text += CommandsBelow(command);
  }
  text += Paragraphs(".SH ARGUMENTS\n", command.arguments) + Paragraphs(".SH OPTIONS\n", command.options);
  if (is_program) text += kExamples;
  if (!footer.examples.empty()) text += ".SH EXAMPLES\n" + footer.examples;
  if (command.path == std::vector<std::string>{"serve"}) text += kServeFiles;
  text += kExitStatus;
  return text + SeeAlso(command, program);
}

}  // namespace skyquilt::server
