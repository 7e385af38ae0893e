#pragma once

#include <cstdio>
#include <string>

/// All writing to standard output and standard error: whole lines in order and, on a terminal, one
/// status line, which is erased before each line.
namespace altiro3D::tools {

/// Writes a line and flushes it.
/// @param stream stdout or stderr @param line without its end
void writeLine(std::FILE* stream, const std::string& line);

/// Whether a status line is visible, i.e. standard error is a terminal.
bool hasStatusLine();
/// Replaces the status line; the text is cut off at the terminal's edge. Does nothing if
/// hasStatusLine() is false.
void showStatus(const std::string& text);
/// Erases the status line.
void clearStatus();

} // namespace altiro3D::tools
