#pragma once

#include "viewer/model/studio.hpp"

#include <atomic>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace altiro3D::viewer {

class DepthMaker;

/// A photo or quilt of which a Native is exported.
struct BatchItem {
    Source source;
    Knobs knobs;
    std::filesystem::path native; ///< The file to write, which is replaced if it exists.
    /// What was painted on its depth, by the source of the depth (DepthMaker::choose()).
    std::map<std::string, PaintedDepth> painted;
};

/// What became of a batch.
struct BatchReport {
    std::size_t written = 0;
    std::vector<std::string> problems; ///< One sentence for each file that was not exported.
    bool cancelled = false;
};

/// Names the Natives of many files in one folder, as photo2native names those of a folder:
/// `a.jpg` becomes `a_native.png`. Files of the same name in several folders get a number.
std::vector<std::filesystem::path> nativesOf(const std::vector<Source>& sources,
                                             const std::filesystem::path& folder);

/// Exports the Natives one after the other, each with the bytes of a single export. A file that
/// cannot be exported is reported and the others follow; videos and finished Natives are reported.
/// @param progress receives 0..1; returns false to cancel. What is written then stays.
BatchReport exportBatch(const std::vector<BatchItem>& items,
                        const std::shared_ptr<const Display>& display,
                        const std::shared_ptr<DepthMaker>& depthMaker, const Progress& progress);

} // namespace altiro3D::viewer
