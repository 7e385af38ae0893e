#pragma once

#include "altiro3D/quilt.hpp"
#include "cli/bridge_answers.hpp"
#include "cli/command_line.hpp"
#include "cli/run_tool.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

/// Looking Glass Bridge, its maker's program that shows quilts on a display.
namespace altiro3D::tools {

/// How a command line names a Bridge.
struct BridgeJob {
    std::string address; ///< `--bridge`: "auto" or "HOST:PORT".
    std::string serve;   ///< `--serve`: own address, for a Bridge on another computer.
    std::string serial;  ///< `--serial`: of one of its displays; empty: all of them.
    bool loops = true;   ///< Begins again after the last entry.
    double seconds = 20; ///< `--each`: for which each picture is shown.
};

/// --bridge --serve @param what "Also send the quilts" @param showsEntries false: only --bridge
void addBridgeOptions(CommandLine& commandLine, const std::string& what, bool showsEntries = true);
/// @return nothing without --bridge @throws UsageError
std::optional<BridgeJob> bridgeJob(const CommandLine& commandLine);

/// "Looking Glass Bridge at localhost:33334" @throws UsageError (an address that cannot be one)
std::string bridgeName(const std::string& address);

/// The displays of a Bridge. @throws UsageError, Error (no Bridge, no sensible answer)
std::vector<BridgeDevice> devicesOfBridge(const std::string& address);
/// The one display with a calibration, or that of a name or serial number. @throws as
/// devicesOfBridge(), Error NotFound, InvalidArgument (several)
BridgeDevice deviceOfBridge(const std::string& address, const std::string& serial);

/// A file that Bridge shows.
struct BridgeEntry {
    std::filesystem::path file;
    QuiltGrid grid{1, 1}; ///< A quilt's.
    double aspect = 1;    ///< Width : height of a view, or of the photo alone.
    bool isRgbd = false;  ///< Photo and depth in one picture, near = white.
    bool isStacked = false;
    double seconds = 20;
};
/// The entry of a quilt or RGB-D file, picture or video, as its name states.
/// @throws Error BadFormat (neither), and of VideoReader
BridgeEntry bridgeEntry(const std::filesystem::path& file, double panelAspect);

/// Shows files on the displays of a Bridge, as a new playlist. A Bridge on this computer reads the
/// files. For one on another computer the function serves them to it, until Ctrl-C.
/// @throws UsageError, Error
void showOnBridge(const BridgeJob& job, const std::vector<BridgeEntry>& entries,
                  Messages& messages);

/// As above, files that a tool has made; does nothing if there are none.
/// @param areRgbd RGB-D files; else quilts
void showOnBridge(const BridgeJob& job, const std::vector<std::filesystem::path>& files,
                  bool areRgbd, double panelAspect, Messages& messages);

/// A name in the cache for a quilt that Bridge reads later; the newest 20 are kept.
/// @param stem of its name @throws Error NotFound (no cache)
std::filesystem::path quiltForBridge(const std::string& stem);

} // namespace altiro3D::tools
