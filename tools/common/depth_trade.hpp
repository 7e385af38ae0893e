#pragma once

#include "altiro3D/depth_refine.hpp"
#include "altiro3D/depth_source.hpp"
#include "altiro3D/trade.hpp"

#include <memory>
#include <string>
#include <vector>

namespace altiro3D::tools {

class Messages;

/// A source of estimated depth, with a name for tables: "altiro3d, 256 px".
struct NamedDepthSource {
    std::string name;
    std::unique_ptr<DepthSource> source;
};

/// The sources worth comparing: the built-in estimator, and each installed network that is not
/// large, with its own input size and with half of it if it can run with that. A network that
/// cannot be loaded is left out with a warning.
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
DepthRow measureDepth(const NamedDepthSource& source, const StereoScene& scene,
                      const DepthRefineOptions& refine);

/// The mean of each source over the scenes.
/// @param rows the same sources for each scene
std::vector<DepthRow> meansOf(const std::vector<DepthRow>& rows, std::size_t sources);

/// Heading of a table, and one line of it.
extern const char* const kDepthHeading;
std::string lineOf(const DepthRow& row);

} // namespace altiro3D::tools
