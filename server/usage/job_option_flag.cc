#include "server/usage/job_option_flag.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "core/base/check.h"
#include "server/usage/option_values.h"

namespace skyquilt::server {

CLI::Option* AddJobOption(CLI::App& command, std::string_view name, pipeline::MosaicOptions& options) {
  using pipeline::JobOptionKind;
  const pipeline::JobOption* found = pipeline::FindJobOption(name);
  SKYQUILT_CHECK(found && found->get, "a plain option, spelt as in the table");
  const pipeline::JobOption& row = *found;
  const std::optional<double> usual = row.get(pipeline::MosaicOptions());
  switch (row.kind) {
    case JobOptionKind::kYesNo:
      return command.add_flag_callback(
          row.Flag(), [&row, &options] { row.set(1.0, &options); }, row.help);
    case JobOptionKind::kChoice: {
      std::vector<std::pair<std::string, long>> numbers;
      for (std::size_t i = 0; i < row.choices.size(); ++i)
        numbers.emplace_back(row.choices[i], static_cast<long>(i));
      return command
          .add_option_function<long>(
              row.Flag(), [&row, &options](long chosen) { row.set(static_cast<double>(chosen), &options); },
              row.help)
          ->default_str(row.choices[static_cast<std::size_t>(*usual)])
          ->type_name("ENUM")
          ->transform(OneOfNumbers(numbers));
    }
    case JobOptionKind::kWhole:
      return command
          .add_option_function<int>(
              row.Flag(), [&row, &options](int number) { row.set(number, &options); },
              fmt::format("{}, {:g} to {:g}", row.help, row.least, row.most))
          ->default_str(fmt::format("{:g}", *usual));
    case JobOptionKind::kNumber:
    case JobOptionKind::kOther:
      break;
  }
  CLI::Option* option = command.add_option_function<double>(
      row.Flag(), [&row, &options](double number) { row.set(number, &options); },
      fmt::format("{}. {:g} to {:g}", row.help, row.least, row.most));
  if (usual) option->default_str(fmt::format("{:g}", *usual));
  return option;
}

}  // namespace skyquilt::server
