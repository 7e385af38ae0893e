#pragma once

#include <cstdio>
#include <string>

/// The one place that writes to standard output and standard error: whole lines, in the order in
/// which they were written, and on a terminal one status line, which is taken away before them.
namespace altiro3D::tools {

/// Writes a line at once and in one piece.
/// @param stream stdout or stderr @param line without its end
void writeLine(std::FILE* stream, const std::string& line);

/// Whether a status line can be seen: standard error is a terminal.
bool hasStatusLine();
/// Shows a status line in the place of the last one, cut off at the terminal's edge; nothing where
/// hasStatusLine() is false.
void showStatus(const std::string& text);
/// Takes the status line away.
void clearStatus();

} // namespace altiro3D::tools
