#pragma once

#include "altiro3D/qt/display_search.hpp"
#include "cli/run_tool.hpp"

#include <string>
#include <vector>

namespace altiro3D::viewer {

/// Whether a desktop is available to open windows on.
bool hasDesktop();

/// The screens of the application, in its order.
std::vector<qt::ScreenFacts> screenFacts();

/// The known properties of a screen: "HDMI-1, LKG-P00655, 1536 x 2048 px".
std::string textOf(const qt::ScreenFacts& screen);

/// Prints the displays, screens and volumes found, for people or (JSON) for programs.
int listDisplays(int& argc, char** argv, bool json, tools::Messages& messages);

} // namespace altiro3D::viewer
