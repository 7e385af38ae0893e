// Exports: one picture, or all open files.

#include "viewer/model/controller.hpp"

#include "altiro3D/error.hpp"
#include "cli/folders.hpp"
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
    const std::string name = item.source.file.string();
    if (isVideoName(item.source.file))
        throw Error(ErrorCode::Unsupported, name,
                    "is a video, expected a photo; \"Export video\" converts videos");
    const auto document = std::make_shared<const Document>(readDocument(item.source, *display));
    if (document->kind == Kind::Native)
        throw Error(ErrorCode::Unsupported, name,
                    "is a Native, which is finished, expected a photo or a quilt");
    const auto painted =
        item.painted.find(depthMaker.choose(item.knobs.depth, document->hasDepth()));
    return studio.prepare({document, item.knobs, display,
                           painted != item.painted.end() ? painted->second : PaintedDepth()});
}

// Exports the Natives one after the other, each with the bytes of a single export. A file that
// cannot be exported is reported and the others follow; videos and finished Natives are reported.
// @param progress receives 0..1; returns false to cancel. What is written then stays.
BatchReport exportBatch(const std::vector<BatchItem>& items,
                        const std::shared_ptr<const Display>& display,
                        const std::shared_ptr<DepthMaker>& depthMaker, const Progress& progress) {
    BatchReport report;
    Studio studio(depthMaker);
    for (std::size_t i = 0; i < items.size(); ++i) {
        const auto tell = [&](double done) {
            return progress((static_cast<double>(i) + done) / static_cast<double>(items.size()));
        };
        report.cancelled = !tell(0);
        if (report.cancelled) break;
        try {
            if (isOneOf(items, items[i].native))
                throw Error(ErrorCode::WriteFailed, items[i].native.string(),
                            "is one of the photos, expected another folder");
            const Setup setup = setupOf(items[i], display, *depthMaker, studio);
            report.cancelled = writeProduct(setup, Product::Native, items[i].native, tell).empty();
            if (report.cancelled) break;
            ++report.written;
        } catch (const std::exception& error) {
            report.problems.push_back(tools::sentenceOf(error));
        }
    }
    if (!report.cancelled && !items.empty()) progress(1);
    return report;
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

QString Controller::exportObstacle() const {
    if (exporting_) return tr("Another export is under way; export again when it is done");
    if (!document_) return tr("Nothing is open that could be exported");
    if (!frame_.setup.document || frameReading_ != readings_)
        return tr("The file is still being opened; export again when its picture is shown");
    if (frame_.knobs.depth != knobs_.depth)
        return tr("The depth is still being estimated; export again when the picture shows it");
    if (frame_.setup.painted.revision != paintedNow().revision)
        return tr("The depth is still being changed; export again when the picture shows it");
    return {};
}

Setup Controller::exportSetup() const {
    Setup setup = frame_.setup;
    setup.knobs = knobs_;
    setup.isDraft = false;
    setup.eyes = eyes_;
    return setup;
}

Progress Controller::beginExport() {
    exporting_ = true;
    cancelling_ = false;
    return [this](double done) {
        later(this, [this, done] { emit exportProgress(done); });
        return !cancelling_;
    };
}

bool Controller::startExport(Product product, const fs::path& target) {
    if (!exportObstacle().isEmpty()) return false;
    exporter_.post(0, [this, setup = exportSetup(), product, target, tell = beginExport(),
                       revision = paintedNow().revision] {
        QString file;
        QString problem;
        try {
            file = QString::fromStdString(writeProduct(setup, product, target, tell));
        } catch (const std::exception& error) {
            problem = QString::fromStdString(tools::sentenceOf(error));
        }
        later(this, [this, file, problem, product, revision] {
            exporting_ = false;
            if (product == Product::Depth && !file.isEmpty()) setSaved(revision);
            emit exportEnded(file, problem);
        });
    });
    return true;
}

Knobs Controller::videoKnobs() const {
    Knobs knobs = knobs_;
    knobs.depth = depthMaker_->choose(knobs_.depth, document_->hasDepth());
    return knobs;
}

QString Controller::videoExportObstacle() const {
    if (exporting_) return tr("Another export is under way; export again when it is done");
    if (opening_ || !document_ || !document_->video) return tr("Open a video first");
    return QString::fromStdString(viewer::videoExportObstacle(*document_, videoKnobs()));
}

bool Controller::startVideoExport(const fs::path& file, bool goesOn) {
    if (!videoExportObstacle().isEmpty()) return false;
    setPlaying(false);
    const Knobs knobs = videoKnobs();
    Display display = *display_;
    if (document_->kind == Kind::Scene) display.quilt = layoutOf(knobs, display);
    cancelling_ = false;
    exporting_ = true;
    exporter_.post(0, [this, job = videoJobOf(*document_, knobs, display, file, goesOn), display] {
        VideoExportResult result;
        QString problem;
        try {
            result = exportVideo(job, display, [this](const VideoExportState& state) {
                later(this, [this, state] { emit videoExportProgress(state); });
                return !cancelling_;
            });
        } catch (const std::exception& error) {
            problem = QString::fromStdString(tools::sentenceOf(error));
        }
        later(this, [this, result, problem] {
            exporting_ = false;
            emit videoExportEnded(result, problem);
        });
    });
    return true;
}

std::vector<BatchItem> Controller::batch(const fs::path& folder) const {
    const std::vector<fs::path> natives = nativesOf(sources_, folder);
    std::vector<BatchItem> items;
    for (std::size_t i = 0; i < sources_.size(); ++i) {
        items.push_back({sources_[i], knobsOf(sources_[i].file), natives[i], {}});
        for (const auto& [key, painted] : painted_) {
            const auto& [file, depth, reading, from] = key;
            if (file == sources_[i].file && depth == sources_[i].depth &&
                reading == static_cast<int>(sources_[i].reading))
                items.back().painted[from] = painted.depth;
        }
    }
    return items;
}

bool Controller::startExportAll(const fs::path& folder) {
    if (exporting_ || sources_.empty()) return false;
    exporter_.post(0, [this, items = batch(folder), display = display_, maker = depthMaker_,
                       tell = beginExport()] {
        const BatchReport report = exportBatch(items, display, maker, tell);
        later(this, [this, report] {
            exporting_ = false;
            emit exportAllEnded(report);
        });
    });
    return true;
}

} // namespace altiro3D::viewer
