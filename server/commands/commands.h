// The program's subcommands. Each declares its options and what it does in a source of its name;
// RunCommandLine has the table of them, in the order of `skyquilt --help`, and gives what the process exits
// with. Once a process, main thread.
#pragma once

namespace CLI {
class App;
}

namespace skyquilt::server {

int RunCommandLine(int argc, const char* const* argv);

// Maps, without a server (maps/).
void AddStitchCommand(CLI::App& app);    // the map of a folder of photos
void AddLocateCommand(CLI::App& app);    // which photos see a place, and where a photo's pixel lies
void AddPlaceCommand(CLI::App& app);     // a map that lies nowhere on Earth brought to where it belongs
void AddExportCommand(CLI::App& app);    // a map in another format, coordinate system, area or resolution
void AddReportCommand(CLI::App& app);    // a map on one printable HTML page
void AddValidateCommand(CLI::App& app);  // whether a map, of ours or of anybody, is sound
void AddInspectCommand(CLI::App& app);   // what photos and logs contain, and what to expect of their map
void AddSimulateCommand(CLI::App& app);  // a flight that never took place, with known truth

// A running server and its data folder (uploads/, data/).
void AddServeCommand(CLI::App& app);   // web page, API and tiles, with worker processes beside them
void AddWorkerCommand(CLI::App& app);  // runs the jobs of a data folder until it is stopped
void AddUploadCommand(CLI::App& app);  // files to a server, and the map made of them
void AddWatchCommand(CLI::App& app);   // cards and hot folders become flights as they fill
void AddImportCommand(CLI::App& app);  // a map of others as a flight of a server, or of a data folder
void AddTokenCommand(CLI::App& app);   // who may use a server; also while it runs
void AddDataCommand(CLI::App& app);    // checks, repairs, moves and cleans what a stopped server has

// What this program starts by itself to decode files of users (server/sandbox); help does not list them.
void AddSandboxedCommands(CLI::App& app);

}  // namespace skyquilt::server
