#pragma once

#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

/// What the tools ask of the system, beside what the library does. One source for each system.
namespace altiro3D::tools {

/// Prepares the standard streams for text in UTF-8 and for pictures. Lets writing to a closed pipe,
/// or beyond the user's limit of file sizes, fail instead of ending the process.
void prepareProcess();
/// Calls a function when the user or the system asks the process to stop.
void onStop(void (*handler)(int signal));
/// The arguments of this program in UTF-8, with its name.
std::vector<std::string> argumentsOf(int argc, char** argv);

/// Whether a standard stream is a terminal.
bool isTerminal(std::FILE* stream);
/// Turns standard error off. @return what turns it on again; -1: it is on
int turnOffStandardError();
void turnOnStandardError(int saved);

/// A text that changes with the file and with any change of it. Empty if it is no regular file.
std::string identityOf(const std::filesystem::path& file);
/// Whether this user may make files in a directory. @return 0 or errno
int checkDirectory(const std::filesystem::path& directory);
/// A sentence about a folder that only this machine sees, by its name or its file system; empty if
/// it looks shared.
std::string localText(const std::filesystem::path& folder);

/// A variable of the environment in UTF-8, unless it is empty.
std::optional<std::string> environment(const char* name);
/// Where programs keep what they can make again. @return empty if it is not known
std::filesystem::path userCacheDirectory();

/// Whether windows can be shown.
bool hasDesktop();

/// A function of a library, which stays loaded. @return null if it is not there
void* functionOf(const char* library, const char* name);
/// Continues as another program, which is searched in $PATH. @return errno: it could not be started
int becomeProgram(std::vector<std::string> words);

/// Peak memory of this process since its start or the last resetPeakMemory(), in MB of 2^20 bytes;
/// 0 if the system does not report it.
double peakMegabytes();
void resetPeakMemory();
/// Gives unused memory back to the system.
void releaseMemory();
/// Fills allocated memory, so that what a library reads before it writes does not differ from run
/// to run.
void fillNewMemory();

} // namespace altiro3D::tools
