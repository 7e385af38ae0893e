#pragma once

#include <string>
#include <vector>

namespace altiro3D::tools {

/// One setting in the plot.
struct TradePoint {
    std::string name;        ///< Label.
    double milliseconds = 0; ///< Per view, > 0.
    double decibels = 0;     ///< Accuracy.
};

/// A plot of accuracy over time as SVG, with a logarithmic time axis. A line joins the settings
/// that no other setting beats in both.
std::string tradePlotSvg(const std::vector<TradePoint>& points, const std::string& title);

} // namespace altiro3D::tools
