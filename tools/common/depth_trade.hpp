#pragma once

#include "altiro3D/depth_map.hpp"
#include "altiro3D/depth_source.hpp"
#include "altiro3D/trade.hpp"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace altiro3D::tools {

class Messages;

/// A source of estimated depth that can be loaded, with a name for tables: "altiro3d, 256 px".
struct NamedDepthSource {
    std::string name;
    /// Loads the source. Throws Error if its network cannot be loaded or cannot run with this size.
    std::function<std::unique_ptr<DepthSource>()> load;
    bool isUsual = true; ///< False for a network with another input size than its own.
};

/// The sources worth comparing, best first: each installed network that is not large, with its own
/// input size and with half of it. The first one is the default.
/// @param messages must outlive the sources, which report doubts about a network's file
std::vector<NamedDepthSource> depthSources(Messages& messages);

/// Cost and accuracy of one source on one scene.
struct DepthRow {
    std::string scene;
    std::string source;
    double milliseconds = 0;    ///< For one photo, the fastest of three runs.
    double rankCorrelation = 0; ///< With the true depth, -1..1.
    /// Of the view by method Layered, whose depth is scaled and shifted to the true one.
    ViewAccuracy accuracy;
};

/// @param refine how the depth is refined before views are made
DepthRow measureDepth(const std::string& name, DepthSource& source, const StereoScene& scene,
                      const DepthRefineOptions& refine);

/// Adds a share of an accuracy to a mean of several.
void addShare(double share, const ViewAccuracy& part, ViewAccuracy& mean);

/// The mean of each source over the scenes.
/// @param rows the same sources for each scene
std::vector<DepthRow> meansOf(const std::vector<DepthRow>& rows, std::size_t sources);

/// Heading of a table, and one line of it.
extern const char* const kDepthHeading;
std::string lineOf(const DepthRow& row);

} // namespace altiro3D::tools
