// Lengths as people write them: metres, or with their unit ("0.05", "5cm", "5 cm", "2in"). ParseLengthM: that
// in metres; nothing where the text is none. Length: the check of an option that takes one, which becomes the
// number of metres. AddGsdOptions: --gsd and --any-gsd, for every command that makes maps. Pure; any thread.
#pragma once

#include <optional>
#include <string_view>

namespace CLI {
class App;
class Validator;
}  // namespace CLI

namespace skyquilt::server {

std::optional<double> ParseLengthM(std::string_view text);

CLI::Validator Length();

// Both outlive the command line.
void AddGsdOptions(CLI::App& command, std::optional<double>& gsd_m, bool& any_gsd);

}  // namespace skyquilt::server
