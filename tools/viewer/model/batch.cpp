#include "viewer/model/batch.hpp"

#include "altiro3D/error.hpp"
#include "cli/folder_search.hpp"
#include "cli/run_tool.hpp"
#include "viewer/model/depth_maker.hpp"

#include <algorithm>
#include <set>

namespace altiro3D::viewer {

namespace fs = std::filesystem;

namespace {

bool isOneOf(const std::vector<BatchItem>& items, const fs::path& file) {
    return std::any_of(items.begin(), items.end(), [&file](const BatchItem& item) {
        std::error_code error;
        return fs::equivalent(item.source.file, file, error) ||
               (!item.source.depth.empty() && fs::equivalent(item.source.depth, file, error));
    });
}

// What an export of the open picture takes, made here from its file.
Setup setupOf(const BatchItem& item, const std::shared_ptr<const Display>& display,
              const DepthMaker& depthMaker, Studio& studio) {
    constexpr int kLookSide = 16; // px of a picture that nobody looks at
    const std::string name = item.source.file.string();
    if (isVideoName(item.source.file))
        throw Error(ErrorCode::Unsupported, name,
                    "is a video, expected a photo; video2native converts videos");
    const auto document = std::make_shared<const Document>(readDocument(item.source, *display));
    if (document->kind == Kind::Native)
        throw Error(ErrorCode::Unsupported, name,
                    "is a Native, which is finished, expected a photo or a quilt");
    if (document->kind != Kind::Scene) return {document, {}, {}, false, item.knobs, display};
    Knobs plain = item.knobs; // what is automatic is chosen by the export itself
    plain.automatic = {};
    const auto painted =
        item.painted.find(depthMaker.choose(item.knobs.depth, !document->rawDepth.empty()));
    Request request{document, plain, display, Mode::Depth, 0, {kLookSide, kLookSide}, {}};
    if (painted != item.painted.end()) request.painted = painted->second;
    Setup setup = studio.render(request).setup;
    setup.knobs = item.knobs;
    setup.isChosen = false;
    layFlatDepth(setup);
    return setup;
}

} // namespace

std::vector<fs::path> nativesOf(const std::vector<Source>& sources, const fs::path& folder) {
    std::vector<tools::FolderFile> files;
    for (const Source& source : sources) {
        fs::path file = source.file;
        if (!file.has_filename()) file = file.parent_path(); // "views/"
        files.push_back({file, {}, {}});
    }
    std::vector<fs::path> natives;
    std::set<std::string> taken;
    for (const std::string& stem : tools::outputStems(files)) {
        std::string name = stem;
        for (int number = 2; !taken.insert(name).second; ++number)
            name = stem + "-" + std::to_string(number);
        natives.push_back(folder / (name + "_native.png"));
    }
    return natives;
}

BatchReport exportBatch(const std::vector<BatchItem>& items,
                        const std::shared_ptr<const Display>& display,
                        const std::shared_ptr<DepthMaker>& depthMaker, const Progress& progress) {
    BatchReport report;
    Studio studio(depthMaker);
    for (std::size_t i = 0; i < items.size(); ++i) {
        const auto tell = [&](double done) {
            return progress((static_cast<double>(i) + done) / static_cast<double>(items.size()));
        };
        try {
            if (!tell(0)) {
                report.cancelled = true;
                break;
            }
            if (isOneOf(items, items[i].native))
                throw Error(ErrorCode::WriteFailed, items[i].native.string(),
                            "is one of the photos, expected another folder");
            const Setup setup = setupOf(items[i], display, *depthMaker, studio);
            if (writeProduct(setup, Product::Native, items[i].native, tell).empty()) {
                report.cancelled = true;
                break;
            }
            ++report.written;
        } catch (const std::exception& error) {
            report.problems.push_back(tools::sentenceOf(error));
        }
    }
    if (!report.cancelled && !items.empty()) progress(1);
    return report;
}

} // namespace altiro3D::viewer
