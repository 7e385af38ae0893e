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

/// A picture (SVG) of accuracy over time, logarithmic in time. Settings that no other one beats in
/// both are joined by a line.
std::string tradePlotSvg(const std::vector<TradePoint>& points, const std::string& title);

} // namespace altiro3D::tools
